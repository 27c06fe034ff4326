#include "core/quality/time_halves.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <set>

#include "core/base/parallel.h"
#include "core/geometry/matrix6.h"

namespace rigcal {
namespace {

constexpr std::size_t least_stops = 4;
// What a mount may slip by: what lies in a direction that the halves do not tell is none.
constexpr double slip_rad = to_rad(3.0);
constexpr double slip_m = 0.1;

// What one half says of a LiDAR's place: xi in T_base_sensor exp(xi), [rotation; translation].
struct HalfSums {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double square = 0.0;  // of the offsets over their variance
  double count = 0.0;

  HalfSums& operator+=(const HalfSums& other) {
    H += other.H;
    g += other.g;
    square += other.square;
    count += other.count;
    return *this;
  }
};

using Halves = std::array<HalfSums, 2>;

struct AllHalves {
  std::vector<Halves> of_lidar;
  AllHalves& operator+=(const AllHalves& other) {
    for (std::size_t i = 0; i < of_lidar.size(); ++i) {
      for (std::size_t h = 0; h < 2; ++h) of_lidar[i][h] += other.of_lidar[i][h];
    }
    return *this;
  }
};

// The stop with which each LiDAR's later half begins; as many as there are stops where it has too few.
std::vector<int> first_later_stops(const SolvedPlanes& solved) {
  std::vector<std::set<int>> seen(static_cast<std::size_t>(solved.layout.lidars()));
  for (const PlaneFeature& feature : solved.features) {
    for (const PlaneObservation& o : feature.observations) seen[static_cast<std::size_t>(o.lidar)].insert(o.stop);
  }
  std::vector<int> out;
  for (const std::set<int>& stops : seen) {
    out.push_back(stops.size() < least_stops
                      ? solved.layout.stops()
                      : *std::next(stops.begin(), static_cast<std::ptrdiff_t>((stops.size() + 1) / 2)));
  }
  return out;
}

AllHalves sum_halves(const SolvedPlanes& solved, const std::vector<int>& first_later) {
  const AllHalves none{std::vector<Halves>(first_later.size())};
  return parallel_sum(solved.features.size(), 256, none, [&](std::size_t begin, std::size_t end) {
    AllHalves part = none;
    PlaneDerivatives plane;
    for (std::size_t k = begin; k < end; ++k) {
      const PlaneFeature& feature = solved.features[k];
      if (feature.merged) continue;
      plane_derivatives(feature, solved.state, HessianForm::gauss_newton, plane);
      for (const PlaneObservation& o : feature.observations) {
        const auto i = static_cast<std::size_t>(o.lidar);
        const SE3 T_G_sensor = solved.state.T_G_sensor(o.stop, o.lidar);
        const Vector3d n = T_G_sensor.R.transpose() * plane.normal;
        const double e = plane.normal.dot(T_G_sensor * o.mean - plane.centroid);
        Vector6d J;
        J << o.mean.cross(n), n;
        HalfSums& half = part.of_lidar[i][o.stop < first_later[i] ? 0 : 1];
        half.H += J * J.transpose() / o.offset_variance;
        half.g += J * (e / o.offset_variance);
        half.square += e * e / o.offset_variance;
        half.count += 1.0;
      }
    }
    return part;
  });
}

// Offsets that scatter by more than their variance are known no better than that.
double scatter_of(const HalfSums& half) { return std::max(1.0, half.square / std::max(1.0, half.count - 6.0)); }

TimeHalves compare(const Halves& halves, int first_later_stop) {
  TimeHalves out;
  out.first_later_stop = first_later_stop;
  Matrix6d P = Matrix6d::Zero();
  P.diagonal().head<3>().setConstant(slip_rad * slip_rad);
  P.diagonal().tail<3>().setConstant(slip_m * slip_m);
  Vector6d apart = Vector6d::Zero();
  Matrix6d C = Matrix6d::Zero();
  double sign = -1.0;
  for (const HalfSums& half : halves) {
    if (half.count < 6.0) return out;
    // Held where nothing else holds it, or it could not be inverted.
    const Matrix6d H = half.H / scatter_of(half) + 1e-6 * inverse6(P);
    const Eigen::LDLT<Matrix6d> ldlt(H);
    apart -= sign * ldlt.solve(half.g / scatter_of(half));
    C += ldlt.solve(Matrix6d::Identity());
    sign = 1.0;
  }
  out.compared = apart.allFinite() && C.allFinite();
  if (!out.compared) return out;
  out.chi2 = apart.dot(solve_symmetric6(C, apart));
  const Vector6d told = P * (P + C).ldlt().solve(apart);
  out.rotation_rad = told.head<3>().norm();
  out.translation_m = told.tail<3>().norm();
  return out;
}

}  // namespace

std::vector<TimeHalves> compare_time_halves(const SolvedPlanes& solved) {
  const std::vector<int> first_later = first_later_stops(solved);
  const AllHalves sums = sum_halves(solved, first_later);
  std::vector<TimeHalves> out;
  for (std::size_t i = 0; i < first_later.size(); ++i) {
    out.push_back(first_later[i] < solved.layout.stops() ? compare(sums.of_lidar[i], first_later[i]) : TimeHalves{});
  }
  return out;
}

}  // namespace rigcal
