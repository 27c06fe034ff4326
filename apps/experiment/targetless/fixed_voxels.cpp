#include "apps/experiment/targetless/fixed_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/seconds.h"
#include "core/corner/ransac_planes.h"
#include "core/edges/edge_candidates.h"

namespace rigcal::targetless {
namespace {

// So many draws find a plane with a tenth of the points nearly always.
constexpr int most_draws = 400;
constexpr std::size_t least_near = 2;

struct Voxel {
  std::array<int, 3> place{};
  std::vector<Vector3d> points;
  std::vector<FittedPlane> planes;
  std::vector<LidarEdge> edges;  // `line` counts from 0
};

std::vector<Voxel> voxels_of(const std::vector<Vector3d>& points, const FixedVoxelOptions& options) {
  struct Placed {
    std::array<int, 3> place;
    std::size_t point;
  };
  std::vector<Placed> placed(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int k = 0; k < 3; ++k)
      placed[i].place[static_cast<std::size_t>(k)] = static_cast<int>(std::floor(points[i][k] / options.size_m));
    placed[i].point = i;
  }
  std::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return a.place != b.place ? a.place < b.place : a.point < b.point;
  });
  std::vector<Voxel> out;
  for (std::size_t begin = 0; begin < placed.size();) {
    std::size_t end = begin;
    while (end < placed.size() && placed[end].place == placed[begin].place) ++end;
    if (end - begin >= options.min_points) {
      out.push_back({placed[begin].place, {}, {}, {}});
      for (std::size_t i = begin; i < end; ++i) out.back().points.push_back(points[placed[i].point]);
    }
    begin = end;
  }
  return out;
}

void find_planes(const FixedVoxelOptions& options, Voxel& voxel) {
  RansacOptions ransac;
  ransac.planes = options.planes;
  ransac.threshold_m = options.threshold_m;
  ransac.min_share = options.min_share;
  ransac.max_draws = most_draws;
  voxel.planes = ransac_planes(voxel.points, ransac);
  // Near an edge the first plane has taken points of the second, which would turn it: fitted again without these.
  const std::vector<FittedPlane> found = voxel.planes;
  for (std::size_t k = 0; k < found.size(); ++k) {
    PointCluster own;
    for (const Vector3d& p : voxel.points) {
      bool only = true;
      for (std::size_t other = 0; other < found.size() && only; ++other)
        only = (std::abs(found[other].distance(p)) < options.threshold_m) == (other == k);
      if (only) own.add(p);
    }
    const auto fitted = fit_plane(own);
    if (fitted && own.N >= 0.5 * static_cast<double>(options.min_points) * options.min_share) voxel.planes[k] = *fitted;
  }
}

bool has_near(const Voxel& voxel, const FittedPlane& plane, const Vector3d& p, const FixedVoxelOptions& options) {
  std::size_t near = 0;
  for (const Vector3d& q : voxel.points) {
    if ((q - p).squaredNorm() < options.near_m * options.near_m && std::abs(plane.distance(q)) < options.threshold_m &&
        ++near >= least_near)
      return true;
  }
  return false;
}

void find_edges(const FixedVoxelOptions& options, Voxel& voxel) {
  Vector3d middle;
  for (int k = 0; k < 3; ++k) middle[k] = (voxel.place[static_cast<std::size_t>(k)] + 0.5) * options.size_m;
  int line = 0;
  for (std::size_t a = 0; a < voxel.planes.size(); ++a) {
    for (std::size_t b = a + 1; b < voxel.planes.size(); ++b) {
      const FittedPlane& one = voxel.planes[a];
      const FittedPlane& other = voxel.planes[b];
      if (std::abs(one.normal.dot(other.normal)) > std::cos(options.min_angle_rad)) continue;
      const Line3 edge = intersect({one.normal, one.offset_m}, {other.normal, other.offset_m}, middle);
      const Matrix3d across = Matrix3d::Identity() - edge.direction * edge.direction.transpose();
      const int steps = static_cast<int>(options.size_m / options.sample_m);
      for (int k = -steps; k <= steps; ++k) {
        const Vector3d p = edge.p + k * options.sample_m * edge.direction;
        if ((p - middle).cwiseAbs().maxCoeff() > 0.5 * options.size_m) continue;
        if (!has_near(voxel, one, p, options) || !has_near(voxel, other, p, options)) continue;
        voxel.edges.push_back(
            {p, edge.direction, one.normal, other.normal, options.sigma_m * options.sigma_m * across, 0.0, line});
      }
      ++line;
    }
  }
}

}  // namespace

FixedVoxelEdges find_edges_in_fixed_voxels(const std::vector<Vector3d>& points_G, const FixedVoxelOptions& options) {
  const auto begin = SteadyClock::now();
  std::vector<Voxel> voxels = voxels_of(points_G, options);
  parallel_for(voxels.size(), 16, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) find_planes(options, voxels[i]);
  });
  const auto planed = SteadyClock::now();
  parallel_for(voxels.size(), 16, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) find_edges(options, voxels[i]);
  });
  const auto edged = SteadyClock::now();
  FixedVoxelEdges out;
  out.voxels = voxels.size();
  int lines = 0;
  for (const Voxel& voxel : voxels) {
    out.planes += voxel.planes.size();
    int last = -1;
    for (LidarEdge edge : voxel.edges) {
      last = std::max(last, edge.line);
      edge.line += lines;
      out.edges.push_back(edge);
    }
    lines += last + 1;
  }
  out.planes_s = seconds_between(begin, planed);
  out.edges_s = seconds_between(planed, edged);
  return out;
}

}  // namespace rigcal::targetless
