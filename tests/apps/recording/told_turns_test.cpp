#include <gtest/gtest.h>

#include "apps/recording/recording.h"

namespace rigcal {
namespace {

// The gyro is on the second LiDAR, which sits on its side; the third turn was told by the table alone.
TEST(TellTurnsBy, GuessesTurnWhatAnotherLidarsGyroTold) {
  const Matrix3d told = exp_so3(Vector3d(0.0, 0.3, 0.0));
  Recording recording;
  recording.lidar.lidar_sensors = {0, 1};
  recording.lidar.gyro_turns = {std::nullopt, GyroTurn{1, told}, std::nullopt};
  const Matrix3d by_table = exp_so3(Vector3d(0.0, 0.0, 0.31));
  recording.table_turns.R_previous_this = {std::nullopt, by_table, by_table};
  recording.lidar.R_previous_this = {std::nullopt, told, by_table};

  const SE3 on_its_side{exp_so3(Vector3d(0.5 * pi, 0.0, 0.0)), Vector3d(1.0, 0.0, 0.0)};
  tell_turns_by({SE3{}, on_its_side}, recording);
  EXPECT_LT(rotation_distance(*recording.lidar.R_previous_this[1], exp_so3(Vector3d(0.0, 0.0, 0.3))), 1e-12);
  EXPECT_EQ(*recording.lidar.R_previous_this[2], by_table);

  tell_turns_by({SE3{}, std::nullopt}, recording);
  EXPECT_EQ(*recording.lidar.R_previous_this[1], by_table) << "nothing else tells it";
  recording.table_turns = {};
  tell_turns_by({SE3{}, std::nullopt}, recording);
  EXPECT_FALSE(recording.lidar.R_previous_this[1]);
}

}  // namespace
}  // namespace rigcal
