// The program itself: what every command has in common.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/run_program.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr std::array commands{"simulate", "capture",  "calibrate",  "batch",  "inspect", "import",
                              "export",   "evaluate", "experiment", "replay", "doctor"};

class CommandLine : public testing::Test {
 protected:
  [[nodiscard]] ProgramRun rigcal(const std::string& arguments) const { return run_rigcal(arguments, scratch); }

  std::filesystem::path scratch = scratch_folder("cli");
};

TEST_F(CommandLine, TellsItsVersion) {
  const ProgramRun run = rigcal("--version");
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, ContainsRegex("^rigcal [0-9]+\\.[0-9]+\\.[0-9]+\n$"));
}

// As some job systems start it: what it opens first would get the numbers of the closed ones.
TEST_F(CommandLine, StandardStreamsThatAreClosedAreNothingButSilent) {
  for (const char* closed : {">&-", "2>&-", "<&- >&-", "<&- >&- 2>&-"}) {
    EXPECT_EQ(rigcal(std::string("--version ") + closed).code, 0) << closed;
    EXPECT_EQ(rigcal(std::string("evaluate absent --truth absent ") + closed).code, 3) << closed;
  }
}

TEST_F(CommandLine, ShowsAnExampleAtTheEndOfEveryHelp) {
  const std::string list = rigcal("--help").out;
  EXPECT_THAT(list, HasSubstr("Example:\n  rigcal "));
  for (const char* command : commands) {
    EXPECT_THAT(list, HasSubstr(command));
    const ProgramRun run = rigcal(std::string(command) + " --help");
    EXPECT_EQ(run.code, 0);
    EXPECT_THAT(run.out, HasSubstr("--threads, --json, --quiet and --log-level: see rigcal --help"));
    EXPECT_THAT(run.out,
                ContainsRegex(std::string("Example:\n  rigcal ") + command + " [^\n]*\n(  rigcal [^\n]*\n)*\n*$"));
  }
}

TEST_F(CommandLine, EndsWithTwoAndOneLineWhenItIsWrong) {
  for (const char* arguments : {"", "nonsense", "--nonsense", "evaluate", "evaluate a --truth b --threads 0",
                                "--log-level loud evaluate a --truth b"}) {
    const ProgramRun run = rigcal(arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_THAT(run.out, IsEmpty());
    EXPECT_THAT(run.err, StartsWith("rigcal: error: "));
    EXPECT_EQ(run.err.find('\n'), run.err.size() - 1) << run.err;
  }
}

TEST_F(CommandLine, SaysThatACaptureThatDoesNotCalibrateHasNoResult) {
  const ProgramRun run = rigcal("capture --rig rig.yaml --out session --result result");
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("--result: there is none without --calibrate or --target"));
  EXPECT_EQ(rigcal("capture --rig rig.yaml --out session --calibrate --result ''").code, 2);
}

TEST_F(CommandLine, RefusesAResultWhereTheSessionWouldLieBeforeItIsRecorded) {
  std::filesystem::create_directories(scratch / "part");
  std::filesystem::create_directory_symlink(scratch / "part", scratch / "link");
  const auto capture = [&](const std::string& rest) { return rigcal("capture --rig absent.yaml --calibrate " + rest); };
  for (const char* same :
       {"--out session --result session", "--out session/ --result ./session", "--out result/session --result result",
        "--out part/session --result link/session", "--out part --parts --result part.2"}) {
    const ProgramRun run = capture(same);
    EXPECT_EQ(run.code, 2) << same;
    EXPECT_THAT(run.err, HasSubstr("--result: the session would lie there; choose another place")) << same;
  }
  // These come as far as the rig file that is missing.
  for (const char* apart : {"--out session --result session_2", "--out session --result session/result",
                            "--out part --parts --result part", "--out session"})
    EXPECT_EQ(capture(apart).code, 3) << apart;
}

TEST_F(CommandLine, NamesTheRigFileThatHasNothingToCapture) {
  const std::string rig = (scratch / "bare.yaml").string();
  std::ofstream(rig) << "rigcal: 1\nname: bare\nbase: top\nsensors:\n  top: {type: lidar}\n";
  const ProgramRun run = rigcal("capture --rig '" + rig + "' --out '" + (scratch / "session").string() + "'");
  EXPECT_EQ(run.code, 3);
  EXPECT_THAT(run.err, HasSubstr("bare.yaml: rig 'bare': has no Livox LiDAR; add one"));
}

TEST_F(CommandLine, NamesACommandThatItDoesNotKnow) {
  EXPECT_THAT(rigcal("calibarte run.pcap").err, HasSubstr("there is no command 'calibarte'"));
  EXPECT_THAT(rigcal("evaluate result").err, HasSubstr("see rigcal evaluate --help"));
}

TEST_F(CommandLine, TakesTheGlobalOptionsBehindTheCommandToo) {
  const ProgramRun run = rigcal("evaluate missing --truth missing --quiet --json --threads 1 --log-level debug");
  EXPECT_EQ(run.code, 3);
  EXPECT_THAT(run.err, HasSubstr("rigcal: error: missing"));
}

TEST_F(CommandLine, EndsWithFourWhenItsOutputCannotBeWritten) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_EQ(rigcal("--version >/dev/full").code, 4);
}

}  // namespace
}  // namespace rigcal
