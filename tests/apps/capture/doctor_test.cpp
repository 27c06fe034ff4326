#include "apps/capture/doctor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Rig two_lidars() {
  auto rig = parse_rig(
      "rigcal: 1\nname: lab\nbase: avia\nsensors:\n"
      "  avia: {type: livox_avia, broadcast_code: \"3JEDHC900100791\", ip: 192.168.1.179}\n"
      "  left: {type: livox_mid40, broadcast_code: \"0TFDG3B00600551\", ip: 192.168.1.21}\n",
      "lab.yaml");
  EXPECT_TRUE(rig.has_value()) << (rig ? "" : rig.error().message());
  return *std::move(rig);
}

net::Interface eth(const std::string& name, livox::Ipv4 ip, bool is_up = true, int mtu = 1500) {
  return {name, 2, ip, {255, 255, 255, 0}, is_up, false, mtu};
}

TEST(DoctorNetwork, KnowsTheWayToEachSensor) {
  const Rig rig = two_lidars();
  const auto worst = [&rig](const std::vector<net::Interface>& interfaces) {
    const auto checks = check_network(rig, interfaces);
    EXPECT_EQ(checks.size(), 2U);
    return checks[0];
  };
  EXPECT_EQ(worst({eth("eth0", {192, 168, 1, 5})}).level, CheckLevel::good);
  const Check none = worst({eth("eth0", {10, 0, 0, 5})});
  EXPECT_EQ(none.level, CheckLevel::bad);
  EXPECT_THAT(none.mend, HasSubstr("sudo ip addr add 192.168.1.5/24 dev NAME"));
  EXPECT_THAT(worst({eth("eth0", {192, 168, 1, 5}, false)}).mend, HasSubstr("ip link set eth0 up"));
  EXPECT_EQ(worst({eth("eth0", {192, 168, 1, 5}), eth("eth1", {192, 168, 1, 6})}).level, CheckLevel::warning);
  EXPECT_THAT(worst({eth("eth0", {192, 168, 1, 5}, true, 1280)}).mend, HasSubstr("mtu 1500"));
}

TEST(DoctorNetwork, KnowsWhenTheBufferIsSmall) {
  EXPECT_EQ(check_receive_buffer(16U << 20U, 8U << 20U).level, CheckLevel::good);
  const Check small = check_receive_buffer(212992, 8U << 20U);
  EXPECT_EQ(small.level, CheckLevel::warning);
  EXPECT_THAT(small.mend, HasSubstr("net.core.rmem_max=8388608"));
  EXPECT_EQ(check_receive_buffer({}, 8U << 20U).level, CheckLevel::good);
}

TEST(DoctorNetwork, NamesWhoHoldsTheDiscoveryPort) {
  EXPECT_EQ(check_discovery_port({}).level, CheckLevel::good);
  const Check taken = check_discovery_port({{{{0, 0, 0, 0}, 55000}, 1000, 77, "livox_viewer"}});
  EXPECT_EQ(taken.level, CheckLevel::warning);
  EXPECT_THAT(taken.what, HasSubstr("livox_viewer (process 77)"));
}

TEST(DoctorNetwork, NamesOtherProgramsThatMayHaveTheLidars) {
  const net::PortHolder own{{{0, 0, 0, 0}, 55000}, 1000, 76, "rigcal"};
  const net::PortHolder other{{{0, 0, 0, 0}, 55000}, 1000, 77, "livox_viewer"};
  EXPECT_EQ(rivals_text({own}, 76, 55000), "");
  EXPECT_EQ(
      rivals_text({own, other}, 76, 55000),
      "UDP port 55000 is also taken by livox_viewer (process 77) on 0.0.0.0, which may have taken them: end it, they "
      "are taken then");
}

TEST(DoctorNetwork, TellsOfFirewallsWhereALidarIsNotHeard) {
  EXPECT_THAT(check_firewalls({}, false), IsEmpty());
  const std::vector<net::Firewall> ufw{{"ufw", "sudo ufw allow"}};
  EXPECT_EQ(check_firewalls(ufw, true)[0].level, CheckLevel::good);
  EXPECT_EQ(check_firewalls(ufw, false)[0].level, CheckLevel::warning);
  EXPECT_EQ(check_firewalls(ufw, false)[0].mend, "sudo ufw allow");
}

TEST(DoctorStatus, SaysBitsInWords) {
  EXPECT_THAT(status_words(0), IsEmpty());
  // A real Tele-15: dirty, fan warning, synchronised by PTP.
  EXPECT_THAT(status_words(0x40006840), ElementsAre("window dirty or blocked", "fan warning"));
  EXPECT_THAT(status_words(0x80000002), ElementsAre("temperature extreme"));
  EXPECT_THAT(status_words(0x80010120),
              ElementsAre("motor error", "firmware abnormal, must be updated", "time synchronisation has failed"));
}

