#include "core/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/base/system_call.h"

namespace rigcal {
namespace {

constexpr std::size_t buffer_bytes = std::size_t{1} << 20;
constexpr std::size_t max_reserve_bytes = std::size_t{128} << 10;

/// A rename is on the disk only once its folder is.
void sync_folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const FileDescriptor opened(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.is_open()) ::fsync(opened.get());
}

/// The part of a path that is a file though it should be a folder; empty: none.
std::string file_within(const std::string& path) {
  std::error_code error;
  for (std::filesystem::path part = path; part.has_relative_path(); part = part.parent_path()) {
    if (std::filesystem::exists(part, error)) return std::filesystem::is_directory(part, error) ? "" : part.string();
  }
  return {};
}

}  // namespace

Error cannot_write(const std::string& path, int code) {
  switch (code) {
    case ENOTDIR:
      if (const std::string file = file_within(path); !file.empty()) {
        return system_error("cannot be made, " + (file == path ? "it" : file) + " is a file and no folder", path,
                            "choose another place, or move that file away");
      }
      [[fallthrough]];
    case ENOENT:
      return system_error("cannot be made, its folder does not exist", path, "make the folder first");
    case EACCES:
    case EPERM:
      return system_error("no permission to write it", path, "choose another place or change its permissions");
    case ENOSPC:
      return system_error("the disk is full", path, "make room or choose another disk");
    case EISDIR:
      return system_error("is a folder", path, "choose another name");
    case ENAMETOOLONG:
      return system_error("its name is too long", path, "choose a shorter one");
    default:
      return system_error(std::string("cannot be written (") + std::strerror(code) + ")", path, mend_of(code));
  }
}

OutputFile::OutputFile(FileDescriptor file, std::string path)
    : file_(std::move(file)), path_(std::move(path)), buffer_(buffer_bytes) {}

Expected<OutputFile> OutputFile::create(const std::string& path) {
  FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (!file.is_open()) return cannot_write(path, errno);
  return OutputFile(std::move(file), path);
}

OutputFile::OutputFile(OutputFile&& other) noexcept { *this = std::move(other); }

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  if (this == &other) return *this;
  close_quietly();
  file_ = std::move(other.file_);
  path_ = std::move(other.path_);
  buffer_ = std::move(other.buffer_);
  used_ = std::exchange(other.used_, 0);
  written_ = other.written_;
  failed_ = other.failed_;
  error_ = std::move(other.error_);
  return *this;
}

OutputFile::~OutputFile() { close_quietly(); }

void OutputFile::close_quietly() {
  if (file_.is_open()) static_cast<void>(close());
}

void OutputFile::fail(const char* doing, int code) {
  if (failed_) return;
  failed_ = true;
  error_ = cannot_write(path_, code);
  if (code == EIO) error_.what += std::string(" while ") + doing;
}

Expected<void> OutputFile::status() const {
  if (failed_) return error_;
  return {};
}

void OutputFile::write_through(const std::uint8_t* bytes, std::size_t size) {
  while (size > 0 && !failed_) {
    const ssize_t got = ::write(file_.get(), bytes, size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      fail("writing", errno);
      return;
    }
    bytes += got;
    size -= static_cast<std::size_t>(got);
    written_ += static_cast<std::uint64_t>(got);
  }
}

void OutputFile::write(ByteView bytes) {
  if (bytes.empty()) return;
  if (used_ + bytes.size() > buffer_.size()) static_cast<void>(flush());
  if (bytes.size() > buffer_.size()) {
    write_through(bytes.data(), bytes.size());
    return;
  }
  std::memcpy(buffer_.data() + used_, bytes.data(), bytes.size());
  used_ += bytes.size();
}

void OutputFile::write(std::string_view text) {
  write(ByteView(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::uint8_t* OutputFile::reserve(std::size_t size) {
  RIGCAL_ASSERT(size <= max_reserve_bytes, "reserve of " + std::to_string(size) + " bytes");
  if (used_ + size > buffer_.size()) static_cast<void>(flush());
  std::uint8_t* room = buffer_.data() + used_;
  used_ += size;
  return room;
}

void OutputFile::overwrite(std::uint64_t offset, std::string_view text) {
  static_cast<void>(flush());
  RIGCAL_ASSERT(failed_ || offset + text.size() <= written_, "overwrite past the end of " + path_);
  if (failed_) return;
  const ssize_t got = ::pwrite(file_.get(), text.data(), text.size(), static_cast<off_t>(offset));
  if (got != static_cast<ssize_t>(text.size())) fail("writing", got < 0 ? errno : EIO);
}

Expected<void> OutputFile::flush() {
  write_through(buffer_.data(), used_);
  used_ = 0;
  return status();
}

Expected<void> OutputFile::begin_sync() {
  static_cast<void>(flush());
  // Not every file system can; then the last sync takes longer.
  if (!failed_) static_cast<void>(::sync_file_range(file_.get(), 0, 0, SYNC_FILE_RANGE_WRITE));
  return status();
}

Expected<void> OutputFile::sync() {
  static_cast<void>(flush());
  if (!failed_ && ::fdatasync(file_.get()) != 0 && errno != EINVAL && errno != EROFS) fail("syncing", errno);
  return status();
}

Expected<void> OutputFile::close() {
  if (!file_.is_open()) return status();
  static_cast<void>(flush());
  if (::close(file_.release()) != 0 && errno != EINTR) fail("closing", errno);
  return status();
}

Expected<void> replace_file(const std::string& path, std::string_view text) {
  const std::string temporary = path + ".tmp" + std::to_string(::getpid());
  Expected<OutputFile> file = OutputFile::create(temporary);
  if (!file) return Error{file.error().kind, file.error().what, path, file.error().mend};
  file->write(text);
  Expected<void> done = file->sync();
  if (done) done = file->close();
  if (done && std::rename(temporary.c_str(), path.c_str()) != 0) done = cannot_write(path, errno);
  if (!done) {
    ::unlink(temporary.c_str());
    return Error{done.error().kind, done.error().what, path, done.error().mend};
  }
  sync_folder_of(path);
  return {};
}

}  // namespace rigcal
