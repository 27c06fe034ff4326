// The options of `rigcal experiment`: each is read by the experiment that it is given to, or refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/run_program.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class ExperimentCommand : public testing::Test {
 protected:
  [[nodiscard]] ProgramRun rigcal(const std::string& arguments) const {
    return run_rigcal("experiment " + arguments, scratch);
  }

  std::filesystem::path scratch = scratch_folder("experiment");
};

TEST_F(ExperimentCommand, RefusesOptionsOfOtherExperiments) {
  struct Case {
    const char* arguments;
    const char* error;
  };
  for (const auto& [arguments, error] : {
           Case{"sigma --points 5000", "--points: is of targetless, bound, start, base, not of sigma;"},
           Case{"base --rigs 1 --out tables",
                "--out: is of targetless, planes, checkerboard, sigma, bound, speed, not of base;"},
           Case{"start --out tables",
                "--out: is of targetless, planes, checkerboard, sigma, bound, speed, not of start;"},
           Case{"bound --trials 3", "--trials: is of targetless, planes, not of bound;"},
           Case{"targetless --places 2", "--places: is of planes, not of targetless;"},
           Case{"targetless --mountings 2", "--mountings: is of planes, not of targetless;"},
           Case{"planes --rigs 2", "--rigs: is of checkerboard, sigma, bound, start, base, not of planes;"},
           Case{"planes --part pairs", "--part: is of targetless, checkerboard, speed, not of planes;"},
           Case{"speed --part pairs", "--part: speed has no part 'pairs';"},
           Case{"speed --draws 2", "--draws: is of checkerboard, not of speed;"},
           Case{"speed --sets 2", "--sets: is of checkerboard, not of speed;"},
           Case{"speed --boards 3", "--boards: is of checkerboard, not of speed;"},
           Case{"bound --scale 0.1", "--scale: is of speed, not of bound;"},
           Case{"bound --scratch x", "--scratch: is of speed, not of bound;"},
           Case{"base --case gyro", "--case: is of start, not of base;"},
           Case{"base --basin", "--basin: is of start, not of base;"},
           Case{"start --no-guess", "--no-guess: is of base, not of start;"},
           Case{"start --no-gyro", "--no-gyro: is of base, not of start;"},
       }) {
    const ProgramRun run = rigcal(arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_THAT(run.out, IsEmpty());
    EXPECT_THAT(run.err, HasSubstr(error));
    EXPECT_THAT(run.err, HasSubstr("see rigcal experiment --help"));
  }
}

// Past the command line they end at once: --out is a folder of somebody else.
TEST_F(ExperimentCommand, TakesTheOptionsThatAnExperimentReads) {
  std::filesystem::create_directories(scratch / "tables");
  std::ofstream(scratch / "tables/letter.txt") << "x";
  for (const char* arguments :
       {"targetless --trials 1 --part iterations --points 5000 --seed 2",
        "planes --trials 1 --mountings 1 --places 1 --seed 2",
        "checkerboard --part livox --draws 1 --sets 1 --boards 3 --rigs 1 --seed 2", "sigma --rigs 1 --seed 2",
        "bound --rigs 1 --points 5000 --seed 2", "speed --part scans --scale 0.01 --scratch x --seed 2"}) {
    const ProgramRun run = rigcal(std::string(arguments) + " --out tables");
    EXPECT_EQ(run.code, 3) << arguments << "\n" << run.err;
    EXPECT_THAT(run.err, HasSubstr("tables"));
  }
  EXPECT_EQ(rigcal("start --rigs 1 --case gyro --points 1000 --seed 2 --quiet").code, 0);
  EXPECT_EQ(rigcal("base --rigs 1 --no-guess --no-gyro --points 1000 --seed 2 --quiet").code, 0);
}

}  // namespace
}  // namespace rigcal
