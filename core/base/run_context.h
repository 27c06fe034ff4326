#pragma once

#include <stop_token>
#include <string>
#include <string_view>

namespace rigcal {

/// Where long work says how far it is and what it noticed. Implementations must be callable from any thread.
class Reporter {
 public:
  virtual ~Reporter() = default;
  /// `fraction` in 0 .. 1 of the stage named, or negative where the end is not known.
  virtual void progress(std::string_view stage, double fraction) = 0;
  /// A sentence for the user, also kept in report.json.
  virtual void warn(std::string message) = 0;
  virtual void debug(std::string message) = 0;
};

/// A Reporter that says nothing, for tests and libraries.
class SilentReporter final : public Reporter {
 public:
  void progress(std::string_view, double) override {}
  void warn(std::string) override {}
  void debug(std::string) override {}
};

/// Goes through every stage from the start: how to stop and whom to tell.
struct RunContext {
  Reporter& reporter;
  std::stop_token stop = {};

  [[nodiscard]] bool cancelled() const { return stop.stop_requested(); }
};

}  // namespace rigcal
