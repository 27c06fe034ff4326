#include "apps/experiment/targetless/experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "apps/experiment/targetless/trials.h"
#include "tests/support/json.h"
#include "tests/support/schema_check.h"

namespace rigcal::targetless {
namespace {

void expect_files(const Experiment& experiment) {
  const auto json = parse_json(experiment_json(experiment));
  EXPECT_TRUE(fits_schema("experiment_targetless.json", json));
  const std::vector<std::string> known = experiment_file_names();
  for (const auto& [name, text] : experiment_files(experiment)) {
    EXPECT_THAT(known, testing::Contains(name));
    EXPECT_FALSE(text.empty()) << name;
    if (name.ends_with(".svg")) {
      EXPECT_THAT(text, testing::StartsWith("<svg xmlns")) << name;
    }
  }
}

TEST(TryIterations, ErrorsFallFromIterationToIteration) {
  LidarExperimentOptions options;
  options.trials = 2;
  options.points = 6000;
  options.stops = 12;
  SilentReporter silent;
  Experiment experiment;
  const auto done = try_iterations(options, {silent});
  ASSERT_TRUE(done) << done.error().message();
  experiment.iterations = *done;
  const std::string text = experiment_text(experiment);
  EXPECT_EQ(done->trials, 2);
  ASSERT_EQ(done->methods.size(), 2U);
  for (const MethodIterations& method : done->methods) {
    ASSERT_GE(method.after.size(), 4U) << text;
    EXPECT_EQ(method.after.front().right, 0);
    EXPECT_LT(method.after.back().translation_m.mean, 0.5 * method.after.front().translation_m.mean) << text;
    EXPECT_LT(method.after.back().rotation_rad.mean, 0.2 * method.after.front().rotation_rad.mean) << text;
    EXPECT_GT(method.iteration_s, 0.0);
  }
  const MethodIterations& ours = done->methods[0];
  EXPECT_EQ(ours.after.back().right, 2) << text;
  EXPECT_LE(ours.most_to_be_right, 5) << text;
  EXPECT_LT(ours.after.back().translation_m.mean, 0.005) << text;
  expect_files(experiment);
}

TEST(TryChain, ChainsTheUnitsOfTheMid100) {
  LidarExperimentOptions options;
  options.points = 4000;
  options.stops = 10;
  options.scenes = {"courtyard"};
  options.trials = 1;
  SilentReporter silent;
  Experiment experiment;
  const auto done = try_chain(options, {silent});
  ASSERT_TRUE(done) << done.error().message();
  experiment.chain = *done;
  const std::string text = experiment_text(experiment);
  ASSERT_EQ(done->size(), 6U);
  for (std::size_t k = 0; k < done->size(); k += 3) {
    const ChainRow& ours = (*done)[k];
    const ChainRow& motion = (*done)[k + 2];
    EXPECT_EQ(ours.pairs, 2) << text;
    EXPECT_EQ(motion.method, "motion");
    EXPECT_EQ(motion.found, 2) << text;
    EXPECT_LT(ours.translation_m.mean, 0.02) << text;
    EXPECT_LT(ours.rotation_rad.mean, to_rad(0.2)) << text;
    EXPECT_LT(ours.rotation_rad.mean, motion.rotation_rad.mean) << text;
  }
  expect_files(experiment);
}

TEST(MeasureTimes, TellsMatchingFromSolving) {
  LidarExperimentOptions options;
  options.points = 3000;
  options.stops = 8;
  SilentReporter silent;
  Experiment experiment;
  const auto done = measure_times(options, {silent});
  ASSERT_TRUE(done) << done.error().message();
  experiment.time = *done;
  EXPECT_EQ(done->patches, 32);
  EXPECT_GT(done->points, 32U * 1000U);
  EXPECT_GT(done->ours_prepare_s, 0.0);
  EXPECT_GT(done->icp_prepare_s, 0.0);
  ASSERT_EQ(done->stages.size(), 9U);
  for (const StageSeconds& stage : done->stages) {
    EXPECT_GT(stage.match_s, 0.0) << stage.method << " " << stage.stage;
    EXPECT_GT(stage.solve_s, 0.0) << stage.method << " " << stage.stage;
    EXPECT_GT(stage.matched, 100U) << stage.method << " " << stage.stage;
  }
  // The paper's own figures stand beside them.
  EXPECT_THAT(experiment_text(experiment), testing::HasSubstr("11.0557"));
  expect_files(experiment);
}

TEST(Trial, IsRightFromWhereItStaysSo) {
  Trial trial;
  for (const double m : {0.2, 0.01, 0.05, 0.015, 0.001}) trial.errors.push_back({0.0, m, 0.0, m});
  EXPECT_EQ(trial.right_from(), 3);
  EXPECT_TRUE(trial.is_right(1));
  EXPECT_FALSE(trial.is_right(2));
  EXPECT_EQ(trial.after(9).translation_m, 0.001);
  trial.errors.push_back({0.1, 0.0, 0.1, 0.0});
  EXPECT_EQ(trial.right_from(), std::nullopt);
}

TEST(Trial, IsNotRightWhereALidarFailed) {
  Trial trial;
  for (const double m : {0.2, 0.01, 0.001}) trial.errors.push_back({0.0, m, 0.0, m});
  trial.T_base_sensor = {SE3{}, SE3{}};
  EXPECT_EQ(trial.right_from(), 1);
  // It came near, and has no answer.
  trial.T_base_sensor.back().reset();
  EXPECT_TRUE(trial.is_right(1));
  EXPECT_FALSE(trial.is_right(2));
  EXPECT_EQ(trial.right_from(), std::nullopt);
}

// Zero iterations would be the quickest of all.
TEST(ExperimentFiles, TellOfAMethodThatIsNeverRight) {
  Trial near;
  for (const double m : {0.2, 0.01}) near.errors.push_back({0.0, m, 0.0, m});
  Trial far;
  for (const double m : {0.2, 0.1}) far.errors.push_back({0.0, m, 0.0, m});
  EXPECT_EQ(iterations_of("ICP", {near, far}).most_to_be_right, 1);
  Experiment experiment;
  experiment.iterations.emplace().methods = {iterations_of("ICP", {far})};
  EXPECT_EQ(experiment.iterations->methods[0].most_to_be_right, std::nullopt);
  EXPECT_THAT(experiment_text(experiment), testing::HasSubstr("ICP: never right for good"));
  EXPECT_TRUE(parse_json(experiment_json(experiment))["iterations"]["methods"][0]["most_to_be_right"].is_null());
  expect_files(experiment);
}

TEST(ExperimentFiles, ShowABasin) {
  Experiment experiment;
  for (const double m : {0.5, 1.0}) {
    experiment.basin.push_back({"rigcal", 10.0, m, 4, 4, 1e-4, 0.001});
    experiment.basin.push_back({"ICP", 10.0, m, 4, 1, 1e-3, 0.01});
  }
  EXPECT_THAT(experiment_text(experiment), testing::HasSubstr("1 of 4"));
  expect_files(experiment);
}

TEST(TargetlessExperiment, EndsWhenTold) {
  SilentReporter silent;
  std::stop_source stop;
  stop.request_stop();
  for (const std::string& part : part_names()) {
    ExperimentOptions options;
    options.parts = {part};
    const auto done = run_parts(options, {silent, stop.get_token()});
    ASSERT_FALSE(done) << part;
    EXPECT_EQ(done.error().kind, ErrorKind::cancelled);
  }
}

}  // namespace
}  // namespace rigcal::targetless
