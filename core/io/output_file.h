#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/base/file_descriptor.h"

namespace rigcal {

/// A file being written through a buffer of fixed size. Errors are of kind system and name the file. After the first
/// error every call gives it again, so a writer may be checked once at its `close`. The destructor closes, silently.
class OutputFile {
 public:
  /// Makes the file, or empties an existing one.
  [[nodiscard]] static Expected<OutputFile> create(const std::string& path);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  void write(ByteView bytes);
  void write(std::string_view text);
  /// `size` bytes of room in the buffer to be filled in before the next call; never more than 128 KiB.
  [[nodiscard]] std::uint8_t* reserve(std::size_t size);
  /// Writes `text` over what stands at `offset`, all of it written before.
  void overwrite(std::uint64_t offset, std::string_view text);
  [[nodiscard]] std::uint64_t size() const { return written_ + used_; }

  /// The first error, if any.
  [[nodiscard]] Expected<void> status() const;
  /// Hands everything to the system.
  Expected<void> flush();
  /// The same, and asks the system to begin to bring it to the disk, without waiting: so a later `sync` is short.
  Expected<void> begin_sync();
  /// The same, and waits until it is on the disk.
  Expected<void> sync();
  Expected<void> close();

 private:
  OutputFile(FileDescriptor file, std::string path);
  void fail(const char* doing, int code);
  void write_through(const std::uint8_t* bytes, std::size_t size);
  void close_quietly();

  FileDescriptor file_;
  std::string path_;
  std::vector<std::uint8_t> buffer_;
  std::size_t used_ = 0;
  std::uint64_t written_ = 0;
  bool failed_ = false;
  Error error_;
};

/// The error for a file or folder that could not be made or written, from `errno`-like `code`.
[[nodiscard]] Error cannot_write(const std::string& path, int code);

/// Replaces a file as a whole: writes beside it, waits for the disk, renames. Readers see the old or the new text.
Expected<void> replace_file(const std::string& path, std::string_view text);

}  // namespace rigcal
