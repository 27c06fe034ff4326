#pragma once

#include <optional>
#include <string>

#include "core/base/file_descriptor.h"

namespace rigcal {

/// Held by whoever records a session or mends it, so that nobody else does at the same time: a lock of the system
/// (flock) on its folder. It ends with the process that has it, however that one ends, and leaves nothing behind. A
/// program on another machine that shares the disk does not see it: file systems pass locks on files along, not those
/// on folders.
class SessionLock {
 public:
  /// Nothing where somebody else has it. Where there are no locks to be had it is one that keeps nobody out: that must
  /// not be why a recording ends.
  [[nodiscard]] static std::optional<SessionLock> take(const std::string& session);

 private:
  explicit SessionLock(FileDescriptor folder) : folder_(std::move(folder)) {}
  FileDescriptor folder_;
};

}  // namespace rigcal
