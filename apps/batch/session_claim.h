#pragma once

#include <optional>
#include <string>

#include "core/base/error.h"

namespace rigcal::batch {

/// The right to work on one session, held against all other programs that share the folder, on other machines too: a
/// lock of the system (flock) on a file. It ends with the last process that has it open, however that one ends, so that
/// nothing is left to be cleared after a crash; a child that is given the descriptor holds it as well.
class SessionClaim {
 public:
  /// Nothing where somebody else has it. Errors: the file cannot be made, or the file system knows no locks.
  [[nodiscard]] static Expected<std::optional<SessionClaim>> take(const std::string& path);

  SessionClaim(SessionClaim&& other) noexcept;
  SessionClaim& operator=(SessionClaim&& other) noexcept;
  SessionClaim(const SessionClaim&) = delete;
  SessionClaim& operator=(const SessionClaim&) = delete;
  ~SessionClaim();

  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  explicit SessionClaim(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace rigcal::batch
