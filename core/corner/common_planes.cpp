#include "core/corner/common_planes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/corner/plane_shares.h"

namespace rigcal {
namespace {

constexpr double least_points = 20.0;

std::size_t as_index(int i) { return static_cast<std::size_t>(i); }

SeenPlane moved(const SeenPlane& seen, const SE3& T) {
  SeenPlane out = seen;
  out.plane.normal = T.R * seen.plane.normal;
  out.plane.offset_m = seen.plane.offset_m + out.plane.normal.dot(T.t);
  out.plane.points = seen.plane.points.transformed(T);
  return out;
}

void add_common_planes(const RigViews& views, std::size_t stop, const std::vector<char>& use, const RigState& state,
                       const PlaneMatchTolerance& tolerance, std::vector<CommonPlane>& out) {
  std::vector<SeenPlane> known;  // in the base's frame, one for each of `planes`
  std::vector<CommonPlane> planes;
  for (std::size_t i = 0; i < views.names.size(); ++i) {
    const auto& view = views.stops[stop][i];
    if (!view || use[i] == 0) continue;
    std::vector<char> met(view->planes.size(), 0);
    for (const auto& [k, j] : match_planes(known, view->planes, state.T_base_sensor[i], tolerance)) {
      planes[k].seen.push_back({static_cast<int>(i), view->planes[j]});
      met[j] = 1;
    }
    for (std::size_t j = 0; j < met.size(); ++j) {
      if (met[j] != 0) continue;
      known.push_back(moved(view->planes[j], state.T_base_sensor[i]));
      planes.push_back({static_cast<int>(stop), {{static_cast<int>(i), view->planes[j]}}});
    }
  }
  for (CommonPlane& plane : planes) {
    if (plane.seen.size() > 1) out.push_back(std::move(plane));
  }
}

// The plane of all that was seen of it, in the base's frame.
FittedPlane merged(const CommonPlane& common, const RigState& state) {
  PointCluster points;
  for (const CommonPlane::Seen& seen : common.seen) {
    points += seen.plane.plane.points.transformed(state.T_base_sensor[as_index(seen.lidar)]);
  }
  const auto plane = fit_plane(points);
  return plane ? *plane : FittedPlane{};
}

std::vector<Vector3d> points_in_base(const RigViews& views, int stop, int lidar, const RigState& state) {
  std::vector<Vector3d> points = views.stops[as_index(stop)][as_index(lidar)]->cloud.points;
  const SE3& T = state.T_base_sensor[as_index(lidar)];
  for (Vector3d& p : points) p = T * p;
  return points;
}

// All planes of one stop at once, in the base's frame.
class StopRefit {
 public:
  StopRefit(const RigViews& views, int stop, const RigState& state, std::vector<CommonPlane*> planes)
      : state_(state), planes_(std::move(planes)) {
    for (const CommonPlane* plane : planes_) {
      merged_.push_back(merged(*plane, state));
      for (const CommonPlane::Seen& seen : plane->seen) {
        if (!points_.contains(seen.lidar)) points_[seen.lidar] = points_in_base(views, stop, seen.lidar, state);
      }
    }
    for (std::size_t k = 0; k < planes_.size(); ++k) areas_.push_back(common_area(k));
  }

  void run() {
    for (const auto& [lidar, points] : points_) refit(lidar, points);
    for (CommonPlane* plane : planes_) {
      std::erase_if(plane->seen, [](const CommonPlane::Seen& s) { return s.plane.plane.points.N < least_points; });
    }
  }

 private:
  [[nodiscard]] PlaneArea common_area(std::size_t k) const {
    const double each = 1.0 / static_cast<double>(planes_[k]->seen.size());
    std::vector<PlaneArea> areas;
    for (const CommonPlane::Seen& seen : planes_[k]->seen) {
      FittedPlane plane = merged_[k];
      plane.sigma_m = seen.plane.plane.sigma_m;
      areas.emplace_back(plane, points_.at(seen.lidar), part_size_m(plane.points.scaled(each)));
    }
    return PlaneArea::common(areas);
  }

  void refit(int lidar, const std::vector<Vector3d>& points) {
    std::vector<CommonPlane::Seen*> seen;
    std::vector<PlaneShare> shares;
    std::vector<PlaneArea> areas;
    for (std::size_t k = 0; k < planes_.size(); ++k) {
      for (CommonPlane::Seen& one : planes_[k]->seen) {
        if (one.lidar != lidar) continue;
        seen.push_back(&one);
        shares.push_back({merged_[k], one.share});
        shares.back().plane.sigma_m = one.plane.plane.sigma_m;
        areas.push_back(areas_[k]);
      }
    }
    const std::vector<PlaneShare> fitted = shared_out(points, shares, areas);
    const SE3 T_sensor_base = state_.T_base_sensor[as_index(lidar)].inverse();
    for (std::size_t q = 0; q < fitted.size(); ++q) {
      const SeenPlane in_base{fitted[q].plane, areas[q].area_m2(), seen[q]->plane.unevenness_m,
                              seen[q]->plane.points_per_part};
      seen[q]->plane = moved(in_base, T_sensor_base);
      seen[q]->share = fitted[q].share;
    }
  }

  const RigState& state_;
  std::vector<CommonPlane*> planes_;
  std::vector<FittedPlane> merged_;
  std::map<int, std::vector<Vector3d>> points_;  ///< By LiDAR.
  std::vector<PlaneArea> areas_;
};

}  // namespace

std::vector<CommonPlane> find_common_planes(const RigViews& views, const std::vector<char>& use, const RigState& state,
                                            const PlaneMatchTolerance& tolerance) {
  std::vector<CommonPlane> out;
  for (std::size_t stop = 0; stop < views.stops.size(); ++stop) {
    add_common_planes(views, stop, use, state, tolerance, out);
  }
  return out;
}

std::vector<CommonPlane> on_common_parts(const RigViews& views, const std::vector<CommonPlane>& planes,
                                         const RigState& state) {
  std::vector<CommonPlane> out = planes;
  std::map<int, std::vector<CommonPlane*>> by_stop;
  for (CommonPlane& plane : out) by_stop[plane.stop].push_back(&plane);
  for (const auto& [stop, here] : by_stop) StopRefit(views, stop, state, here).run();
  std::erase_if(out, [](const CommonPlane& plane) { return plane.seen.size() < 2; });
  return out;
}

std::vector<PlaneFeature> features_of(const std::vector<CommonPlane>& planes, const RigState& state) {
  std::vector<PlaneFeature> features;
  for (const CommonPlane& common : planes) {
    PlaneFeature& feature = features.emplace_back();
    const FittedPlane plane = merged(common, state);
    feature.center_G = plane.points.mean();
    feature.normal_G = plane.normal;
    for (const CommonPlane::Seen& seen : common.seen) {
      const PlaneMoments moments = moments_of(seen.plane.plane.points);
      PlaneObservation& o = feature.observations.emplace_back();
      o.stop = common.stop;
      o.lidar = seen.lidar;
      o.N = moments.N;
      o.mean = moments.mean;
      o.scatter = moments.scatter_matrix();
      o.weight = seen.plane.weight();
      o.offset_variance = 1.0 / (o.weight * o.N);
      feature.size_m = std::max(feature.size_m, std::sqrt(seen.plane.area_m2));
    }
  }
  return features;
}

}  // namespace rigcal
