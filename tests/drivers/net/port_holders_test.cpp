#include "drivers/net/port_holders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "drivers/net/firewalls.h"
#include "drivers/net/udp_socket.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::net {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

namespace fs = std::filesystem;

class FakeRoot : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((root / name).parent_path());
    std::ofstream(root / name) << text;
  }
  fs::path root = scratch_folder("net");
};

constexpr const char* columns =
    "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode ref pointer\n";

TEST(PortHolders, FindsThisProgram) {
  const auto socket = UdpSocket::open({{{127, 0, 0, 1}, 0}, false, false, 0, {}});
  ASSERT_TRUE(socket.has_value());
  const auto holders = port_holders(socket->local().port);
  ASSERT_THAT(holders, SizeIs(1));
  EXPECT_EQ(holders[0].local, socket->local());
  EXPECT_EQ(holders[0].pid, getpid());
  EXPECT_EQ(holders[0].uid, getuid());
  EXPECT_THAT(holders_text(holders), HasSubstr("(process " + std::to_string(getpid()) + ") on 127.0.0.1"));
  const auto again = UdpSocket::open({socket->local(), false, false, 0, {}});
  ASSERT_FALSE(again.has_value());
  EXPECT_THAT(again.error().message(), HasSubstr("(process " + std::to_string(getpid()) + ")"));
}

TEST_F(FakeRoot, ReadsTheTableAndTheProgramsOfThePort) {
  write("net/udp", std::string(columns) +
                       "  213: 00000000:D6D8 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 "
                       "4711 2 0000000000000000 0\n"
                       "  214: B301A8C0:D6D8 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 "
                       "4712 2 0000000000000000 0\n"
                       "  215: 0100007F:0035 00000000:0000 07 00000000:00000000 00:00000000 00000000   101        0 "
                       "4713 2 0000000000000000 0\n");
  write("77/comm", "livox_viewer\n");
  fs::create_directories(root / "77/fd");
  fs::create_symlink("socket:[4711]", root / "77/fd/5");
  fs::create_symlink("/dev/null", root / "77/fd/6");
  const auto holders = port_holders(55000, root.string());
  ASSERT_THAT(holders, SizeIs(2));
  EXPECT_EQ(holders_text(holders), "livox_viewer (process 77) on 0.0.0.0, a program of user 0 on 192.168.1.179");
  EXPECT_THAT(port_holders(55001, root.string()), IsEmpty());
}

TEST_F(FakeRoot, ATableThatMakesNoSenseTellsNothing) {
  EXPECT_THAT(port_holders(55000, root.string()), IsEmpty());
  write("net/udp", std::string(columns) + "  1: zz:D6D8\n 2: 00000000:D6D8 a b c d e x y z\n\n: : : : : : : : : : :\n");
  EXPECT_THAT(port_holders(55000, root.string()), IsEmpty());
}

TEST_F(FakeRoot, KnowsFirewallsThatAreOn) {
  EXPECT_THAT(active_firewalls(root.string()), IsEmpty());
  write("etc/ufw/ufw.conf", "# comment\nENABLED=no\nLOGLEVEL=low\n");
  EXPECT_THAT(active_firewalls(root.string()), IsEmpty());
  write("etc/ufw/ufw.conf", "# comment\nENABLED = yes\n");
  write("run/firewalld.pid", "12\n");
  const auto both = active_firewalls(root.string());
  ASSERT_THAT(both, SizeIs(2));
  EXPECT_THAT(both[0].mend, HasSubstr("sudo ufw allow"));
  EXPECT_EQ(both[1].name, "firewalld");
}

TEST_F(FakeRoot, KnowsRulesOfTheOldKind) {
  write("proc/net/ip_tables_names", "nat\n");
  EXPECT_THAT(active_firewalls(root.string()), IsEmpty());
  write("proc/net/ip_tables_names", "nat\nfilter\n");
  ASSERT_THAT(active_firewalls(root.string()), SizeIs(1));
}

}  // namespace
}  // namespace rigcal::net
