#include "core/pipeline/turn_misfits.h"

#include <algorithm>

namespace rigcal {
namespace {

// A gyro's scale is right to half a percent: 1.8 degrees of a full turn.
constexpr double most_off_rad = to_rad(3.0);

// Of a run of stops between which all turns are told: by what each stands off the gyro, the same for all that agree.
std::vector<std::size_t> misfits_of_run(const std::vector<std::size_t>& stops, const std::vector<Matrix3d>& off) {
  std::vector<std::size_t> misfits;
  std::size_t most = 0;
  for (const Matrix3d& centre : off) {
    std::vector<std::size_t> outside;
    for (std::size_t k = 0; k < off.size(); ++k) {
      if (rotation_distance(centre, off[k]) > most_off_rad) outside.push_back(stops[k]);
    }
    if (off.size() - outside.size() <= most) continue;
    most = off.size() - outside.size();
    misfits = std::move(outside);
  }
  return 2 * most >= off.size() ? misfits : std::vector<std::size_t>{};
}

}  // namespace

std::vector<std::size_t> misfit_turns(const std::vector<std::optional<Matrix3d>>& R_previous_this,
                                      const std::vector<SE3>& T_G_base, const std::vector<char>& stop_known) {
  std::vector<std::size_t> misfits;
  std::vector<std::size_t> stops;
  std::vector<Matrix3d> off;
  const auto end_run = [&] {
    const std::vector<std::size_t> of_run = misfits_of_run(stops, off);
    misfits.insert(misfits.end(), of_run.begin(), of_run.end());
    stops.clear();
    off.clear();
  };
  Matrix3d by_gyro = Matrix3d::Identity();
  for (std::size_t j = 0; j < T_G_base.size(); ++j) {
    if (j > 0) {
      if (j >= R_previous_this.size() || !R_previous_this[j]) {
        end_run();
        by_gyro.setIdentity();
      } else {
        by_gyro = nearest_rotation(by_gyro * *R_previous_this[j]);
      }
    }
    if (stop_known[j] == 0) continue;
    stops.push_back(j);
    off.push_back(T_G_base[j].R * by_gyro.transpose());
  }
  end_run();
  return misfits;
}

}  // namespace rigcal
