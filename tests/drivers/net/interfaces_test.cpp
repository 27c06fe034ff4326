#include "drivers/net/interfaces.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace rigcal::net {
namespace {

TEST(Interfaces, ListTheLoopback) {
  const auto interfaces = list_interfaces();
  ASSERT_TRUE(interfaces.has_value());
  const auto loopback = std::find_if(interfaces->begin(), interfaces->end(), [](const Interface& i) {
    return i.ip == (Ipv4{127, 0, 0, 1});
  });
  ASSERT_NE(loopback, interfaces->end());
  EXPECT_TRUE(loopback->is_loopback);
  EXPECT_TRUE(loopback->is_up);
  EXPECT_GT(loopback->index, 0);
  EXPECT_GE(loopback->mtu, 1500);
  EXPECT_EQ(prefix_length(loopback->mask), 8);
  EXPECT_TRUE(is_in_subnet(*loopback, {127, 0, 0, 179}));
  EXPECT_FALSE(is_in_subnet(*loopback, {128, 0, 0, 1}));
  EXPECT_EQ(interface_name(loopback->index), loopback->name);
}

TEST(Interfaces, HaveANumberWhereTheyHaveNoNameAnyMore) { EXPECT_EQ(interface_name(1 << 30), "interface 1073741824"); }

}  // namespace
}  // namespace rigcal::net
