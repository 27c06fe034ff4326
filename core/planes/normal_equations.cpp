#include "core/planes/normal_equations.h"

#include <array>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace rigcal {
namespace {

constexpr std::size_t grain = 128;

// The parameter blocks that one feature touches, with its coupling vectors projected onto them.
struct TouchedBlock {
  int index;  // first parameter
  std::array<Vector6d, 3> coupling;
};

class FeatureSum {
 public:
  FeatureSum(const ParameterLayout& layout, const RigState& state, HessianForm form)
      : layout_(layout), state_(state), form_(form), slot_(static_cast<std::size_t>(layout.size() / 6), -1) {}

  void add(const PlaneFeature& feature, NormalEquations& sum) {
    plane_derivatives(feature, state_, form_, derivatives_);
    sum.cost += derivatives_.cost;
    blocks_.clear();
    for (std::size_t a = 0; a < feature.observations.size(); ++a) {
      add_observation(feature.observations[a], derivatives_.observations[a], sum);
    }
    const std::array<double, 3> factor{derivatives_.c0, derivatives_.c1, derivatives_.c2};
    for (const TouchedBlock& p : blocks_) {
      for (const TouchedBlock& q : blocks_) {
        if (q.index > p.index) continue;  // lower triangle only
        Matrix6d block = Matrix6d::Zero();
        for (std::size_t k = 0; k < 3; ++k) block.noalias() += (factor[k] * p.coupling[k]) * q.coupling[k].transpose();
        sum.H.block<6, 6>(p.index, q.index) += block;
      }
    }
    for (const TouchedBlock& p : blocks_) slot_[static_cast<std::size_t>(p.index / 6)] = -1;
  }

 private:
  TouchedBlock& touch(int index) {
    int& slot = slot_[static_cast<std::size_t>(index / 6)];
    if (slot < 0) {
      slot = static_cast<int>(blocks_.size());
      blocks_.push_back({index, {Vector6d::Zero(), Vector6d::Zero(), Vector6d::Zero()}});
    }
    return blocks_[static_cast<std::size_t>(slot)];
  }

  void project(const ObservationDerivatives& d, const Matrix6d& J, int index, NormalEquations& sum) {
    sum.g.segment<6>(index) += J.transpose() * d.g;
    TouchedBlock& block = touch(index);
    block.coupling[0] += J.transpose() * d.beta;
    block.coupling[1] += J.transpose() * d.eta1;
    block.coupling[2] += J.transpose() * d.eta2;
  }

  void add_observation(const PlaneObservation& o, const ObservationDerivatives& d, NormalEquations& sum) {
    const int ig = layout_.stop_index(o.stop);
    const int ie = layout_.lidar_index(o.lidar);
    if (ig < 0 && ie < 0) return;
    // Right perturbations seen from the plane's centroid: Ad of the shifted poses.
    SE3 G = state_.T_G_base[static_cast<std::size_t>(o.stop)];
    G.t -= derivatives_.centroid;
    const Matrix6d Jg = G.adjoint();
    const Matrix6d Je = (G * state_.T_base_sensor[static_cast<std::size_t>(o.lidar)]).adjoint();
    Matrix6d own = d.D;
    Matrix6d cross = d.D;
    if (form_ == HessianForm::exact) add_curvature(d.g, own, cross);
    if (ig >= 0) {
      project(d, Jg, ig, sum);
      sum.H.block<6, 6>(ig, ig) += Jg.transpose() * own * Jg;
    }
    if (ie >= 0) {
      project(d, Je, ie, sum);
      sum.H.block<6, 6>(ie, ie) += Je.transpose() * own * Je;
    }
    // LiDAR blocks stand behind the stops, so this is the lower triangle.
    if (ig >= 0 && ie >= 0) sum.H.block<6, 6>(ie, ig) += Je.transpose() * cross.transpose() * Jg;
  }

  // With a, c the two perturbations as left twists, (phi, tau) = (phi_a + phi_c + 1/2 phi_a x phi_c,
  // rho_a + rho_c + phi_a x rho_c + 1/2 phi_a x rho_a + 1/2 phi_c x rho_c) to second order.
  static void add_curvature(const Vector6d& g, Matrix6d& own, Matrix6d& cross) {
    const Matrix3d gphi = skew(g.head<3>());
    const Matrix3d gtau = skew(g.tail<3>());
    own.topRightCorner<3, 3>() -= 0.5 * gtau;
    own.bottomLeftCorner<3, 3>() += 0.5 * gtau;
    // Rows: a (the stop), columns: c (the LiDAR).
    cross.topLeftCorner<3, 3>() -= 0.5 * gphi;
    cross.topRightCorner<3, 3>() -= gtau;
  }

  const ParameterLayout& layout_;
  const RigState& state_;
  HessianForm form_;
  PlaneDerivatives derivatives_;
  std::vector<TouchedBlock> blocks_;
  std::vector<int> slot_;
};

}  // namespace

ParameterLayout::ParameterLayout(int stops, int lidars)
    : stop_index_(static_cast<std::size_t>(stops), -1), lidar_index_(static_cast<std::size_t>(lidars), -1) {}

void ParameterLayout::free_stop(int stop) {
  int& index = stop_index_[static_cast<std::size_t>(stop)];
  if (index >= 0) return;
  for (const int other : lidar_index_) RIGCAL_ASSERT(other < 0, "stops are freed before LiDARs");
  index = size_;
  size_ += 6;
}

void ParameterLayout::free_lidar(int lidar) {
  int& index = lidar_index_[static_cast<std::size_t>(lidar)];
  if (index >= 0) return;
  index = size_;
  size_ += 6;
}

RigState ParameterLayout::moved(const RigState& state, const Eigen::VectorXd& dx) const {
  RigState out = state;
  const auto move = [&](std::vector<SE3>& poses, const std::vector<int>& indices) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (indices[i] < 0) continue;
      poses[i] = poses[i] * SE3::exp(dx.segment<6>(indices[i]));
      poses[i].R = nearest_rotation(poses[i].R);
    }
  };
  move(out.T_G_base, stop_index_);
  move(out.T_base_sensor, lidar_index_);
  return out;
}

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  cost += other.cost;
  g += other.g;
  H += other.H;
  return *this;
}

NormalEquations build_normal_equations(const std::vector<PlaneFeature>& features, const RigState& state,
                                       const ParameterLayout& layout, HessianForm form) {
  const int n = layout.size();
  const NormalEquations zero{0.0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
  NormalEquations sum = parallel_sum(features.size(), grain, zero, [&](std::size_t begin, std::size_t end) {
    NormalEquations part = zero;
    FeatureSum feature_sum(layout, state, form);
    for (std::size_t i = begin; i < end; ++i) feature_sum.add(features[i], part);
    return part;
  });
  sum.H.triangularView<Eigen::StrictlyUpper>() = sum.H.transpose().triangularView<Eigen::StrictlyUpper>();
  return sum;
}

double total_cost(const std::vector<PlaneFeature>& features, const RigState& state) {
  return parallel_sum(features.size(), grain, 0.0, [&](std::size_t begin, std::size_t end) {
    double part = 0.0;
    for (std::size_t i = begin; i < end; ++i) part += plane_cost(features[i], state);
    return part;
  });
}

}  // namespace rigcal
