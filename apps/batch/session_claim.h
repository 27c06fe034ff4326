#pragma once

#include <optional>
#include <string>

#include "core/base/error.h"
#include "core/base/file_descriptor.h"

namespace rigcal::batch {

/// The right to work on one session, held against all other programs that share the folder, on other machines too: a
/// lock of the system (flock) on a file. It ends with the last process that has it open, however that one ends, so that
/// nothing is left to be cleared after a crash; a child that is given the descriptor holds it as well.
class SessionClaim {
 public:
  /// Nothing where somebody else has it. Errors: the file cannot be made, or the file system knows no locks.
  [[nodiscard]] static Expected<std::optional<SessionClaim>> take(const std::string& path);

  [[nodiscard]] int descriptor() const { return file_.get(); }

 private:
  explicit SessionClaim(FileDescriptor file) : file_(std::move(file)) {}
  FileDescriptor file_;
};

}  // namespace rigcal::batch
