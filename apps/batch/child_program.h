#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace rigcal::batch {

/// How a child came to its end.
struct ChildEnd {
  int code = -1;   ///< Exit code; -1 where a signal ended it.
  int signal = 0;  ///< That ended it; 0: none.
  double cpu_s = 0.0;
  double peak_memory_mb = 0.0;
};

/// This very program as a child that says everything into a file and hears no Ctrl-C meant for its parent: it is in a
/// process group of its own, and is told to stop by `stop`. It goes on where its parent is killed.
class ChildProgram {
 public:
  /// `kept_descriptor` stays open in it, -1: none. Errors: the system refused.
  [[nodiscard]] static Expected<ChildProgram> start(const std::vector<std::string>& arguments, const std::string& log,
                                                    int kept_descriptor);

  /// Nothing while it runs; once it has ended, how, and never asked again.
  [[nodiscard]] std::optional<ChildEnd> ended() const;
  /// As Ctrl-C would.
  void stop() const;
  [[nodiscard]] pid_t id() const { return id_; }

 private:
  explicit ChildProgram(pid_t id) : id_(id) {}
  pid_t id_;
};

}  // namespace rigcal::batch
