#pragma once

#include <string>

#include "core/base/error.h"

struct _GError;

namespace rigcal::camera {

/// What Aravis says went wrong with one call.
class Problem {
 public:
  Problem() = default;
  ~Problem();
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;

  /// To be handed to a call; what was there before is forgotten.
  [[nodiscard]] _GError** put();
  [[nodiscard]] bool is_none() const { return error_ == nullptr; }
  [[nodiscard]] std::string text() const;
  [[nodiscard]] bool is_absent() const;   ///< There is no such device.
  [[nodiscard]] bool is_held() const;     ///< Another program controls it.
  [[nodiscard]] bool is_refusal() const;  ///< The camera answers, but does not do it.

  /// Nothing, or an Error of kind system: what was tried, and why it did not work.
  [[nodiscard]] Expected<void> result(const std::string& tried, const std::string& where,
                                      const std::string& mend = {}) const;

 private:
  _GError* error_ = nullptr;
};

}  // namespace rigcal::camera
