#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "core/geometry/symmetric_eigen.h"
#include "core/voxel/plane_gate.h"

namespace rigcal {

/// The plane map as one would write it first: cells dealt into voxels by std::map at every size anew, no codes, no
/// sorting, one thread. Shares only the fit of a single voxel with the real one.
class NaivePlaneMap {
 public:
  NaivePlaneMap(const std::vector<PatchCells>& patches, const RigState& state, const std::vector<NoiseModel>& noise,
                const SE3& T_grid_G, const PlaneMapOptions& options)
      : context_{patches, state, noise, options}, T_grid_G_(T_grid_G) {
    std::vector<WorldCell> all;
    for (std::uint32_t k = 0; k < patches.size(); ++k) {
      const SE3 T = state.T_G_sensor(patches[k].stop, patches[k].lidar);
      for (std::uint32_t i = 0; i < patches[k].pieces.size(); ++i) all.push_back(moved(patches[k].pieces[i], T, k, i));
    }
    deal(all, options.root_size_m);
  }

  [[nodiscard]] const std::vector<PlaneFeature>& features() const { return features_; }
  [[nodiscard]] std::size_t leaves_dropped() const { return leaves_dropped_; }
  [[nodiscard]] const PlaneFeature* nearest(const Vector3d& center_G) const {
    return &*std::min_element(features_.begin(), features_.end(), [&](const auto& a, const auto& b) {
      return (a.center_G - center_G).norm() < (b.center_G - center_G).norm();
    });
  }

 private:
  static WorldCell moved(const Cell& cell, const SE3& T, std::uint32_t patch, std::uint32_t index) {
    WorldCell w;
    w.patch = patch;
    w.cell = index;
    w.N = cell.N;
    w.mean = T * cell.mean;
    const Matrix3d S = T.R * cell.scatter_matrix() * T.R.transpose();
    w.scatter << S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2);
    w.noise_share = cell.noise_share;
    w.noise_shift_per_m = cell.noise_shift_per_m;
    w.darkness = cell.darkness;
    return w;
  }

  void deal(const std::vector<WorldCell>& cells, double size) {
    std::map<std::array<long, 3>, std::vector<WorldCell>> voxels;
    for (const WorldCell& cell : cells) {
      const Vector3d p = T_grid_G_ * cell.mean / size;
      voxels[{std::lround(std::floor(p.x())), std::lround(std::floor(p.y())), std::lround(std::floor(p.z()))}]
          .push_back(cell);
    }
    for (const auto& [key, members] : voxels) judge(members, size);
  }

  // `cells` come sorted by patch, as they were made.
  void judge(const std::vector<WorldCell>& cells, double size) {
    const PlaneMapOptions& o = context_.options;
    CellTotal total;
    for (const WorldCell& c : cells) {
      total.N += c.N;
      total.mean += c.N * c.mean;
    }
    total.mean /= total.N;
    for (const WorldCell& c : cells) {
      const Cell full{c.N, c.mean, c.scatter};
      total.scatter += full.scatter_matrix() + c.N * (c.mean - total.mean) * (c.mean - total.mean).transpose();
    }
    if (total.N < o.min_points || cells.front().patch == cells.back().patch) {
      ++leaves_dropped_;
      return;
    }
    const Vector3d l = symmetric_eigen(total.scatter / total.N).values;
    PlaneFeature feature;
    std::size_t kept = 0;
    if (l[1] >= o.min_flatness * l[0] && l[2] <= o.max_elongation * l[1] && std::sqrt(l[0]) <= o.max_thickness_m &&
        gate_plane(cells, total, context_, feature, kept) == PlaneVerdict::plane) {
      feature.size_m = size;
      features_.push_back(feature);
    } else if (size <= o.min_size_m) {
      ++leaves_dropped_;
    } else {
      deal(cells, 0.5 * size);
    }
  }

  GateContext context_;
  SE3 T_grid_G_;
  std::vector<PlaneFeature> features_;
  std::size_t leaves_dropped_ = 0;
};

}  // namespace rigcal
