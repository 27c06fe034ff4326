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
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return cannot_read(path, errno);
  InputFile file(descriptor, path);
  struct stat status = {};
  if (fstat(descriptor, &status) != 0) return cannot_read(path, errno);
  if (S_ISDIR(status.st_mode)) return cannot_read(path, EISDIR);
  if (S_ISREG(status.st_mode)) file.size_ = static_cast<std::uint64_t>(status.st_size);
  file.buffer_.resize(buffer_bytes);
  file.await_growth_ = std::move(await_growth);
  return file;
}

InputFile::InputFile(InputFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      path_(std::move(other.path_)),
      await_growth_(std::move(other.await_growth_)),
      size_(other.size_),
      buffer_(std::move(other.buffer_)),
      begin_(std::exchange(other.begin_, 0)),
      end_(std::exchange(other.end_, 0)),
      read_(other.read_),
      failure_(std::move(other.failure_)) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  if (this == &other) return *this;
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = std::exchange(other.descriptor_, -1);
  path_ = std::move(other.path_);
  await_growth_ = std::move(other.await_growth_);
  size_ = other.size_;
  buffer_ = std::move(other.buffer_);
  begin_ = std::exchange(other.begin_, 0);
  end_ = std::exchange(other.end_, 0);
  read_ = other.read_;
  failure_ = std::move(other.failure_);
  return *this;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void InputFile::fill(std::size_t size) {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  while (end_ < size) {
    if (end_ == buffer_.size()) buffer_.resize(std::min(size, 2 * buffer_.size()));
    const ssize_t got = ::read(descriptor_, buffer_.data() + end_, buffer_.size() - end_);
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
