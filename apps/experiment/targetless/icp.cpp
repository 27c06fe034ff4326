#include "apps/experiment/targetless/icp.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/seconds.h"
#include "core/geometry/point_cluster.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/planes/point_to_plane.h"
#include "core/voxel/cells.h"

namespace rigcal::targetless {
namespace {

// A patch with fewer partners than this among the first of its queries does not overlap the other.
constexpr std::size_t probes = 40;
constexpr std::size_t least_of_probes = 3;
constexpr double golden = 0.6180339887498949;
constexpr int steps_each = 2;
constexpr double pose_reach_share = 1.0 / 6.0;
constexpr double settled_m = 1e-4;
constexpr double settled_rad = 1e-5;

struct Places {
  const std::vector<Vector3d>& points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t d) const { return points[i][static_cast<long>(d)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Places>, Places, 3, std::uint32_t>;

// The points of one patch that look for partners and are looked for. It is not moved: the tree refers to its points.
class Cloud {
 public:
  Cloud(const Patch& patch, const IcpOptions& options) : stop(patch.stop), lidar(patch.sensor) {
    CellOptions cells;
    cells.size_m = options.spacing_m;
    cells.max_range_m = options.max_range_m;
    CellBuilder builder(lidar, stop, cells);
    builder.add(patch.points);
    for (const Cell& cell : builder.finish().cells) points.push_back(cell.mean);
    const auto wanted = static_cast<std::size_t>(options.neighbours);
    if (points.size() < wanted) return;
    tree_.emplace(3, places_, nanoflann::KDTreeSingleIndexAdaptorParams(16));
    fit_normals(wanted, options.max_thickness_m);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!normals[i].isZero()) surface_.push_back(static_cast<std::uint32_t>(i));
    }
  }
  Cloud(const Cloud&) = delete;
  Cloud& operator=(const Cloud&) = delete;

  // The nearest point with a normal like this one, if it is within reach.
  [[nodiscard]] std::optional<std::uint32_t> find(const Vector3d& p, const Vector3d& normal, double reach_m,
                                                  double min_cosine) const {
    if (!tree_) return std::nullopt;
    std::uint32_t index = 0;
    double square = 0.0;
    nanoflann::KNNResultSet<double, std::uint32_t> nearest(1);
    nearest.init(&index, &square);
    // Nothing farther is looked at: so says nanoflann up to 1.6; later ones begin without a bound.
    square = reach_m * reach_m;
    tree_->findNeighbors(nearest, p.data(), {});
    if (nearest.size() == 0 || square >= reach_m * reach_m || normals[index].dot(normal) < min_cosine)
      return std::nullopt;
    return index;
  }

  [[nodiscard]] std::size_t queries(std::size_t most) const { return std::min(most, surface_.size()); }
  [[nodiscard]] bool asks_all(std::size_t queries) const { return queries == surface_.size(); }
  // The k-th of all that ask, in the order of memory.
  [[nodiscard]] std::uint32_t query(std::size_t k) const { return surface_[k]; }
  // The k-th of a few, in the order of a golden section: the first of them are spread over all.
  [[nodiscard]] std::uint32_t spread_query(std::size_t k) const {
    const double place = std::fmod(static_cast<double>(k) * golden, 1.0);
    return surface_[static_cast<std::size_t>(place * static_cast<double>(surface_.size()))];
  }

  int stop;
  int lidar;
  std::vector<Vector3d> points;
  std::vector<Vector3d> normals;  // Towards the sensor; zero where there is no surface.

 private:
  void fit_normals(std::size_t wanted, double max_thickness_m) {
    normals.assign(points.size(), Vector3d::Zero());
    std::vector<std::uint32_t> index(wanted);
    std::vector<double> squares(wanted);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::size_t found = tree_->knnSearch(points[i].data(), wanted, index.data(), squares.data());
      PointCluster cluster;
      for (std::size_t k = 0; k < found; ++k) cluster.add(points[index[k]]);
      const auto eigen = symmetric_eigen(cluster.covariance());
      if (eigen.values[0] > max_thickness_m * max_thickness_m || eigen.values[1] < 4.0 * eigen.values[0]) continue;
      const Vector3d n = eigen.vectors.col(0);
      normals[i] = n.dot(points[i]) > 0.0 ? Vector3d(-n) : n;
    }
  }

  Places places_{points};
  std::optional<Tree> tree_;
  std::vector<std::uint32_t> surface_;
};

struct Partners {
  SensorPoint a;
  SensorPoint b;
  Vector3d normal_b;  // sensor frame of b
};

}  // namespace

struct PairwiseIcp::Content {
  std::vector<std::unique_ptr<Cloud>> clouds;
  std::vector<Partners> partners;

  void match(const Cloud& a, const Cloud& b, const RigState& state, double reach_m, const IcpOptions& options,
             std::vector<Partners>& out) const {
    const SE3 T_b_a = state.T_G_sensor(b.stop, b.lidar).inverse() * state.T_G_sensor(a.stop, a.lidar);
    const auto ask = [&](std::uint32_t i) {
      const auto found = b.find(T_b_a * a.points[i], T_b_a.R * a.normals[i], reach_m, options.min_cosine);
      if (found)
        out.push_back({{a.stop, a.lidar, a.points[i]}, {b.stop, b.lidar, b.points[*found]}, b.normals[*found]});
    };
    const std::size_t before = out.size();
    const std::size_t queries = a.queries(options.queries);
    for (std::size_t k = 0; k < std::min(queries, probes); ++k) ask(a.spread_query(k));
    if (queries >= probes && out.size() < before + least_of_probes) return;
    if (!a.asks_all(queries)) {
      for (std::size_t k = probes; k < queries; ++k) ask(a.spread_query(k));
      return;
    }
    out.resize(before);  // each is asked once, in an order that caches like
    for (std::size_t k = 0; k < queries; ++k) ask(a.query(k));
  }
};

