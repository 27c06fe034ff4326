#include "core/records/lidar_models.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

namespace rigcal {
namespace {

TEST(LidarModels, AreFoundByTheirPlaceInTheTable) {
  for (const LidarFacts& row : lidar_models()) EXPECT_EQ(&facts_of(row.model), &row) << row.word;
  EXPECT_STREQ("livox_tele15", facts_of(LidarModel::livox_tele15).word);
  EXPECT_STREQ("lidar", facts_of(LidarModel::other).word);
}

TEST(LidarModels, AreToldApart) {
  std::set<std::string> words;
  std::set<int> codes;
  std::set<std::string> letters;
  for (const LidarFacts& row : lidar_models()) {
    EXPECT_TRUE(words.insert(row.word).second) << row.word;
    EXPECT_TRUE(codes.insert(row.livox.type_code).second) << row.word;
    EXPECT_TRUE(letters.insert(row.livox.code_letters).second) << row.word;
  }
}

TEST(LidarModels, ShootWithinWhatTheySee) {
  for (const LidarFacts& row : lidar_models()) {
    if (row.model == LidarModel::other) continue;
    EXPECT_GT(row.scan.prisms[0].wedge_deg, 0.0) << row.word;
    EXPECT_FALSE(row.scan.prisms[0].is_geared()) << row.word;  // To nothing before it.
    EXPECT_FALSE(row.scan.beams_deg.empty()) << row.word;
    for (const double beam_deg : row.scan.beams_deg) EXPECT_LT(std::abs(beam_deg), 0.5 * row.field.upright_deg);
    EXPECT_LT(row.min_range_m, row.range_at_10_percent_m) << row.word;
    EXPECT_LT(row.range_at_10_percent_m, row.max_range_m) << row.word;
    EXPECT_LT(row.beam_level_deg, row.beam_upright_deg) << row.word;
  }
}

}  // namespace
}  // namespace rigcal
