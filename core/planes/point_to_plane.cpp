#include "core/planes/point_to_plane.h"

#include <Eigen/Geometry>
#include <array>

namespace rigcal {
namespace {

// The rows of the free blocks that one pair touches: at most four.
class TouchedRows {
 public:
  void add(int index, const Vector6d& row) {
    if (index < 0) return;
    for (std::size_t k = 0; k < count_; ++k) {
      if (index_[k] == index) {
        row_[k] += row;
        return;
      }
    }
    index_[count_] = index;
    row_[count_++] = row;
  }

  void add_end(const SensorPoint& end, const Vector3d& normal_G, const ParameterLayout& layout, const RigState& state) {
    const SE3& G = state.T_G_base[static_cast<std::size_t>(end.stop)];
    const SE3& E = state.T_base_sensor[static_cast<std::size_t>(end.lidar)];
    const Vector3d n_base = G.R.transpose() * normal_G;
    const Vector3d n_sensor = E.R.transpose() * n_base;
    Vector6d row;
    row << (E * end.p).cross(n_base), n_base;
    add(layout.stop_index(end.stop), row);
    row << end.p.cross(n_sensor), n_sensor;
    add(layout.lidar_index(end.lidar), row);
  }

  void sum_into(double distance, double weight, NormalEquations& sum) const {
    for (std::size_t p = 0; p < count_; ++p) {
      sum.g.segment<6>(index_[p]) += 2.0 * weight * distance * row_[p];
      for (std::size_t q = 0; q < count_; ++q) {
        if (index_[q] > index_[p]) continue;
        sum.H.block<6, 6>(index_[p], index_[q]) += (2.0 * weight) * row_[p] * row_[q].transpose();
      }
    }
  }

 private:
  std::array<int, 4> index_{};
  std::array<Vector6d, 4> row_;
  std::size_t count_ = 0;
};

}  // namespace

double plane_distance(const SensorPoint& a, const SensorPoint& b, const Vector3d& normal_G, const RigState& state) {
  return normal_G.dot(state.T_G_sensor(a.stop, a.lidar) * a.p - state.T_G_sensor(b.stop, b.lidar) * b.p);
}

void add_point_to_plane(const SensorPoint& a, const SensorPoint& b, const Vector3d& normal_G, double distance,
                        double weight, const ParameterLayout& layout, const RigState& state, NormalEquations& sum) {
  TouchedRows rows;
  rows.add_end(a, normal_G, layout, state);
  rows.add_end(b, -normal_G, layout, state);
  sum.cost += weight * distance * distance;
  rows.sum_into(distance, weight, sum);
}

}  // namespace rigcal
