#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/experiment/board_experiment_text.h"
#include "apps/experiment/board_rivals.h"
#include "apps/experiment/board_stage.h"
#include "tests/support/json.h"
#include "tests/support/schema_check.h"

namespace rigcal {
namespace {

// One set of poses at the noise of the paper, four draws of each pair: what the command does, only less of it.
TEST(DrawBoards, BeatsThePapersClaimsByHalfAlreadyInAFewDraws) {
  BoardExperiment experiment;
  SilentReporter silent;
  BoardDrawOptions options;
  options.draws = 4;
  options.sets = 1;
  options.poses_of_set = 11;
  options.asked_only = true;
  const auto rows = draw_boards(options, {silent});
  ASSERT_TRUE(rows) << rows.error().message();
  experiment.rows = *rows;
  ASSERT_EQ(rows->size(), published_claims().size());
  for (std::size_t k = 0; k < rows->size(); ++k) {
    const BoardRow& row = (*rows)[k];
    const BoardClaim& claim = published_claims()[k];
    EXPECT_EQ(row.pair, claim.pair);
    ASSERT_EQ(row.ways.size(), row.pair == "camera-camera" ? 3U : 4U);
    EXPECT_EQ(row.ways[0].answers, 4) << board_experiment_text(experiment);
    EXPECT_LT(row.ways[0].rotation_rad, 0.5 * claim.rotation_rad) << board_experiment_text(experiment);
    EXPECT_LT(row.ways[0].translation_m, 0.5 * claim.translation_m) << board_experiment_text(experiment);
    EXPECT_GE(row.ways[0].worst_rotation_rad, row.ways[0].rotation_rad);
    EXPECT_EQ(row.ways[0].projection_px > 0.0, row.pair != "LiDAR-LiDAR");
    // The others are in the same place, if not so exactly.
    for (const BoardWay& way : row.ways) {
      EXPECT_EQ(way.answers, 4) << way.way;
      EXPECT_LT(way.rotation_rad, to_rad(6.0)) << way.way;
    }
  }
  const auto json = parse_json(board_experiment_json(experiment));
  EXPECT_TRUE(fits_schema("experiment_checkerboard.json", json));
  const auto pictures = board_experiment_pictures(experiment.rows);
  EXPECT_EQ(pictures.size(), board_experiment_files().size());
  for (const auto& [name, svg] : pictures) EXPECT_THAT(svg, testing::StartsWith("<svg xmlns")) << name;
}

// Poses have consecutive seeds: the noise of one at one k must not be that of another at the k before.
TEST(SeeBoard, GivesEveryNoiseOfEveryPoseNumbersOfItsOwn) {
  Random random(1);
  const std::vector<BoardStation> stations{published_rig(random)[2]};
  const SE3 T_rig_board = stations[0].T_rig_sensor * SE3{exp_so3({0.0, 0.0, to_rad(45.0)}), {0.0, 0.0, 2.0}};
  const std::vector<ViewNoise> twice{published_noise(1), published_noise(1)};
  std::vector<double> seen;
  for (const std::uint64_t seed : {1000U, 1001U}) {
    for (const auto& sightings : see_board(bare_hall(), stations, T_rig_board, published_board(), twice, seed)) {
      ASSERT_EQ(1U, sightings.size());
      EXPECT_THAT(seen, testing::Not(testing::Contains(sightings[0].T_sensor_board.t.z())));
      seen.push_back(sightings[0].T_sensor_board.t.z());
    }
  }
}

TEST(DetectBoards, FindsTheBoardInEveryScene) {
  BoardExperiment experiment;
  SilentReporter silent;
  const auto rows = detect_boards(3, 1, {silent});
  ASSERT_TRUE(rows) << rows.error().message();
  experiment.detection = *rows;
  ASSERT_EQ(rows->size(), 6U);
  for (const DetectionRow& row : *rows) {
    EXPECT_EQ(row.boards, 1) << row.scene;
    EXPECT_EQ(row.right, 1) << board_experiment_text(experiment);
    EXPECT_EQ(row.wrong_used, 0);
  }
  EXPECT_THAT(board_experiment_text(experiment), testing::HasSubstr("recall"));
  const auto json = parse_json(board_experiment_json(experiment));
  EXPECT_TRUE(fits_schema("experiment_checkerboard.json", json));
  EXPECT_EQ(json["detection"].size(), 8U);  // with the sums
}

TEST(TryLivoxBoards, FindsTheCameraTheSizeAndTheSignOfTheSquares) {
  BoardExperiment experiment;
  SilentReporter silent;
  LivoxBoardOptions options;
  options.rigs = 1;
  options.poses = 5;
  const auto rows = try_livox_boards(options, {silent});
  ASSERT_TRUE(rows) << rows.error().message();
  experiment.livox = *rows;
  const std::string text = board_experiment_text(experiment);
  ASSERT_EQ(rows->size(), 2U);
  for (const LivoxRow& row : *rows) {
    EXPECT_EQ(row.answers, 1) << text;
    EXPECT_LT(row.translation_m, 0.010) << text;
    EXPECT_LT(row.rotation_rad, to_rad(0.2)) << text;
    EXPECT_EQ(row.shown, 5);
    EXPECT_EQ(row.found, 5) << text;
    EXPECT_LT(row.worst_size_m, 0.010) << text;
    EXPECT_EQ(row.signs_right, row.signs) << text;
  }
  const auto json = parse_json(board_experiment_json(experiment));
  EXPECT_TRUE(fits_schema("experiment_checkerboard.json", json));
}

TEST(BoardExperiment, EndsWhenTold) {
  SilentReporter silent;
  std::stop_source stop;
  stop.request_stop();
  const RunContext context{silent, stop.get_token()};
  EXPECT_FALSE(draw_boards({}, context));
  EXPECT_FALSE(detect_boards(3, 1, context));
  EXPECT_FALSE(try_livox_boards({}, context));
}

}  // namespace
}  // namespace rigcal
