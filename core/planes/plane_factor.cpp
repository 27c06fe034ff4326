#include "core/planes/plane_factor.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

struct WorldCluster {
  double N;
  Vector3d mean;
  Matrix3d scatter;
};

WorldCluster to_world(const PlaneObservation& o, const RigState& state) {
  const SE3 T = state.T_G_sensor(o.stop, o.lidar);
  return {o.weight * o.N, T * o.mean, o.weight * (T.R * o.scatter * T.R.transpose())};
}

// Sums over the observations: first the centroid, then the scatter about it, so that no digits cancel.
struct Total {
  double N = 0.0;
  Vector3d q = Vector3d::Zero();
  Matrix3d scatter = Matrix3d::Zero();
};

Total add_up(const std::vector<WorldCluster>& clusters) {
  Total total;
  for (const WorldCluster& c : clusters) {
    total.N += c.N;
    total.q += c.N * c.mean;
  }
  total.q /= total.N;
  for (const WorldCluster& c : clusters) {
    const Vector3d d = c.mean - total.q;
    total.scatter += c.scatter + c.N * d * d.transpose();
  }
  return total;
}

thread_local std::vector<WorldCluster> scratch;

const std::vector<WorldCluster>& world_clusters(const PlaneFeature& feature, const RigState& state) {
  scratch.clear();
  for (const PlaneObservation& o : feature.observations) scratch.push_back(to_world(o, state));
  return scratch;
}

}  // namespace

double plane_cost(const PlaneFeature& feature, const RigState& state) {
  return symmetric_eigen(add_up(world_clusters(feature, state)).scatter).values[0];
}

void plane_derivatives(const PlaneFeature& feature, const RigState& state, HessianForm form, PlaneDerivatives& out) {
  const std::vector<WorldCluster>& clusters = world_clusters(feature, state);
  const Total total = add_up(clusters);
  const SymmetricEigen eigen = symmetric_eigen(total.scatter);
  const Vector3d u = eigen.vectors.col(0);
  const Vector3d u1 = eigen.vectors.col(1);
  const Vector3d u2 = eigen.vectors.col(2);
  const bool exact = form == HessianForm::exact;
  const double l0 = exact ? eigen.values[0] : 0.0;
  out.cost = eigen.values[0];
  out.centroid = total.q;
  out.normal = u;
  out.tangent1 = u1;
  out.tangent2 = u2;
  out.eigenvalues = eigen.values / total.N;
  out.N = total.N;
  out.c0 = -2.0 / total.N;
  out.c1 = 2.0 / (l0 - eigen.values[1]);
  out.c2 = 2.0 / (l0 - eigen.values[2]);
  out.observations.resize(clusters.size());
  const Matrix3d ux = skew(u);
  for (std::size_t a = 0; a < clusters.size(); ++a) {
    const WorldCluster& c = clusters[a];
    ObservationDerivatives& o = out.observations[a];
    // About the centroid q the formulas of the paper lose their q terms: S_a = P_a, d_a = v_a.
    const Vector3d m = c.mean - total.q;
    const Vector3d v = c.N * m;
    const Matrix3d P = c.scatter + v * m.transpose();
    const Vector3d s = P * u;
    const Vector3d vxu = v.cross(u);
    const double vu = v.dot(u);
    o.g << 2.0 * s.cross(u), 2.0 * vu * u;
    o.beta << vxu, c.N * u;
    o.eta1 << (P * u1).cross(u), v.dot(u1) * u;
    o.eta2 << (P * u2).cross(u), v.dot(u2) * u;
    o.A = 2.0 * (ux * P * ux.transpose());
    if (exact) {
      o.eta1.head<3>() += s.cross(u1);
      o.eta1.tail<3>() += vu * u1;
      o.eta2.head<3>() += s.cross(u2);
      o.eta2.tail<3>() += vu * u2;
      o.A += u * s.transpose() + s * u.transpose() - 2.0 * u.dot(s) * Matrix3d::Identity();
    }
  }
}

void for_each_offset(const PlaneFeature& feature, const RigState& state,
                     const std::function<void(const PlaneObservation&, double, double)>& f) {
  const std::vector<WorldCluster> clusters = world_clusters(feature, state);
  const Total total = add_up(clusters);
  const SymmetricEigen eigen = symmetric_eigen(total.scatter);
  for (std::size_t a = 0; a < clusters.size(); ++a) {
    const Vector3d m = eigen.vectors.transpose() * (clusters[a].mean - total.q);
    const double leverage = clusters[a].N * (1.0 / total.N + m.y() * m.y() / std::max(eigen.values[1], 1e-12) +
                                             m.z() * m.z() / std::max(eigen.values[2], 1e-12));
    f(feature.observations[a], m.x(), std::max(0.0, 1.0 - leverage));
  }
}

}  // namespace rigcal
