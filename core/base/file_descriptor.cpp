#include "core/base/file_descriptor.h"

#include <unistd.h>

namespace rigcal {

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  FileDescriptor closed(std::exchange(number_, other.release()));
  return *this;
}

FileDescriptor::~FileDescriptor() {
  if (is_open()) ::close(number_);
}

}  // namespace rigcal
