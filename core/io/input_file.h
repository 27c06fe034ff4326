#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/base/file_descriptor.h"

namespace rigcal {

/// Asked where a file that is still being written ends for now: waits a little and says whether to look for more. After
/// false the file is read to the end that it has then, and that is its end.
using AwaitGrowth = std::function<bool()>;

/// A file, or a pipe, read once from front to back through a buffer. The buffer grows only to hold bytes that are
/// really there, so that a size in a hostile file costs no memory. Not thread-safe.
class InputFile {
 public:
  /// Errors: those of `cannot_read`.
  [[nodiscard]] static Expected<InputFile> open(const std::string& path, AwaitGrowth await_growth = {});

  /// The next `size` bytes, or what is left where the file ends before. The view lives until the next call.
  [[nodiscard]] ByteView take(std::size_t size) {
    const ByteView bytes = peek(size);
    begin_ += bytes.size();
    return bytes;
  }
  /// The same without moving on.
  [[nodiscard]] ByteView peek(std::size_t size) {
    if (end_ - begin_ < size) fill(size);
    return {buffer_.data() + begin_, end_ - begin_ < size ? end_ - begin_ : size};
  }
  /// Moves on by `size` bytes; false where fewer are left.
  bool skip(std::uint64_t size);

  /// Of the next byte, from the start of the file.
  [[nodiscard]] std::uint64_t offset() const { return read_ - (end_ - begin_); }
  /// Of the whole file when it was opened; nothing for a pipe.
  [[nodiscard]] std::optional<std::uint64_t> size() const { return size_; }
  /// What went wrong when reading ("Input/output error"); empty where all went well or the file just ended.
  [[nodiscard]] const std::string& failure() const { return failure_; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  InputFile(FileDescriptor file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}
  void fill(std::size_t size);

  FileDescriptor file_;
  std::string path_;
  AwaitGrowth await_growth_;  ///< Empty: the file's end is its end.
  std::optional<std::uint64_t> size_;
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;   ///< Of the bytes not yet taken.
  std::size_t end_ = 0;     ///< Of the bytes read.
  std::uint64_t read_ = 0;  ///< Bytes read off the file so far.
  std::string failure_;
};

}  // namespace rigcal