class DoctorLidars : public testing::Test {
 protected:
  DoctorLidars() {
    findings.sensors = {"avia", "left"};
    findings.devices.resize(2);
    const livox::Ipv4 addresses[] = {{192, 168, 1, 179}, {192, 168, 1, 21}};
    const livox::DeviceType types[] = {livox::DeviceType::avia, livox::DeviceType::mid40};
    for (std::size_t i = 0; i < 2; ++i) {
      livox::DeviceReport& report = findings.devices[i];
      report.link.state = livox::LinkState::sampling;
      report.link.broadcast = {findings.sensors[i], types[i], 0};
      report.link.ip = addresses[i];
      report.link.firmware = {11, 9, 0, 0};
      report.link.work_state = livox::WorkState::normal;
      report.packets = 5000;
      findings.sightings.push_back({report.link.broadcast, addresses[i], 0, i, 0, 0, 1});
      DeviceIngest device;
      device.ip = addresses[i];
      device.sensor = static_cast<int>(i);
      device.packets = 5000;
      device.clock.packets = 5000;
      device.last_ns = 4'000'000'000;
      device.clock.drift_ppm = 12.34;
      findings.ingest.devices.push_back(device);
    }
  }
  [[nodiscard]] std::vector<std::string> wrong() const {
    std::vector<std::string> texts;
    for (const Check& check : check_lidars(rig, findings)) {
      if (check.level == CheckLevel::good) continue;
      EXPECT_FALSE(check.mend.empty()) << check.what;
      texts.push_back(check.about + ": " + check.what);
    }
    return texts;
  }

  Rig rig = two_lidars();
  LidarFindings findings;
};

TEST_F(DoctorLidars, AreGood) {
  EXPECT_THAT(wrong(), IsEmpty());
  const auto checks = check_lidars(rig, findings);
  EXPECT_EQ(worst_of(checks), CheckLevel::good);
  EXPECT_THAT(checks_text(checks), HasSubstr("good: avia: Avia, firmware 11.09.00.00, at 192.168.1.179, normal"));
  EXPECT_THAT(checks_text(checks), HasSubstr("its clock runs 12.3 ppm fast; not synchronised, which is accounted for"));
}

TEST_F(DoctorLidars, HaveNoDriftThatWasNotMeasured) {
  findings.ingest.devices[0].last_ns = 1'000'000'000;
  findings.ingest.devices[0].clock.drift_ppm = 400.0;
  findings.ingest.devices[0].point_stream.received = 90;
  findings.ingest.devices[0].point_stream.lost = 10;
  EXPECT_THAT(wrong(), ElementsAre("avia: 10 of 100 packets were lost"));
  EXPECT_THAT(checks_text(check_lidars(rig, findings)), HasSubstr("avia: how its clock runs is not known yet"));
}

TEST_F(DoctorLidars, AreNotThere) {
  livox::DeviceReport& left = findings.devices[1];
  left.link.firmware = {};
  findings.ingest.devices.pop_back();
  left.link.counters.handshakes = 3;
  EXPECT_THAT(wrong(), ElementsAre("left: broadcasts, but does not take this host"));
  left.link.counters.handshakes = 0;
  EXPECT_THAT(wrong(), ElementsAre(HasSubstr("left: broadcasts, but has an address in another subnet")));
  findings.sightings.pop_back();
  EXPECT_THAT(wrong(), ElementsAre("left: was not heard"));
}

TEST_F(DoctorLidars, AreTroubled) {
  findings.devices[0].link.status = 0x40000040;
  findings.devices[0].link.counters.losses = 2;
  findings.ingest.devices[0].point_stream.received = 90;
  findings.ingest.devices[0].point_stream.lost = 10;
  findings.devices[1].packets = 0;
  EXPECT_THAT(wrong(), ElementsAre(HasSubstr("the connection was lost 2 times"), "avia: says: window dirty or blocked",
                                   "avia: 10 of 100 packets were lost", HasSubstr("left: Mid-40")));
}

TEST_F(DoctorLidars, DoNotTakeASetting) {
  findings.devices[0].link.missing_settings = {{"return_mode: dual", livox::Outcome::unsupported}};
  EXPECT_THAT(wrong(),
              ElementsAre("avia: `return_mode: dual` is not in force (not known to the model or its firmware)"));
}

