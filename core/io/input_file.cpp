#include "core/io/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/rig/text_file.h"

namespace rigcal {
namespace {

constexpr std::size_t buffer_bytes = std::size_t{1} << 20;

}  // namespace

Expected<InputFile> InputFile::open(const std::string& path, AwaitGrowth await_growth) {
  FileDescriptor opened(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!opened.is_open()) return cannot_read(path, errno);
  InputFile file(std::move(opened), path);
  struct stat status = {};
  if (fstat(file.file_.get(), &status) != 0) return cannot_read(path, errno);
  if (S_ISDIR(status.st_mode)) return cannot_read(path, EISDIR);
  if (S_ISREG(status.st_mode)) file.size_ = static_cast<std::uint64_t>(status.st_size);
  file.buffer_.resize(buffer_bytes);
  file.await_growth_ = std::move(await_growth);
  return file;
}

void InputFile::fill(std::size_t size) {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  while (end_ < size) {
    if (end_ == buffer_.size()) buffer_.resize(std::min(size, 2 * buffer_.size()));
    const ssize_t got = ::read(file_.get(), buffer_.data() + end_, buffer_.size() - end_);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) failure_ = std::strerror(errno);
    if (got == 0 && await_growth_) {
      if (!await_growth_()) await_growth_ = nullptr;  // And one more look: it may have grown before it was over.
      continue;
    }
    if (got <= 0) return;
    end_ += static_cast<std::size_t>(got);
    read_ += static_cast<std::uint64_t>(got);
  }
}

bool InputFile::skip(std::uint64_t size) {
  while (size > 0) {
    const ByteView bytes = take(static_cast<std::size_t>(std::min<std::uint64_t>(size, buffer_bytes)));
    if (bytes.empty()) return false;
    size -= bytes.size();
  }
  return true;
}

}  // namespace rigcal
