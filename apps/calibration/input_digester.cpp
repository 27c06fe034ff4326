#include "apps/calibration/input_digester.h"

#include <utility>

#include "core/report/input_digest.h"

namespace rigcal {

InputDigester::InputDigester(std::vector<std::string> paths)
    : thread_(
          [this, inputs = std::move(paths)](const std::stop_token& stop) { digests_ = digest_inputs(inputs, stop); }) {}

std::vector<InputDigest> InputDigester::take() {
  thread_.join();
  return std::move(digests_);
}

}  // namespace rigcal
