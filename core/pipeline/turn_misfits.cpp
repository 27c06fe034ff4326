#include "core/pipeline/turn_misfits.h"

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

// A gyro's scale is right to half a percent, seldom worse than one and a half.
constexpr double most_off_rad = to_rad(3.0);
constexpr double most_off_per_rad = 0.015;

// A stop of a run between which all turns are told.
struct ToldStop {
  std::size_t stop = 0;
  Matrix3d off;             // what it stands off the gyro: the same for all that agree
  double turned_rad = 0.0;  // since the run began, forth and back added up
};

bool agree(const ToldStop& a, const ToldStop& b) {
  const double most = most_off_rad + most_off_per_rad * std::abs(a.turned_rad - b.turned_rad);
  return rotation_distance(a.off, b.off) <= most;
}

std::vector<std::size_t> misfits_of_run(const std::vector<ToldStop>& run) {
  std::vector<std::size_t> misfits;
  std::size_t most = 0;
  for (const ToldStop& centre : run) {
    std::vector<std::size_t> outside;
    for (const ToldStop& other : run) {
      if (!agree(centre, other)) outside.push_back(other.stop);
    }
    if (run.size() - outside.size() <= most) continue;
    most = run.size() - outside.size();
    misfits = std::move(outside);
  }
  return 2 * most >= run.size() ? misfits : std::vector<std::size_t>{};
}

}  // namespace

std::vector<std::size_t> misfit_turns(const std::vector<std::optional<Matrix3d>>& R_previous_this,
                                      const std::vector<SE3>& T_G_this, const std::vector<char>& stop_known) {
  std::vector<std::size_t> misfits;
  std::vector<ToldStop> run;
  Matrix3d by_gyro = Matrix3d::Identity();
  double turned_rad = 0.0;
  const auto end_run = [&] {
    const std::vector<std::size_t> of_run = misfits_of_run(run);
    misfits.insert(misfits.end(), of_run.begin(), of_run.end());
    run.clear();
    by_gyro.setIdentity();
    turned_rad = 0.0;
  };
  for (std::size_t j = 0; j < T_G_this.size(); ++j) {
    if (j > 0) {
      if (j >= R_previous_this.size() || !R_previous_this[j]) {
        end_run();
      } else {
        by_gyro = nearest_rotation(by_gyro * *R_previous_this[j]);
        turned_rad += log_so3(*R_previous_this[j]).norm();
      }
    }
    if (stop_known[j] == 0) continue;
    run.push_back({j, T_G_this[j].R * by_gyro.transpose(), turned_rad});
  }
  end_run();
  return misfits;
}

}  // namespace rigcal
