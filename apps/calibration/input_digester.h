#pragma once

#include <string>
#include <thread>
#include <vector>

#include "core/quality/result_evidence.h"

namespace rigcal {

/// Digests the inputs of a run on a thread of its own while they are used.
class InputDigester {
 public:
  explicit InputDigester(std::vector<std::string> paths);
  /// Waits for the end. Leaving without asking stops it.
  [[nodiscard]] std::vector<InputDigest> take();

 private:
  std::vector<InputDigest> digests_;
  std::jthread thread_;  ///< Last, so that it ends before what it writes to.
};

}  // namespace rigcal
