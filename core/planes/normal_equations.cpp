#include "core/planes/normal_equations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/wide.h"
#include "core/planes/lever.h"

namespace rigcal {
namespace {

constexpr std::size_t usual_grain = 128;

// Each part has sums of its own: with thousands of stops these must not grow with the planes, too. By sizes alone, so
// that the order of the sums is the same for any number of threads.
std::size_t features_at_a_time(std::size_t features, std::size_t unknowns, std::size_t own_blocks) {
  constexpr std::size_t least_sums = 16;  // for the threads
  constexpr std::size_t most_bytes = std::size_t{256} << 20U;
  const std::size_t each = sizeof(double) * unknowns + sizeof(Matrix6d) * own_blocks;
  const std::size_t sums = std::max(least_sums, most_bytes / std::max<std::size_t>(each, 1));
  return std::max(usual_grain, (features + sums - 1) / sums);
}

// One of the blocks of parameters that a plane touches, with its three coupling vectors projected onto it.
struct TouchedBlock {
  int block = 0;  // six parameters each
  std::array<Vector6d, 3> coupling;
};

// What planes couple: sum_k factor_k c_k c_k^T over all blocks of one, which are sorted by their numbers.
struct Coupled {
  struct Plane {
    std::array<double, 3> factor{};
    std::size_t first = 0;  // of its blocks
    std::size_t count = 0;
  };
  std::vector<Plane> planes;
  std::vector<TouchedBlock> blocks;
};

// What the gradient adds to the Hessian by second derivatives of (phi, tau) with respect to two perturbations, as left
// twists: blocks of turn by turn, turn by shift and shift by turn.
struct Bend {
  Matrix3d turns = Matrix3d::Zero();
  Matrix3d turn_shift = Matrix3d::Zero();
  Matrix3d shift_turn = Matrix3d::Zero();
};

// What each observation adds by itself, so much smaller than the whole matrix that each chunk of planes can have its
// own.
struct OwnBlocks {
  double cost = 0.0;
  Eigen::VectorXd g;
  std::vector<Matrix6d> diagonal;  // of each block
  std::vector<Matrix6d> cross;     // row: LiDAR, column: stop, by stop and LiDAR

  OwnBlocks& operator+=(const OwnBlocks& other) {
    cost += other.cost;
    g += other.g;
    for (std::size_t i = 0; i < diagonal.size(); ++i) diagonal[i] += other.diagonal[i];
    for (std::size_t i = 0; i < cross.size(); ++i) cross[i] += other.cross[i];
    return *this;
  }
};

class FeatureSum {
 public:
  FeatureSum(const ParameterLayout& layout, const RigState& state, HessianForm form)
      : layout_(layout), state_(state), form_(form), slot_(static_cast<std::size_t>(layout.size() / 6), -1) {}

  void add(const PlaneFeature& feature, OwnBlocks& sum, Coupled& coupled) {
    plane_derivatives(feature, state_, form_, derivatives_);
    sum.cost += derivatives_.cost;
    blocks_ = make_room(feature, coupled);
    for (std::size_t a = 0; a < feature.observations.size(); ++a) {
      add_observation(feature.observations[a], derivatives_.observations[a], sum);
    }
    for (const int block : touched_) slot_[static_cast<std::size_t>(block)] = -1;
  }

 private:
  // For all blocks of a plane, and tells their places in it.
  TouchedBlock* make_room(const PlaneFeature& feature, Coupled& coupled) {
    touched_.clear();
    const auto take = [&](int index) {
      if (index < 0 || slot_[static_cast<std::size_t>(index / 6)] >= 0) return;
      slot_[static_cast<std::size_t>(index / 6)] = 0;
      touched_.push_back(index / 6);
    };
    for (const PlaneObservation& o : feature.observations) {
      take(layout_.stop_index(o.stop));
      take(layout_.lidar_index(o.lidar));
    }
    std::sort(touched_.begin(), touched_.end());
    const std::size_t first = coupled.blocks.size();
    coupled.planes.push_back({{derivatives_.c0, derivatives_.c1, derivatives_.c2}, first, touched_.size()});
    for (std::size_t k = 0; k < touched_.size(); ++k) {
      slot_[static_cast<std::size_t>(touched_[k])] = static_cast<int>(k);
      coupled.blocks.push_back({touched_[k], {Vector6d::Zero(), Vector6d::Zero(), Vector6d::Zero()}});
    }
    return coupled.blocks.data() + first;
  }

  void project(const ObservationDerivatives& d, const Lever& lever, int index, OwnBlocks& sum) {
    sum.g.segment<6>(index) += lever.of(d.g);
    TouchedBlock& block = blocks_[slot_[static_cast<std::size_t>(index / 6)]];
    block.coupling[0] += lever.of(d.beta);
    block.coupling[1] += lever.of(d.eta1);
    block.coupling[2] += lever.of(d.eta2);
  }