PairwiseIcp::PairwiseIcp(const std::vector<Patch>& patches, const IcpOptions& options)
    : options_(options), content_(std::make_unique<Content>()) {
  content_->clouds.resize(patches.size());
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) content_->clouds[i] = std::make_unique<Cloud>(patches[i], options);
  });
}

PairwiseIcp::~PairwiseIcp() = default;
PairwiseIcp::PairwiseIcp(PairwiseIcp&&) noexcept = default;
PairwiseIcp& PairwiseIcp::operator=(PairwiseIcp&&) noexcept = default;

std::size_t PairwiseIcp::match(const RigState& state, double reach_m, std::optional<int> only_lidar) {
  const auto& clouds = content_->clouds;
  const auto takes_part = [&](const Cloud& cloud) { return !only_lidar || cloud.lidar == *only_lidar; };
  std::vector<std::vector<Partners>> parts(clouds.size());
  parallel_for(clouds.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = 0; j < clouds.size(); ++j) {
        if (i == j || !takes_part(*clouds[i]) || !takes_part(*clouds[j])) continue;
        content_->match(*clouds[i], *clouds[j], state, reach_m, options_, parts[i]);
      }
    }
  });
  content_->partners.clear();
  for (const auto& part : parts) content_->partners.insert(content_->partners.end(), part.begin(), part.end());
  return content_->partners.size();
}

void PairwiseIcp::solve(const ParameterLayout& layout, RigState& state) const {
  const std::vector<Partners>& partners = content_->partners;
  if (partners.empty() || layout.size() == 0) return;
  const int n = layout.size();
  const NormalEquations zero{0.0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
  for (int step = 0; step < steps_each; ++step) {
    const auto normal_of = [&](const Partners& p) -> Vector3d {
      return state.T_G_sensor(p.b.stop, p.b.lidar).R * p.normal_b;
    };
    std::vector<double> distances(partners.size());
    parallel_for(partners.size(), 16384, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        distances[i] = plane_distance(partners[i].a, partners[i].b, normal_of(partners[i]), state);
    });
    std::vector<double> sizes = distances;
    for (double& size : sizes) size = std::abs(size);
    // The spread of a normal variable by its median, and Cauchy's constant for it.
    const double scale = std::max(0.005, 2.385 * sigma_per_median_size * median(std::move(sizes)));
    NormalEquations sum = parallel_sum(partners.size(), 16384, zero, [&](std::size_t begin, std::size_t end) {
      NormalEquations part = zero;
      for (std::size_t i = begin; i < end; ++i) {
        const double scaled = distances[i] / scale;
        add_point_to_plane(partners[i].a, partners[i].b, normal_of(partners[i]), distances[i],
                           1.0 / (1.0 + scaled * scaled), layout, state, part);
      }
      return part;
    });
    sum.H.triangularView<Eigen::StrictlyUpper>() = sum.H.transpose().triangularView<Eigen::StrictlyUpper>();
    // What no pair holds stays where it is.
    sum.H.diagonal().array() += 1e-6 * sum.H.diagonal().mean() + 1e-9;
    state = layout.moved(state, -sum.H.ldlt().solve(sum.g));
  }
}

IcpRun run_icp(PairwiseIcp& icp, const IcpRunOptions& options, const RunContext& context, RigState& state) {
  const int stops = static_cast<int>(state.T_G_base.size());
  const int lidars = static_cast<int>(state.T_base_sensor.size());
  ParameterLayout poses(stops, lidars);
  ParameterLayout extrinsics(stops, lidars);
  ParameterLayout all(stops, lidars);
  for (int j = 1; j < stops; ++j) {
    poses.free_stop(j);
    all.free_stop(j);
  }
  for (int i = 0; i < lidars; ++i) {
    if (i == options.base) continue;
    extrinsics.free_lidar(i);
    all.free_lidar(i);
  }
  const auto reach = [&](double from, int k) {
    return std::max(icp.options().to_m, from * std::pow(icp.options().shrink, k));
  };
  IcpRun run;
  const auto start = SteadyClock::now();
  for (int k = 0; k < options.pose_iterations && !context.cancelled(); ++k) {
    icp.match(state, reach(pose_reach_share * icp.options().from_m, k), options.base);
    icp.solve(poses, state);
  }
  run.pose_s = seconds_since(start);
  bool moves_all = false;
  for (; run.iterations < options.iterations && !context.cancelled(); ++run.iterations) {
    moves_all = moves_all || run.iterations >= options.extrinsic_iterations;
    const RigState before = state;
    const double reach_m = reach(icp.options().from_m, run.iterations);
    const auto begin = SteadyClock::now();
    icp.match(state, reach_m);
    const auto matched = SteadyClock::now();
    icp.solve(moves_all ? all : extrinsics, state);
    run.match_s += seconds_between(begin, matched);
    run.solve_s += seconds_since(matched);
    if (options.after_iteration) options.after_iteration(state);
    double moved_m = 0.0;
    double moved_rad = 0.0;
    for (std::size_t i = 0; i < state.T_base_sensor.size(); ++i) {
      moved_m = std::max(moved_m, (state.T_base_sensor[i].t - before.T_base_sensor[i].t).norm());
      moved_rad = std::max(moved_rad, rotation_distance(state.T_base_sensor[i].R, before.T_base_sensor[i].R));
    }
    if (moved_m > settled_m || moved_rad > settled_rad || reach_m > icp.options().to_m) continue;
    run.settled = moves_all;
    moves_all = true;
    if (run.settled && options.stop_when_settled) {
      ++run.iterations;
      break;
    }
  }
  return run;
}

}  // namespace rigcal::targetless
