// The files of udev/ can be read by those they are for, are copied where these look, and give what the program asks
// for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "drivers/livox/device/driver.h"
#include "drivers/net/privileges.h"
#include "tests/support/run_program.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

const fs::path folder = fs::path(RIGCAL_SOURCE_DIR) / "udev";

std::vector<std::string> lines_of(const fs::path& file) {
  std::vector<std::string> lines;
  std::ifstream in(file);
  EXPECT_TRUE(in.is_open()) << file;
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && line[0] != '#') lines.push_back(line);
  return lines;
}

/// What is wrong with a rule: the grammar and the names of udev(7).
std::string complaint(const std::string& rule) {
  static const std::regex part(R"re(^([A-Z_]+)(\{[^}"]+\})?(==|!=|=|\+=|-=|:=)"([^"]*)"(, |$))re");
  static const std::set<std::string> matched{"ACTION", "KERNEL", "SUBSYSTEM", "DEVPATH"};
  static const std::set<std::string> assigned{"GROUP", "MODE", "OWNER", "GOTO", "LABEL", "TAG", "SYMLINK"};
  static const std::set<std::string> either{"ATTR", "ENV"};
  std::string rest = rule;
  while (!rest.empty()) {
    std::smatch match;
    if (!std::regex_search(rest, match, part)) return "cannot be read from: " + rest;
    const std::string key = match[1];
    const bool compares = match[3] == "==" || match[3] == "!=";
    if (either.count(key) > 0 && !match[2].matched) return key + " needs a name in braces";
    if (either.count(key) == 0 && match[2].matched) return key + " takes no name in braces";
    if (either.count(key) == 0 && (compares ? matched : assigned).count(key) == 0)
      return key + " cannot stand with " + std::string(match[3]);
    if (key == "MODE" && !std::regex_match(std::string(match[4]), std::regex("0[0-7]{3}"))) return "no mode";
    rest = match.suffix();
  }
  return {};
}

TEST(DeviceRules, AreRulesOfUdev) {
  EXPECT_NE(complaint(R"(KERNEL=="pps*" GROUP="plugdev")"), "");
  EXPECT_NE(complaint(R"(KERNEL="pps*", GROUP=="plugdev")"), "");
  std::set<std::string> labels;
  std::set<std::string> jumps;
  std::size_t rules = 0;
  for (const std::string& line : lines_of(folder / "70-rigcal.rules")) {
    ++rules;
    EXPECT_EQ(complaint(line), "") << line;
    std::smatch match;
    if (std::regex_search(line, match, std::regex("GOTO=\"([^\"]+)\""))) jumps.insert(match[1]);
    if (std::regex_search(line, match, std::regex("LABEL=\"([^\"]+)\""))) labels.insert(match[1]);
  }
  EXPECT_GE(rules, 6U);
  EXPECT_EQ(jumps, labels);
}

TEST(DeviceRules, AreTakenByUdevItself) {
  const fs::path scratch = scratch_folder("udev");
  const ProgramRun can = run_program("udevadm verify --help", scratch);
  if (can.code != 0) GTEST_SKIP() << "SKIP: no udevadm that can verify (it can from systemd 254)";
  const ProgramRun run =
      run_program("udevadm verify --resolve-names=never '" + (folder / "70-rigcal.rules").string() + "'", scratch);
  EXPECT_EQ(run.code, 0) << run.out << run.err;
}

TEST(DeviceRules, GiveWhatTheProgramAsksFor) {
  std::smatch match;
  const std::string limits = testing::PrintToString(lines_of(folder / "limits.conf"));
  ASSERT_TRUE(std::regex_search(limits, match, std::regex("@plugdev - rtprio ([0-9]+)")));
  EXPECT_GE(std::stoi(match[1]), net::kRealtimePriority);
  EXPECT_THAT(limits, testing::HasSubstr("@plugdev - memlock unlimited"));
  const std::string sockets = lines_of(folder / "sysctl.conf").at(0);
  ASSERT_TRUE(std::regex_match(sockets, match, std::regex("net\\.core\\.rmem_max = ([0-9]+)")));
  EXPECT_GE(std::stoull(match[1]), livox::DriverOptions{}.receive_bytes);
  const std::string usb = lines_of(folder / "modprobe.conf").at(0);
  ASSERT_TRUE(std::regex_match(usb, match, std::regex("options usbcore usbfs_memory_mb=([0-9]+)")));
  const std::string memory = match[1];
  EXPECT_THAT(lines_of(folder / "tmpfiles.conf").at(0), testing::EndsWith("usbfs_memory_mb - - - - " + memory));
}

