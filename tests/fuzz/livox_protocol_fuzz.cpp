// Arbitrary datagrams, answers, steps in time and wishes of a user: bounded output, legal states, always an end.
#include "tests/support/protocol_walk.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  rigcal::livox::ProtocolWalk::run({bytes, size});
  return 0;
}
