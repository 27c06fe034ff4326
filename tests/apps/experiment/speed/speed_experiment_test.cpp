#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "apps/common/kept_memory.h"
#include "apps/experiment/speed/experiment.h"
#include "apps/experiment/speed/used_memory.h"
#include "tests/support/json.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::speed {
namespace {

void expect_files(const Experiment& experiment) {
  const auto json = parse_json(experiment_json(experiment));
  EXPECT_TRUE(fits_schema("experiment_speed.json", json));
  const std::vector<std::string> known = experiment_file_names();
  for (const auto& [name, text] : experiment_files(experiment)) {
    EXPECT_THAT(known, testing::Contains(name));
    EXPECT_FALSE(text.empty()) << name;
    if (name.ends_with(".svg")) {
      EXPECT_THAT(text, testing::StartsWith("<svg xmlns")) << name;
    }
  }
}

Experiment run(const std::string& part, double scale) {
  SilentReporter silent;
  ExperimentOptions options;
  options.parts = {part};
  options.scale = scale;
  auto done = run_parts(options, {silent});
  EXPECT_TRUE(done) << done.error().message();
  return done ? std::move(*done) : Experiment{};
}

TEST(SpeedExperiment, TimesTheStagesBesideTheMemory) {
  const Experiment experiment = run("stages", 0.05);
  const std::string text = experiment_text(experiment);
  EXPECT_GT(experiment.bandwidth.read_bytes_per_s, 1e8);
  EXPECT_GT(experiment.bandwidth.copy_bytes_per_s, 1e8);
  ASSERT_EQ(experiment.tables.size(), 2U);
  const StageTable& large = experiment.tables.back();
  EXPECT_NEAR(static_cast<double>(large.points), 2e6, 0.3e6);
  EXPECT_GT(large.points, 5 * experiment.tables.front().points);
  // It is a calibration that is timed, and not what fails soon.
  EXPECT_LT(large.worst_m, 0.01) << text;
  double sum = 0.0;
  for (const char* stage : {"packets to points", "points to cells", "cells to planes", "planes merged", "factors",
                            "solution", "one iteration, map anew", "start", "joint", "verdict"}) {
    EXPECT_GT(large.seconds(stage), 0.0) << stage << "\n" << text;
  }
  for (const StageSpeed& stage : large.stages) {
    // Nothing is faster than the memory gives, were it all in the caches even.
    EXPECT_LT(stage.bytes / stage.seconds, 20.0 * experiment.bandwidth.read_bytes_per_s) << stage.stage;
    sum += stage.seconds;
  }
  EXPECT_GT(large.calibration_s(), large.seconds("start") + large.seconds("joint"));
  EXPECT_LT(large.calibration_s(), sum);
  EXPECT_THAT(text, testing::HasSubstr("one joint iteration, map anew"));
  expect_files(experiment);
}

TEST(SpeedExperiment, TimesManyScansOfOneLidar) {
  const Experiment experiment = run("scans", 0.1);
  ASSERT_TRUE(experiment.scans);
  EXPECT_EQ(experiment.scans->table.stops, 17);
  EXPECT_GT(experiment.scans->table.planes, 500U);
  EXPECT_GT(experiment.scans->table.observations, 2 * experiment.scans->table.planes);
  EXPECT_GT(experiment.scans->map_s, 0.0);
  EXPECT_GT(experiment.scans->iteration_s, 0.0);
  EXPECT_LT(experiment.scans->iteration_s, experiment.scans->map_s);
  expect_files(experiment);
}

TEST(SpeedExperiment, GrowsByAllThatMayGrow) {
  SilentReporter silent;
  GrowthOptions options;
  options.scale = 0.1;
  options.points = {2e6, 8e6};
  options.stops = {8, 16};
  options.lidars = {2, 3};
  options.leaves_m = {2.0, 0.25};
  const auto done = measure_growth(options, {silent});
  ASSERT_TRUE(done) << done.error().message();
  Experiment experiment;
  experiment.growth = *done;
  const std::string text = experiment_text(experiment);
  ASSERT_EQ(done->size(), 8U);
  const std::array<const char*, 4> by{"points", "stops", "LiDARs", "voxels"};
  for (std::size_t k = 0; k < by.size(); ++k) {
    const GrowthRow& small = (*done)[2 * k];
    const GrowthRow& large = (*done)[2 * k + 1];
    EXPECT_EQ(small.by, by[k]);
    EXPECT_EQ(large.by, by[k]);
    EXPECT_GT(large.size, 1.4 * small.size) << text;
    for (const GrowthRow* row : {&small, &large}) {
      EXPECT_GT(row->cells_s, 0.0);
      EXPECT_GT(row->map_s, 0.0);
      EXPECT_EQ(row->calibration_s > row->iteration_s, row->by != std::string("voxels"));
    }
  }
  expect_files(experiment);
}

TEST(GoalsOf, TellWhatWasMetAndWhatWasMissed) {
  Experiment experiment;
  ProgramRun run;
  run.name = "dump";
  run.peak_mb = 900.0;
  run.stages = {{"reading", 2.0}, {"start", 1.0}, {"verdict", 4.0}, {"map", 100.0}};
  experiment.programs.push_back(run);
  run.name = "dump and images";
  run.stages = {{"verdict", 4.0}, {"left images", 0.5}, {"edges", 0.5}, {"left", 0.25}, {"map", 100.0}};
  experiment.programs.push_back(run);
  const std::vector<Goal> goals = goals_of(experiment);
  ASSERT_EQ(goals.size(), 3U);
  EXPECT_DOUBLE_EQ(goals[0].measured, 7.0);
  EXPECT_DOUBLE_EQ(goals[1].measured, 900.0);
  EXPECT_DOUBLE_EQ(goals[2].measured, 1.25);
  const std::string text = experiment_text(experiment);
  EXPECT_THAT(text, testing::ContainsRegex("extrinsics +7.000 .* missed"));
  EXPECT_THAT(text, testing::ContainsRegex("images +1.250 .* met"));
  expect_files(experiment);
}

void hold_64_mb() {
  const std::vector<char> held(64'000'000, 1);
  ASSERT_EQ(held[held.size() / 2], 1);
}

// As the command does it, in a program that is linked as it is.
TEST(MemoryWatch, SeesWhatIsHeldMeanwhileThoughAsMuchWasFree) {
  keep_freed_memory();
  hold_64_mb();
  const MemoryWatch watch;
  hold_64_mb();
  if (watch.peak_mb() == 0.0) GTEST_SKIP() << "the kernel does not tell the peak anew";
  EXPECT_NEAR(watch.peak_mb(), 64.0, 16.0);
}

TEST(SpeedExperiment, EndsWhenTold) {
  SilentReporter silent;
  std::stop_source stop;
  stop.request_stop();
  const std::filesystem::path scratch = scratch_folder("speed") / "runs";
  for (const char* part : {"programs", "stages", "scans", "growth"}) {
    ExperimentOptions options;
    options.parts = {part};
    options.scale = 0.001;
    options.programs.scratch = scratch.string();
    const auto done = run_parts(options, {silent, stop.get_token()});
    ASSERT_FALSE(done) << part;
    EXPECT_EQ(done.error().kind, ErrorKind::cancelled);
    EXPECT_FALSE(std::filesystem::exists(scratch));
  }
}

// As a shell completes it: the folder was made, and then said to be there already.
TEST(TimePrograms, TakeAScratchFolderWithASlash) {
  SilentReporter silent;
  std::stop_source stop;
  stop.request_stop();
  const std::filesystem::path scratch = scratch_folder("speed_slash") / "runs";
  ProgramOptions options;
  options.scratch = scratch.string() + "/";
  const auto done = time_programs(options, {silent, stop.get_token()});
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::cancelled) << done.error().message();
  EXPECT_FALSE(std::filesystem::exists(scratch));
}

}  // namespace
}  // namespace rigcal::speed
