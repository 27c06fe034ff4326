#pragma once

#include <utility>

namespace rigcal {

/// What the system opened for us (a file, a folder, a socket, an event), closed with its owner. An error of closing is
/// told nobody: who wants to know it closes what `release` gives.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  /// As open() and the like gave it; below zero: nothing was opened.
  explicit FileDescriptor(int number) : number_(number) {}
  FileDescriptor(FileDescriptor&& other) noexcept : number_(other.release()) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor();

  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  [[nodiscard]] int get() const { return number_; }
  /// Closing it is the caller's from now on.
  [[nodiscard]] int release() { return std::exchange(number_, -1); }

 private:
  int number_ = -1;
};

}  // namespace rigcal
