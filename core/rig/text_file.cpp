#include "core/rig/text_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include "core/base/system_call.h"

namespace rigcal {

Error read_failure(const std::string& path, const std::string& why) {
  return system_error("cannot be read to its end (" + why + ")", path,
                      "try again, or save what the disk still gives to another one (ddrescue) and use that copy");
}

Error cannot_read(const std::string& path, int code) {
  switch (code) {
    case ENOENT:
    case ENOTDIR:
      return input_error("there is no such file", path, "check the name");
    case EACCES:
    case EPERM:
      return input_error("no permission to read it", path, "change its permissions or run as its owner");
    case EISDIR:
      return input_error("is a folder, not a file", path, "name a file in it");
    case ELOOP:
    case ENAMETOOLONG:
      return input_error(std::string("cannot be read (") + std::strerror(code) + ")", path, mend_of(code));
    case EMFILE:
    case ENFILE:
    case ENOMEM:
    case ENODEV:
    case ENXIO:
      // Nothing was asked of a disk yet.
      return system_error(std::string("cannot be read (") + std::strerror(code) + ")", path, mend_of(code));
    default:
      return read_failure(path, std::strerror(code));
  }
}

Expected<void> check_there(const std::string& path) {
  std::error_code error;
  const bool there = std::filesystem::exists(path, error);
  if (error) return cannot_read(path, error.value());
  if (!there) return input_error("no such file or folder", path, "check the path");
  return {};
}

Expected<std::string> read_text_file(const std::string& path, std::size_t max_bytes) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) return cannot_read(path, errno);
  struct stat status = {};
  if (fstat(fileno(file.get()), &status) != 0) return cannot_read(path, errno);
  if (S_ISDIR(status.st_mode)) return cannot_read(path, EISDIR);
  std::string text;
  char chunk[65536];
  while (const std::size_t got = std::fread(chunk, 1, sizeof(chunk), file.get())) {
    text.append(chunk, got);
    if (text.size() > max_bytes) {
      return input_error("is longer than the " + std::to_string(max_bytes / 1024) + " KiB such a file may have", path,
                         "check that it is the right file");
    }
  }
  if (std::ferror(file.get()) != 0) return cannot_read(path, errno);
  return text;
}

}  // namespace rigcal
