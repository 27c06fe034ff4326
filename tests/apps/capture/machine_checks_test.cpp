#include "apps/capture/machine_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

namespace rigcal {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string script = "/usr/share/rigcal/udev/install";

Rig rig_with_trigger() {
  auto rig = parse_rig(
      "rigcal: 1\nname: lab\nbase: avia\nsensors:\n"
      "  avia: {type: livox_avia, broadcast_code: \"3JEDHC900100791\", ip: 192.168.1.179}\n"
      "trigger: {gpiochip: gpiochip0, line: 17, pulse_us: 1000, pps: pps0}\n",
      "lab.yaml");
  EXPECT_TRUE(rig.has_value()) << (rig ? "" : rig.error().message());
  return *std::move(rig);
}

MachineFindings good_machine() {
  MachineFindings findings;
  findings.chips = {{"gpiochip0", "pinctrl-soc", 54, 0}};
  findings.pps = {{"/dev/pps0", true}};
  findings.usbfs_memory_mb = 1000;
  findings.lines = {{{"gpiochip0", 17}, trigger::LineUse{}}};
  return findings;
}

/// What is less than good, each with a mend.
std::vector<std::string> wrong(const MachineFindings& findings, const Rig* rig) {
  std::vector<std::string> texts;
  for (const Check& check : check_machine(findings, rig, script)) {
    EXPECT_EQ(check.level == CheckLevel::good, check.mend.empty()) << check.what;
    if (check.level != CheckLevel::good)
      texts.push_back((check.level == CheckLevel::bad ? "bad: " : "") + check.about + ": " + check.what + "; " +
                      check.mend);
  }
  return texts;
}

TEST(MachineChecks, FindNothingWhereAllIsGood) {
  const Rig rig = rig_with_trigger();
  EXPECT_THAT(wrong(good_machine(), &rig), IsEmpty());
  EXPECT_THAT(wrong(good_machine(), nullptr), IsEmpty());
  EXPECT_EQ(check_machine(good_machine(), &rig, script).size(), 3U);  // The line, the PPS, real time.
  MachineFindings without_rig = good_machine();
  without_rig.lines.clear();
  EXPECT_EQ(check_machine(without_rig, nullptr, script).size(), 4U);  // The chip, the PPS, USB memory, real time.
}

TEST(MachineChecks, SayWhatToTypeWhereAUserMayNot) {
  MachineFindings findings = good_machine();
  findings.chips = {{"gpiochip0", "", 0, EACCES}};
  findings.pps = {{"/dev/pps0", false}};
  findings.realtime_priority = 0;
  const std::string group = "sudo " + script + "; then: sudo adduser $USER plugdev, and log in again";
  EXPECT_THAT(wrong(findings, nullptr),
              ElementsAre("GPIO gpiochip0: this user may not use it; " + group,
                          "PPS: this user may not read /dev/pps0; " + group,
                          AllOf(HasSubstr("real time: this user may not ask"), HasSubstr(group))));
}

TEST(MachineChecks, KnowHowMuchMemoryUsbNeeds) {
  MachineFindings findings = good_machine();
  findings.usbfs_memory_mb = 16;
  EXPECT_THAT(wrong(findings, nullptr),
              ElementsAre(AllOf(HasSubstr("USB memory: USB devices may have 16 MiB"), HasSubstr("echo 1000"),
                                HasSubstr("for good: sudo " + script))));
  const Rig rig = rig_with_trigger();
  EXPECT_THAT(wrong(findings, &rig), IsEmpty()) << "no USB camera is there";
  findings.has_usb_camera = true;
  EXPECT_EQ(wrong(findings, &rig).size(), 1U);
  findings.usbfs_memory_mb = 0;  // No limit.
  EXPECT_THAT(wrong(findings, nullptr), IsEmpty());
  findings.usbfs_memory_mb.reset();
  EXPECT_THAT(wrong(findings, nullptr), IsEmpty());
}

TEST(MachineChecks, NeedTheLinesAndPulsesThatTheRigNames) {
  const Rig rig = rig_with_trigger();
  MachineFindings findings = good_machine();
  findings.lines[0].use = trigger::LineUse{true, "blinker"};
  findings.pps.clear();
  EXPECT_THAT(wrong(findings, &rig),
              ElementsAre(HasSubstr("bad: trigger line: gpiochip0, line 17 is held by blinker; end that program"),
                          HasSubstr("bad: PPS: there is no /dev/pps0; load the driver")));
  findings.lines[0].use = system_error("there is no such GPIO chip", "gpiochip0, line 17", "correct the rig file");
  findings.pps = {{"/dev/pps0", false}};
  EXPECT_THAT(wrong(findings, &rig),
              ElementsAre(HasSubstr("bad: trigger line: gpiochip0, line 17: there is no such GPIO chip; correct"),
                          HasSubstr("bad: PPS: this user may not read /dev/pps0")));
  findings.chips[0].refusal = EACCES;
  EXPECT_THAT(wrong(findings, &rig)[0], HasSubstr("sudo adduser $USER plugdev"));
}

TEST(MachineChecks, NeedThePortOfATableThatTurnsItself) {
  Rig rig = rig_with_trigger();
  rig.turntable.emplace();
  rig.turntable->driver = "serial";
  rig.turntable->port = "/dev/no_such_port";
  MachineFindings findings = good_machine();
  findings.table = Expected<void>();
  EXPECT_THAT(wrong(findings, &rig), IsEmpty());
  EXPECT_EQ(check_machine(findings, &rig, script).size(), 4U);
  findings.table = find_machine(&rig).table;
  EXPECT_THAT(wrong(findings, &rig),
              ElementsAre(HasSubstr("turntable: /dev/no_such_port: there is no such serial port")));
}

TEST(MachineChecks, LookAtThisMachine) {
  const MachineFindings findings = find_machine(nullptr);
  EXPECT_THAT(findings.lines, IsEmpty());
  Rig rig = rig_with_trigger();
  rig.trigger->gpiochip = "gpiochip_that_is_not";
  const MachineFindings of_rig = find_machine(&rig);
  ASSERT_EQ(of_rig.lines.size(), 1U);
  EXPECT_FALSE(of_rig.lines[0].use.has_value());
}

}  // namespace
}  // namespace rigcal