  void add_observation(const PlaneObservation& o, const ObservationDerivatives& d, OwnBlocks& sum) {
    const int ig = layout_.stop_index(o.stop);
    const int ie = layout_.lidar_index(o.lidar);
    if (ig < 0 && ie < 0) return;
    // Right perturbations seen from the plane's centroid: Ad of the shifted poses.
    const SE3& G = state_.T_G_base[static_cast<std::size_t>(o.stop)];
    const Lever of_stop(G, derivatives_.centroid);
    const Lever of_lidar(G * state_.T_base_sensor[static_cast<std::size_t>(o.lidar)], derivatives_.centroid);
    if (ig >= 0) {
      project(d, of_stop, ig, sum);
      sum.diagonal[static_cast<std::size_t>(ig / 6)] += seen(of_stop, d, of_stop, own_bend);
    }
    if (ie >= 0) {
      project(d, of_lidar, ie, sum);
      sum.diagonal[static_cast<std::size_t>(ie / 6)] += seen(of_lidar, d, of_lidar, own_bend);
    }
    // LiDAR blocks stand behind the stops, so this is the lower triangle.
    if (ig >= 0 && ie >= 0) sum.cross[place(o)] += seen(of_lidar, d, of_stop, cross_bend);
  }

  [[nodiscard]] std::size_t place(const PlaneObservation& o) const {
    return static_cast<std::size_t>(o.stop * layout_.lidars() + o.lidar);
  }

  // With a, c the two perturbations as left twists, (phi, tau) = (phi_a + phi_c + 1/2 phi_a x phi_c,
  // rho_a + rho_c + phi_a x rho_c + 1/2 phi_a x rho_a + 1/2 phi_c x rho_c) to second order. Of one with itself:
  static Bend own_bend(const Vector6d& g) {
    const Matrix3d half = 0.5 * skew(g.tail<3>());
    return {Matrix3d::Zero(), -half, half};
  }
  // Rows: c (the LiDAR), columns: a (the stop).
  static Bend cross_bend(const Vector6d& g) { return {0.5 * skew(g.head<3>()), Matrix3d::Zero(), skew(g.tail<3>())}; }

  // Ad_row^T D Ad_column, with the bend where the Hessian is exact. But for that D holds nothing along the plane: with
  // b = 2 v x u, k = 2 N D = [A, b u^T; u b^T, k u u^T], and t x u is all that a lever's length does.
  [[nodiscard]] Matrix6d seen(const Lever& row, const ObservationDerivatives& d, const Lever& column,
                              Bend (*bend_of)(const Vector6d&)) const {
    const Vector3d& u = derivatives_.normal;
    const Vector3d b = 2.0 * d.beta.head<3>();
    const double k = 2.0 * d.beta.tail<3>().dot(u);
    const Vector3d row_tu = row.t.cross(u);
    const Vector3d column_tu = column.t.cross(u);
    const Vector3d row_u = row.Rt * u;
    const Vector3d column_u = column.Rt * u;
    Matrix3d turns = d.A - b * column_tu.transpose() - row_tu * (b - k * column_tu).transpose();
    Matrix6d out;
    out.topRightCorner<3, 3>() = row.Rt * (b - k * row_tu) * column_u.transpose();
    out.bottomLeftCorner<3, 3>() = row_u * (column.Rt * (b - k * column_tu)).transpose();
    out.bottomRightCorner<3, 3>() = k * row_u * column_u.transpose();
    if (form_ == HessianForm::exact) {
      const Bend bend = bend_of(d.g);
      turns += bend.turns + bend.turn_shift * skew(column.t) - skew(row.t) * bend.shift_turn;
      out.topRightCorner<3, 3>() += row.Rt * bend.turn_shift * column.Rt.transpose();
      out.bottomLeftCorner<3, 3>() += row.Rt * bend.shift_turn * column.Rt.transpose();
    }
    out.topLeftCorner<3, 3>() = row.Rt * turns * column.Rt.transpose();
    return out;
  }

