#include "drivers/livox/device/datagram_ring.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <thread>
#include <vector>

namespace rigcal::livox {
namespace {

const Endpoint from{{127, 0, 0, 21}, 60001};
const Endpoint to{{127, 0, 0, 1}, 56001};

/// What this program has of the machine's memory, MiB.
double resident_mib() {
  std::ifstream file("/proc/self/statm");
  double all = 0.0;
  double resident = 0.0;
  file >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1U << 20U);
}

TEST(DatagramRing, KeepsTheOrderAndCountsWhatDoesNotFit) {
  DatagramRing ring(5);
  ASSERT_EQ(ring.capacity(), 8U);
  std::vector<std::uint8_t> bytes(100);
  for (std::uint8_t i = 0; i < 12; ++i) {
    bytes[0] = i;
    EXPECT_EQ(ring.push({i, from, to, bytes}), i < 8);
  }
  EXPECT_EQ(ring.dropped(), 4U);
  EXPECT_EQ(ring.high_water(), 8U);
  Datagram datagram;
  for (std::uint8_t i = 0; i < 8; ++i) {
    ASSERT_TRUE(ring.peek(datagram));
    EXPECT_EQ(datagram.stamp_ns, i);
    EXPECT_EQ(datagram.bytes.size(), 100U);
    EXPECT_EQ(datagram.bytes[0], i);
    EXPECT_EQ(datagram.from, from);
    EXPECT_EQ(datagram.to, to);
    ring.pop();
  }
  EXPECT_FALSE(ring.peek(datagram));
  EXPECT_TRUE(ring.push({99, from, to, bytes}));
}

// There is one for each interface of the machine, and LiDARs are behind one of them.
TEST(DatagramRing, TakesNoMemoryBeforeItIsUsed) {
  const double before = resident_mib();
  DatagramRing ring(1U << 15U);
  EXPECT_LT(resident_mib() - before, 20.0);
  ring.take_memory();
  EXPECT_GT(resident_mib() - before, 40.0);
}

TEST(DatagramRing, RefusesWhatIsTooLong) {
  DatagramRing ring(4);
  const std::vector<std::uint8_t> bytes(DatagramRing::kLongest + 1);
  EXPECT_FALSE(ring.push({0, from, to, bytes}));
  EXPECT_EQ(ring.dropped(), 1U);
}

TEST(DatagramRing, TwoThreadsLoseNothingUncounted) {
  DatagramRing ring(64);
  constexpr std::uint32_t count = 200'000;
  std::thread writer([&] {
    std::vector<std::uint8_t> bytes(16);
    for (std::uint32_t i = 0; i < count; ++i) {
      std::memcpy(bytes.data(), &i, sizeof i);
      ring.push({i, from, to, bytes});
    }
  });
  std::uint64_t taken = 0;
  std::int64_t last = -1;
  Datagram datagram;
  const auto drain = [&] {
    while (ring.peek(datagram)) {
      std::uint32_t number = 0;
      std::memcpy(&number, datagram.bytes.data(), sizeof number);
      ASSERT_EQ(number, datagram.stamp_ns);
      ASSERT_GT(datagram.stamp_ns, last);
      last = datagram.stamp_ns;
      ++taken;
      ring.pop();
    }
  };
  while (last + 1 < count && taken + ring.dropped() < count) drain();
  writer.join();
  drain();
  EXPECT_EQ(taken + ring.dropped(), count);
}

}  // namespace
}  // namespace rigcal::livox