// The package's program is in /usr/bin, that of `cmake --install` in /usr/local/bin.
TEST(DeviceRules, LetTheServiceFindTheProgramWhereverItIsInstalled) {
  EXPECT_THAT(lines_of(folder / "rigcal-capture@.service"),
              testing::Contains(testing::StartsWith("ExecStart=rigcal capture ")));
}

// Its user is made for it, and cannot be added to groups by hand: trigger lines, serial turntables, V4L2 cameras.
TEST(DeviceRules, LetTheServiceUseEveryKindOfDevice) {
  EXPECT_THAT(lines_of(folder / "rigcal-capture@.service"),
              testing::Contains("SupplementaryGroups=plugdev dialout video"));
}

// `--keep`, for example; the words are split where the variable stands without braces.
TEST(DeviceRules, LetTheServiceTakeFurtherOptions) {
  const std::vector<std::string> unit = lines_of(folder / "rigcal-capture@.service");
  EXPECT_THAT(unit, testing::Contains(
                        testing::AllOf(testing::StartsWith("ExecStart="), testing::EndsWith(" $RIGCAL_OPTIONS"))));
  EXPECT_THAT(unit, testing::Contains(
                        testing::AllOf(testing::StartsWith("Environment="), testing::EndsWith(" RIGCAL_OPTIONS="))));
  EXPECT_THAT(unit, testing::Contains("EnvironmentFile=-/etc/rigcal/%i.env"));
}

TEST(DeviceRules, GiveTheServiceTimeForItsResultAndAFullDiskTime) {
  const std::vector<std::string> unit = lines_of(folder / "rigcal-capture@.service");
  EXPECT_THAT(unit, testing::Contains("TimeoutStopSec=20min"));
  EXPECT_THAT(unit, testing::Contains("RestartSec=30"));
}

// What a host allows already is not lowered, neither at once nor at its next start.
TEST(DeviceRules, OnlyRaiseLimits) {
  const fs::path scratch = scratch_folder("limits");
  const fs::path sockets = scratch / "proc/sys/net/core/rmem_max";
  const fs::path usb = scratch / "sys/module/usbcore/parameters/usbfs_memory_mb";
  fs::create_directories(sockets.parent_path());
  fs::create_directories(usb.parent_path());
  const std::vector<std::array<std::string, 4>> before_and_after{{"212992", "16", "33554432", "1000"},
                                                                 {"67108864", "4000", "67108864", "4000"},
                                                                 {"33554432", "0", "33554432", "0"}};
  for (const auto& [socket_bytes, usb_mb, sockets_then, usb_then] : before_and_after) {
    std::ofstream(sockets) << socket_bytes << '\n';
    std::ofstream(usb) << usb_mb << '\n';
    const ProgramRun run =
        run_program("sh '" + (folder / "install").string() + "' --apply '" + scratch.string() + "'", scratch);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_THAT(lines_of(sockets), testing::ElementsAre(sockets_then));
    EXPECT_THAT(lines_of(usb), testing::ElementsAre(usb_then));
  }
}

TEST(DeviceRules, AreCopiedWhereTheyAreRead) {
  const fs::path scratch = scratch_folder("rules");
  const ProgramRun run =
      run_program("sh '" + (folder / "install").string() + "' --root '" + (scratch / "root").string() + "'", scratch);
  EXPECT_EQ(run.code, 0) << run.err;
  const std::map<std::string, std::string> places{
      {"70-rigcal.rules", "etc/udev/rules.d/70-rigcal.rules"},
      {"limits.conf", "etc/security/limits.d/rigcal.conf"},
      {"sysctl.conf", "etc/sysctl.d/10-rigcal.conf"},
      {"modprobe.conf", "etc/modprobe.d/rigcal.conf"},
      {"tmpfiles.conf", "etc/tmpfiles.d/rigcal.conf"},
      {"rigcal-capture@.service", "etc/systemd/system/rigcal-capture@.service"}};
  for (const auto& [file, place] : places)
    EXPECT_EQ(lines_of(folder / file), lines_of(scratch / "root" / place)) << place;
}

}  // namespace
}  // namespace rigcal
