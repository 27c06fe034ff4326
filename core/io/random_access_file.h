#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/file_descriptor.h"

namespace rigcal {

/// A regular file that is read at any place. Not thread-safe.
class RandomAccessFile {
 public:
  /// Errors: those of `cannot_read`, a folder, a device, empty.
  [[nodiscard]] static Expected<RandomAccessFile> open(const std::string& path);

  /// Fills all of `bytes` from `offset` on; false where the file ends before or cannot be read (`failure`).
  [[nodiscard]] bool read_at(std::uint64_t offset, std::span<std::uint8_t> bytes) const;
  /// Bytes, as it was when it was opened.
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// What went wrong when reading ("Input/output error"); empty where all went well or the file just ended.
  [[nodiscard]] const std::string& failure() const { return failure_; }
  /// For who reads it from its beginning on by other means.
  [[nodiscard]] FileDescriptor release() && { return std::move(file_); }

 private:
  RandomAccessFile(FileDescriptor file, std::uint64_t size, std::string path)
      : file_(std::move(file)), size_(size), path_(std::move(path)) {}

  FileDescriptor file_;
  std::uint64_t size_ = 0;
  std::string path_;
  mutable std::string failure_;
};

}  // namespace rigcal
