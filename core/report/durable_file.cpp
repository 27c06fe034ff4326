#include "core/report/durable_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace rigcal {
namespace {

Error refused(const std::string& what, const std::string& path) {
  const int code = errno;
  return system_error(what + " (" + std::strerror(code) + ")", path,
                      code == ENOSPC || code == EDQUOT ? "free disk space or choose another --out"
                                                       : "choose another --out or mend its permissions");
}

}  // namespace

DurableFile::~DurableFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Expected<void> DurableFile::create(const std::string& path) {
  path_ = path;
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) return refused("cannot make the file", path_);
  return {};
}

Expected<void> DurableFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return refused("cannot write", path_);
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

Expected<void> DurableFile::close() {
  const bool synced = ::fsync(descriptor_) == 0;
  const Error error = synced ? Error{} : refused("cannot bring the file to the disk", path_);
  ::close(descriptor_);
  descriptor_ = -1;
  if (!synced) return error;
  return {};
}

Expected<void> sync_folder(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return refused("cannot open the folder", path);
  const bool synced = ::fsync(descriptor) == 0;
  const Error error = synced ? Error{} : refused("cannot bring the folder to the disk", path);
  ::close(descriptor);
  if (!synced) return error;
  return {};
}

}  // namespace rigcal
