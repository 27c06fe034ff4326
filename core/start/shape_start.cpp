#include "core/start/shape_start.h"

#include <Eigen/Core>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

// More than these change the answer by less than it is worth.
constexpr std::size_t most_items = 20000;

struct PatchShapes {
  int stop = 0;
  std::vector<LocalShape> shapes;  // sensor frame, sharpened
};

std::vector<PatchShapes> shapes_of(const std::vector<PatchCells>& patches, int lidar,
                                   const std::vector<char>& stop_known, const ShapeLevel& level) {
  std::vector<const PatchCells*> chosen;
  for (const PatchCells& p : patches) {
    if (p.lidar == lidar && stop_known[static_cast<std::size_t>(p.stop)]) chosen.push_back(&p);
  }
  std::vector<PatchShapes> out(chosen.size());
  parallel_for(chosen.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      out[k] = {chosen[k]->stop, extract_shapes(*chosen[k], level.size_m)};
      for (LocalShape& s : out[k].shapes) s.covariance = sharpened(s.covariance, level.sigma_m);
    }
  });
  return out;
}

}  // namespace

ShapeMap::ShapeMap(const std::vector<PatchCells>& patches, int lidar, const std::vector<SE3>& T_G_base,
                   const std::vector<char>& stop_known)
    : T_G_base_(T_G_base), stop_known_(stop_known) {
  for (const ShapeLevel& level : shape_levels()) {
    std::vector<LocalShape> map;
    for (const PatchShapes& p : shapes_of(patches, lidar, stop_known, level)) {
      const SE3& T = T_G_base[static_cast<std::size_t>(p.stop)];
      for (const LocalShape& s : p.shapes) map.push_back({T * s.mean, T.R * s.covariance * T.R.transpose()});
    }
    maps_.emplace_back(without_repetitions(map, level.size_m), level.reach_m);
  }
}

ShapeMatch ShapeMap::place(const std::vector<PatchCells>& patches, int lidar,
                           const std::vector<SE3>& candidates) const {
  std::vector<ShapeScene> scenes;
  const std::vector<ShapeLevel> levels = shape_levels();
  for (std::size_t k = 0; k < levels.size(); ++k) {
    MovingShapes moving{T_G_base_, {}};
    for (const PatchShapes& p : shapes_of(patches, lidar, stop_known_, levels[k])) {
      for (const LocalShape& s : p.shapes) moving.items.push_back({p.stop, s});
    }
    scenes.push_back({maps_[k], thinned(moving, most_items)});
  }
  return match_shapes(scenes, candidates);
}

}  // namespace rigcal