  const ParameterLayout& layout_;
  const RigState& state_;
  HessianForm form_;
  PlaneDerivatives derivatives_;
  std::vector<int> slot_;     // of each block among those of the plane at hand; -1: none
  std::vector<int> touched_;  // sorted
  TouchedBlock* blocks_ = nullptr;
};

// Rows of six have room for eight numbers each, as wide registers take them.
using Lanes = EightLanes;

// Adds left right^T to one block of a row of blocks for each of `blocks`: columns of eight, of which six count.
RIGCAL_WIDE void add_couplings(const std::array<Lanes, 3>& left, const TouchedBlock* blocks, std::size_t count,
                               Lanes* row) {
  for (std::size_t b = 0; b < count; ++b) {
    const std::array<Vector6d, 3>& right = blocks[b].coupling;
    Lanes* out = row + 6 * static_cast<std::size_t>(blocks[b].block);
    for (std::size_t j = 0; j < 6; ++j) {
      out[j].v += left[0].v * right[0].data()[j] + left[1].v * right[1].data()[j] + left[2].v * right[2].data()[j];
    }
  }
}

// Which planes touch each block of parameters, and at which place among their own.
class TouchedBy {
 public:
  TouchedBy(const std::vector<Coupled>& chunks, std::size_t blocks) : starts_(blocks + 1, 0) {
    for (const Coupled& chunk : chunks) {
      for (const TouchedBlock& touched : chunk.blocks) ++starts_[static_cast<std::size_t>(touched.block) + 1];
    }
    for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    touches_.resize(starts_.back());
    std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
    for (const Coupled& chunk : chunks) {
      for (const Coupled::Plane& plane : chunk.planes) {
        const TouchedBlock* first = chunk.blocks.data() + plane.first;
        for (std::size_t k = 0; k < plane.count; ++k) {
          touches_[next[static_cast<std::size_t>(first[k].block)]++] = {&plane.factor, first, k};
        }
      }
    }
  }

  // Row by row of blocks, so that nothing has to be added up over threads.
  void fill(std::size_t block, Eigen::MatrixXd& H) const {
    std::vector<Lanes> row(6 * (block + 1));
    for (std::size_t t = starts_[block]; t < starts_[block + 1]; ++t) {
      const Touch& touch = touches_[t];
      std::array<Lanes, 3> left{};
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < 6; ++i) {
          left[k].v[i] = (*touch.factor)[k] * touch.blocks[touch.place].coupling[k].data()[i];
        }
      }
      add_couplings(left, touch.blocks, touch.place + 1, row.data());
    }
    const auto first = static_cast<Eigen::Index>(6 * block);
    for (std::size_t j = 0; j < row.size(); ++j) {
      for (std::size_t i = 0; i < 6; ++i) {
        H(first + static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = row[j].v[i];
      }
    }
  }

 private:
  struct Touch {
    const std::array<double, 3>* factor;
    const TouchedBlock* blocks;  // of its plane
    std::size_t place;
  };
  std::vector<std::size_t> starts_;
  std::vector<Touch> touches_;
};

// The lower triangle.
void add_own_blocks(const OwnBlocks& own, const ParameterLayout& layout, Eigen::MatrixXd& H) {
  for (std::size_t i = 0; i < own.diagonal.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(6 * i);
    H.block<6, 6>(at, at) += own.diagonal[i];
  }
  for (int j = 0; j < layout.stops(); ++j) {
    for (int i = 0; i < layout.lidars(); ++i) {
      if (layout.stop_index(j) < 0 || layout.lidar_index(i) < 0) continue;
      H.block<6, 6>(layout.lidar_index(i), layout.stop_index(j)) +=
          own.cross[static_cast<std::size_t>(j * layout.lidars() + i)];
    }
  }
}

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
  const auto blocks = static_cast<std::size_t>(n / 6);
  const auto pairs = static_cast<std::size_t>(layout.stops() * layout.lidars());
  const std::size_t grain = features_at_a_time(features.size(), static_cast<std::size_t>(n), blocks + pairs);
  const OwnBlocks zero{0.0, Eigen::VectorXd::Zero(n), std::vector<Matrix6d>(blocks, Matrix6d::Zero()),
                       std::vector<Matrix6d>(pairs, Matrix6d::Zero())};
  std::vector<Coupled> coupled((features.size() + grain - 1) / grain);
  OwnBlocks own = parallel_sum(features.size(), grain, zero, [&](std::size_t begin, std::size_t end) {
    OwnBlocks part = zero;
    FeatureSum feature_sum(layout, state, form);
    for (std::size_t i = begin; i < end; ++i) feature_sum.add(features[i], part, coupled[begin / grain]);
    return part;
  });
  NormalEquations sum{own.cost, std::move(own.g), Eigen::MatrixXd(n, n)};
  const TouchedBy touched(coupled, blocks);
  parallel_for(blocks, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t block = begin; block < end; ++block) touched.fill(block, sum.H);
  });
  add_own_blocks(own, layout, sum.H);
  sum.H.triangularView<Eigen::StrictlyUpper>() = sum.H.transpose().triangularView<Eigen::StrictlyUpper>();
  return sum;
}

double total_cost(const std::vector<PlaneFeature>& features, const RigState& state) {
  return parallel_sum(features.size(), usual_grain, 0.0, [&](std::size_t begin, std::size_t end) {
    double part = 0.0;
    for (std::size_t i = begin; i < end; ++i) part += plane_cost(features[i], state);
    return part;
  });
}

}  // namespace rigcal