TEST_F(DoctorLidars, HaveOtherAddresses) {
  findings.devices[1].link.ip = {192, 168, 1, 22};
  EXPECT_THAT(wrong(), ElementsAre("left: has the address 192.168.1.22, not 192.168.1.21"));
  findings.devices[1].link.ip = {192, 168, 1, 21};
  findings.sightings.push_back(
      {{"0TFDOTHER600551", livox::DeviceType::mid40, 0}, {192, 168, 1, 30}, 0, livox::kNoDevice, 0, 0, 1});
  EXPECT_THAT(wrong(), IsEmpty());
  findings.sightings.back().ip = {192, 168, 1, 21};
  EXPECT_THAT(wrong(), ElementsAre(HasSubstr("other devices: Mid-40 0TFDOTHER600551 at 192.168.1.21")));
}

TEST_F(DoctorLidars, AreJudgedByTheirDriftNotByTheirFlag) {
  findings.devices[0].link.status = 0x00006000;  // Synchronised by PTP, it says.
  EXPECT_THAT(wrong(),
              ElementsAre("avia: its clock runs 12.3 ppm fast, although it says that it is synchronised by PTP"));
  findings.ingest.devices[0].clock.drift_ppm = -0.4;
  EXPECT_THAT(wrong(), IsEmpty());
  findings.ingest.devices[1].clock.drift_ppm = -400.0;
  EXPECT_THAT(wrong(), ElementsAre("left: its clock runs 400.0 ppm slow"));
}

class DoctorProgram : public testing::Test {
 protected:
  [[nodiscard]] ProgramRun doctor(const std::string& arguments) const {
    return run_rigcal("doctor " + arguments, scratch);
  }
  std::filesystem::path scratch = scratch_folder("doctor");
};

TEST_F(DoctorProgram, ListensWithoutARig) {
  const ProgramRun run = doctor("--seconds 0.5 --json");
  EXPECT_TRUE(run.code == 0 || run.code == 1) << run.err;
  const auto summary = parse_json(run.out);
  EXPECT_TRUE(fits_schema("doctor.json", summary));
  EXPECT_THAT(run.out, HasSubstr("interface lo"));
}

TEST_F(DoctorProgram, SaysWhatItFoundThoughItsLidarsCannotBeReached) {
  const auto rig = scratch / "lab.yaml";
  std::ofstream(rig) << "rigcal: 1\nname: lab\nbase: avia\nsensors:\n"
                        "  avia: {type: livox_avia, broadcast_code: \"3JEDHC900100791\"}\n"
                        "lidar: {interface: nosuchif0}\n";
  const ProgramRun run = doctor("--seconds 0.5 --rig '" + rig.string() + "'");
  EXPECT_EQ(run.code, 4) << run.err;
  EXPECT_THAT(run.out, HasSubstr("interface lo"));
  EXPECT_THAT(run.out, HasSubstr("bad: LiDARs: interface nosuchif0"));
  EXPECT_THAT(run.out, HasSubstr("sudo ip addr add"));
}

TEST_F(DoctorProgram, LooksAtARigWithoutLivoxLidars) {
  const auto rig = scratch / "lab.yaml";
  std::ofstream(rig) << "rigcal: 1\nname: lab\nbase: left\nsensors:\n"
                        "  left: {type: camera, driver: aravis, device: \"nobody\"}\n";
  const ProgramRun run = doctor("--seconds 0.5 --rig '" + rig.string() + "'");
  EXPECT_EQ(run.code, 4) << run.err;
  EXPECT_THAT(run.out, HasSubstr("bad: left: there is no such camera"));
  EXPECT_THAT(run.out, testing::Not(HasSubstr("LiDARs")));
}

TEST_F(DoctorProgram, NamesTheFileOfARigThatIsWrong) {
  const auto rig = scratch / "bare.yaml";
  std::ofstream(rig) << "rigcal: 1\nname: lab\nbase: a\nsensors:\n  a: {type: livox_mid40}\n";
  const ProgramRun run = doctor("--seconds 0.5 --rig '" + rig.string() + "'");
  EXPECT_EQ(run.code, 3) << run.out;
  EXPECT_THAT(run.err, HasSubstr("bare.yaml: sensor 'a' of the rig: has neither a broadcast_code nor an ip; add one"));
}

TEST_F(DoctorProgram, SaysWhichSensorsAreMissing) {
  const ProgramRun run =
      doctor(std::string("--seconds 0.5 --rig '") + RIGCAL_SOURCE_DIR + "/config/rigs/loopback.yaml'");
  EXPECT_EQ(run.code, 4) << run.err;
  EXPECT_THAT(run.out, HasSubstr("bad: mid100_left: was not heard"));
  EXPECT_EQ(doctor("--rig missing.yaml").code, 3);
  EXPECT_EQ(doctor("--seconds never").code, 2);
}

}  // namespace
}  // namespace rigcal
