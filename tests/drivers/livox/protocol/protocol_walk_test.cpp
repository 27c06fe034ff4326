#include "tests/support/protocol_walk.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace rigcal::livox {
namespace {

// The invariants are the walk's own; the fuzz target runs it on better scripts.
TEST(ProtocolWalk, AnyScriptKeepsTheInvariants) {
  Random random(11);
  std::vector<std::uint8_t> script(2000);
  for (int run = 0; run < 300; ++run) {
    for (std::uint8_t& byte : script) byte = static_cast<std::uint8_t>(random.below(256));
    ProtocolWalk::run(script);
  }
}

}  // namespace
}  // namespace rigcal::livox
