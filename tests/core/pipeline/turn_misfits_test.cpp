#include "core/pipeline/turn_misfits.h"

#include <gmock/gmock.h>

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Eight stops of a table, a twelfth of a turn apart, in a world that is not the gyro's.
class MisfitTurns : public testing::Test {
 protected:
  MisfitTurns() {
    SE3 T{exp_so3(Vector3d(0.3, -0.2, 1.0)), Vector3d(1.0, 2.0, 3.0)};
    const Matrix3d step = exp_so3(to_rad(30.0) * Vector3d::UnitZ());
    for (int j = 0; j < 8; ++j) {
      if (j > 0) T.R = T.R * step;
      T_G_base_.push_back(T);
      // Half a percent too much.
      turns_.emplace_back(exp_so3(to_rad(30.15) * Vector3d::UnitZ()));
    }
    known_.assign(8, 1);
  }
  void turn(std::size_t stop, double deg) {
    T_G_base_[stop].R = T_G_base_[stop].R * exp_so3(to_rad(deg) * Vector3d::UnitX());
  }
  [[nodiscard]] std::vector<std::size_t> find() const { return misfit_turns(turns_, T_G_base_, known_); }

  std::vector<SE3> T_G_base_;
  std::vector<std::optional<Matrix3d>> turns_;
  std::vector<char> known_;
};

TEST_F(MisfitTurns, AreNoneWhereTheStopsTurnAsTheGyroSays) { EXPECT_THAT(find(), IsEmpty()); }

TEST_F(MisfitTurns, AreTheStopsThatStandOtherwise) {
  turn(2, 7.0);
  turn(6, -90.0);
  EXPECT_THAT(find(), ElementsAre(2, 6));
  known_[6] = 0;
  EXPECT_THAT(find(), ElementsAre(2));
}

TEST_F(MisfitTurns, AreNotThoseThatTheGyrosScaleMakesOfManyRounds) {
  for (int j = 8; j < 96; ++j) {
    T_G_base_.push_back(T_G_base_.back());
    T_G_base_.back().R = T_G_base_.back().R * exp_so3(to_rad(30.0) * Vector3d::UnitZ());
    turns_.emplace_back(exp_so3(to_rad(30.3) * Vector3d::UnitZ()));
  }
  known_.assign(96, 1);
  EXPECT_THAT(find(), IsEmpty());
  turn(50, 40.0);
  EXPECT_THAT(find(), ElementsAre(50));
}

TEST_F(MisfitTurns, AreTheSmallerPartAlsoWhereItComesFirst) {
  turn(0, 20.0);
  turn(1, 20.0);
  EXPECT_THAT(find(), ElementsAre(0, 1));
}

TEST_F(MisfitTurns, AreTheLaterHalfWhereHalfAgree) {
  for (std::size_t j = 4; j < 8; ++j) turn(j, 9.0);
  EXPECT_THAT(find(), ElementsAre(4, 5, 6, 7));
}

TEST_F(MisfitTurns, AreNotToldWhereNoneAgreeOrNothingWasTold) {
  for (std::size_t j = 0; j < 8; ++j) turn(j, 10.0 * static_cast<double>(j));
  EXPECT_THAT(find(), IsEmpty());
  turns_.assign(8, std::nullopt);
  EXPECT_THAT(find(), IsEmpty());
}

TEST_F(MisfitTurns, AreSoughtApartWhereATurnIsNotKnown) {
  turns_[4].reset();
  const Matrix3d elsewhere = exp_so3(Vector3d(0.0, 0.0, 2.0));
  for (std::size_t j = 4; j < 8; ++j) T_G_base_[j].R = elsewhere * T_G_base_[j].R;
  EXPECT_THAT(find(), IsEmpty());
  turn(5, 8.0);
  EXPECT_THAT(find(), ElementsAre(5));
}

}  // namespace
}  // namespace rigcal
