#include "drivers/livox/device/host_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal::livox {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

const net::Interface lo{"lo", 1, {127, 0, 0, 1}, {255, 0, 0, 0}, true, true, 65536};
const net::Interface eth0{"eth0", 2, {10, 0, 0, 7}, {255, 255, 255, 0}, true, false, 1500};
const net::Interface eth1{"eth1", 3, {192, 168, 1, 5}, {255, 255, 255, 0}, true, false, 1500};
const net::Interface eth1b{"eth1", 3, {192, 168, 2, 5}, {255, 255, 255, 0}, true, false, 1500};
const net::Interface eth2{"eth2", 4, {192, 168, 1, 6}, {255, 255, 255, 0}, false, false, 1500};
const std::vector<net::Interface> all{lo, eth0, eth1, eth1b, eth2};

std::vector<WantedDevice> device_at(Ipv4 ip) {
  WantedDevice device;
  device.ip = ip;
  return {device};
}

TEST(HostChoice, TakesAllThatAreUpOrTheLoopback) {
  const auto lab = choose_hosts(all, device_at({192, 168, 1, 21}), "auto", "auto");
  ASSERT_TRUE(lab.has_value());
  ASSERT_THAT(*lab, SizeIs(3));
  EXPECT_EQ((*lab)[0].name, "eth0");
  const auto loopback = choose_hosts(all, device_at({127, 0, 0, 21}), "auto", "auto");
  ASSERT_TRUE(loopback.has_value());
  ASSERT_THAT(*loopback, SizeIs(1));
  EXPECT_TRUE((*loopback)[0].is_loopback);
}

TEST(HostChoice, TakesWhatIsNamed) {
  const auto by_name = choose_hosts(all, device_at({192, 168, 1, 21}), "eth1", "auto");
  ASSERT_TRUE(by_name.has_value());
  EXPECT_THAT(*by_name, SizeIs(2));
  const auto by_address = choose_hosts(all, device_at({192, 168, 1, 21}), "auto", "192.168.1.5");
  ASSERT_TRUE(by_address.has_value());
  ASSERT_THAT(*by_address, SizeIs(1));
  EXPECT_EQ((*by_address)[0].name, "eth1");
  const auto down = choose_hosts(all, device_at({192, 168, 1, 21}), "eth2", "auto");
  ASSERT_FALSE(down.has_value());
  EXPECT_THAT(down.error().message(), HasSubstr("sudo ip link set eth2 up"));
  const auto none = choose_hosts(all, device_at({192, 168, 1, 21}), "eth9", "auto");
  ASSERT_FALSE(none.has_value());
  EXPECT_THAT(none.error().message(), HasSubstr("eth2 192.168.1.6 (down)"));
}

TEST(HostChoice, ListensWhereACarrierMayComeLater) {
  const net::Interface dark{"eth3", 5, {192, 168, 3, 5}, {255, 255, 255, 0}, false, false, 1500};
  const auto names_of = [](const Expected<std::vector<net::Interface>>& hosts) {
    std::vector<std::string> names;
    if (hosts) {
      for (const net::Interface& host : *hosts) names.push_back(host.name);
    }
    return names;
  };
  EXPECT_THAT(names_of(choose_hosts({dark, eth0}, device_at({192, 168, 3, 21}), "auto", "auto")),
              ElementsAre("eth0", "eth3"));
  EXPECT_THAT(names_of(choose_hosts({dark, eth0}, device_at({10, 0, 0, 21}), "auto", "auto")), ElementsAre("eth0"));
  // Where nothing else is up, the address of the device in the rig file need not be right.
  EXPECT_THAT(names_of(choose_hosts({lo, dark}, device_at({10, 0, 0, 21}), "auto", "auto")), ElementsAre("eth3"));
  EXPECT_THAT(names_of(choose_hosts({dark, eth0}, {WantedDevice{"3JEDHC900100791", {}, {}}}, "auto", "auto")),
              ElementsAre("eth0", "eth3"));
}

net::Received came_in(int interface, const Ipv4& from, const Ipv4& local_ip = {}) {
  net::Received received;
  received.interface = interface;
  received.from.ip = from;
  received.local_ip = local_ip;
  return received;
}

TEST(HostChoice, KnowsWhereADatagramCameIn) {
  const std::vector<net::Interface> hosts{eth0, eth1, eth1b};
  EXPECT_EQ(host_of(hosts, came_in(3, {192, 168, 2, 40})), 2U);
  EXPECT_EQ(host_of(hosts, came_in(3, {192, 168, 1, 40})), 1U);
  EXPECT_EQ(host_of(hosts, came_in(3, {172, 16, 0, 1})), 1U);  // Of no subnet: the interface tells.
  EXPECT_EQ(host_of(hosts, came_in(2, {192, 168, 1, 40})), 0U);
  EXPECT_EQ(host_of(hosts, came_in(9, {192, 168, 1, 40})), 3U);
}

TEST(HostChoice, KnowsAnAdapterThatWasPluggedInAnewByItsAddress) {
  const std::vector<net::Interface> hosts{eth0, eth1, eth1b};
  EXPECT_EQ(host_of(hosts, came_in(9, {192, 168, 2, 40}, {192, 168, 2, 5})), 2U);
  EXPECT_EQ(host_of(hosts, came_in(9, {192, 168, 2, 40}, {192, 168, 2, 6})), 3U);
  EXPECT_EQ(host_of(hosts, came_in(2, {192, 168, 2, 40}, {192, 168, 2, 5})), 0U);  // The number goes before.
}

}  // namespace
}  // namespace rigcal::livox
