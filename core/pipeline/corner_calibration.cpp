#include "core/pipeline/corner_calibration.h"

#include <algorithm>
#include <set>

#include "core/base/parallel.h"
#include "core/corner/plane_rays.h"
#include "core/corner/rig_placement.h"
#include "core/pipeline/fused_map.h"
#include "core/pipeline/stage_clock.h"
#include "core/pipeline/surface_cuts.h"
#include "core/quality/shared_surfaces.h"
#include "core/quality/verdict.h"
#include "core/quality/verdict_text.h"

namespace rigcal {
namespace {

constexpr std::size_t most_stops = 8;

constexpr double least_overlap = 0.35;  // of what the poorer LiDAR saw, below which a match may be chance
constexpr double most_misfit = 3.0;

// Stops in which two LiDARs saw anything, at most so many, evenly.
std::vector<int> choose_stops(const LidarRecording& recording, std::size_t most) {
  std::vector<int> seen_by(recording.stops.size(), 0);
  for (const PatchCells& patch : recording.patches) {
    if (!patch.thinned.empty()) ++seen_by[static_cast<std::size_t>(patch.stop)];
  }
  std::vector<int> stops;
  for (std::size_t j = 0; j < seen_by.size(); ++j) {
    if (seen_by[j] >= 2) stops.push_back(static_cast<int>(j));
  }
  if (stops.size() <= most) return stops;
  std::vector<int> few;
  for (std::size_t k = 0; k < most; ++k) few.push_back(stops[k * stops.size() / most]);
  return few;
}

class CornerCalibration {
 public:
  CornerCalibration(const Rig& rig, const LidarRecording& recording, const std::vector<std::optional<SE3>>& guess,
                    const CornerCalibrationOptions& options, const RunContext& context)
      : rig_(rig), recording_(recording), guess_(guess), options_(options), context_(context) {}

  Expected<CalibrationResult> run() {
    const auto base = std::find(recording_.lidar_sensors.begin(), recording_.lidar_sensors.end(), rig_.base);
    if (base == recording_.lidar_sensors.end()) return input_error("the base sensor of the rig is no LiDAR", rig_.name);
    if (recording_.stops.empty()) return input_error("there is no stop in which the rig stands still");
    views_.base = static_cast<int>(base - recording_.lidar_sensors.begin());
    for (const int sensor : recording_.lidar_sensors) {
      views_.names.push_back(sensor_at(sensor).name);
      // A result has them in the order of the rig file.
      places_.push_back(static_cast<int>(std::count_if(recording_.lidar_sensors.begin(), recording_.lidar_sensors.end(),
                                                       [sensor](int other) { return other < sensor; })));
    }
    stops_ = choose_stops(recording_, most_stops);
    find_all_planes();
    if (context_.cancelled()) return cancelled_error();
    StageReport& stage = clock_.begin("placement");
    context_.reporter.progress("placement", -1.0);
    const RigPlacement placed = place_rig(views_, guess_);
    stage.iterations = placed.adjusted.iterations;
    stage.cost_before = placed.adjusted.cost_before;
    stage.cost_after = placed.adjusted.cost_after;
    stage.counts = {{"common_planes", static_cast<double>(placed.features.size())}, {"misfit", placed.misfit}};
    if (context_.cancelled()) return cancelled_error();
    return conclude(placed);
  }

 private:
  [[nodiscard]] const Sensor& sensor_at(int sensor) const { return rig_.sensors[static_cast<std::size_t>(sensor)]; }

  void find_all_planes() {
    StageReport& stage = clock_.begin("planes");
    context_.reporter.progress("planes", -1.0);
    views_.stops.assign(stops_.size(), std::vector<std::optional<PlaneView>>(views_.names.size()));
    std::vector<std::pair<std::size_t, const PatchCells*>> work;
    for (const PatchCells& patch : recording_.patches) {
      const auto at = std::find(stops_.begin(), stops_.end(), patch.stop);
      if (at != stops_.end() && !patch.thinned.empty()) work.emplace_back(at - stops_.begin(), &patch);
    }
    parallel_for(work.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end && !context_.cancelled(); ++k) {
        const auto& [stop, patch] = work[k];
        PlaneCloud cloud;
        for (const Point& p : patch->thinned) cloud.points.emplace_back(p.x, p.y, p.z);
        cloud.cells.cells = patch->cells;
        views_.stops[stop][static_cast<std::size_t>(patch->lidar)] = plane_view(std::move(cloud));
      }
    });
    double planes = 0.0;
    for (const auto& stop : views_.stops) {
      for (const auto& view : stop) planes += view ? static_cast<double>(view->planes.size()) : 0.0;
    }
    stage.counts = {{"stops", static_cast<double>(stops_.size())}, {"planes", planes}};
  }

  [[nodiscard]] bool has_points(std::size_t lidar) const {
    return std::any_of(recording_.patches.begin(), recording_.patches.end(),
                       [&](const PatchCells& p) { return p.lidar == static_cast<int>(lidar) && !p.thinned.empty(); });
  }

  // With what ranges may be off by: planes are laid on each other wherever they seem to be.
  [[nodiscard]] LidarCovariances covariances_of(std::vector<PlaneFeature> features, const RigState& state,
                                                const ParameterLayout& layout, const AdjustOptions& adjust) const {
    add_rays(views_, features);
    return lidar_covariances({features, state, layout, adjust, usual_range_errors});
  }

  // Of a LiDAR that planes hold, against the base.
  [[nodiscard]] static Matrix6d covariance_by_planes(std::size_t lidar, const RigPlacement& placed,
                                                     const LidarCovariances& covariances,
                                                     const Matrix6d& by_right_ranges) {
    // Planes that disagree are known no better than by what they disagree; what ranges do is in it already.
    const double factor =
        std::max({1.0, covariances.chi2, placed.misfit * placed.misfit}) / std::max(1.0, covariances.chi2);
    return covariances.with_priors[lidar] + (factor - 1.0) * by_right_ranges;
  }

  [[nodiscard]] static Matrix6d covariance_by_right_ranges(std::size_t lidar, const RigPlacement& placed) {
    return lidar_covariances({placed.features, placed.state, placed.layout, placed.adjust}).with_priors[lidar];
  }

  [[nodiscard]] static bool is_observable(std::size_t lidar, const LidarCovariances& covariances) {
    return lidar < covariances.observable.size() && covariances.observable[lidar] != 0;
  }

  // By how it lies on the LiDAR that it was laid on, that one on the next, and the first of them on the base. None: the
  // planes do not hold that one.
  [[nodiscard]] std::optional<Matrix6d> covariance_of_follower(std::size_t lidar, const RigPlacement& placed,
                                                               const LidarCovariances& covariances) const {
    const LidarPlacement& how = placed.lidars[lidar];
    if (static_cast<int>(lidar) == views_.base) return Matrix6d::Zero();
    if (!how.follows) {
      if (!is_observable(lidar, covariances)) return std::nullopt;
      return covariance_by_planes(lidar, placed, covariances, covariance_by_right_ranges(lidar, placed));
    }
    const auto via = static_cast<std::size_t>(how.via);
    const std::optional<Matrix6d> of_via = covariance_of_follower(via, placed, covariances);
    if (!of_via) return std::nullopt;
    const Matrix6d A = how.pair.T_a_b.inverse().adjoint();
    return (how.pair.by_shapes ? how.pair.by_shapes->covariance : covariance_by_pair(lidar, placed)) +
           A * *of_via * A.transpose();
  }

  // Of a LiDAR on the one that it was laid on, by the planes that both saw.
  [[nodiscard]] Matrix6d covariance_by_pair(std::size_t lidar, const RigPlacement& placed) const {
    const LidarPlacement& how = placed.lidars[lidar];
    const std::vector<std::optional<PlaneView>>& views = views_.stops[static_cast<std::size_t>(how.stop)];
    const std::vector<SeenPlane>& of_via = views[static_cast<std::size_t>(how.via)]->planes;
    const std::vector<SeenPlane>& own = views[lidar]->planes;
    std::vector<CommonPlane> planes;
    for (const auto& [a, b] : how.pair.matches) {
      planes.push_back({how.stop, {{how.via, of_via[a]}, {static_cast<int>(lidar), own[b]}}});
    }
    ParameterLayout layout(placed.layout.stops(), placed.layout.lidars());
    layout.free_lidar(static_cast<int>(lidar));
    return covariances_of(features_of(planes, placed.state), placed.state, layout, placed.adjust).with_priors[lidar];
  }

  // A LiDAR between this one and the base whose place is one of two.
  [[nodiscard]] std::optional<std::size_t> unsure_on_the_way(const LidarPlacement& how,
                                                             const RigPlacement& placed) const {
    for (int via = how.via; via != views_.base;) {
      const auto at = static_cast<std::size_t>(via);
      const LidarPlacement& between = placed.lidars[at];
      if (is_one_of_two(between.pair, guess_[at].has_value())) return at;
      via = between.via;
    }
    return std::nullopt;
  }

  [[nodiscard]] Verdict judge(std::size_t lidar, const RigPlacement& placed, const LidarCovariances& covariances,
                              Matrix6d& covariance) const {
    const LidarPlacement& how = placed.lidars[lidar];
    LidarEvidence e;
    e.name = views_.names[lidar];
    e.base_name = rig_.base_sensor().name;
    e.has_points = has_points(lidar);
    e.saw_too_far = recording_.saw_too_far(lidar);
    e.base_has_points = has_points(static_cast<std::size_t>(views_.base));
    if (e.has_points && e.base_has_points && !how.known) {
      Verdict verdict;
      fail(verdict, how.why_not + "; show both a corner: three large flat surfaces that face clearly different ways");
      return verdict;
    }
    const std::optional<Matrix6d> as_follower =
        how.follows ? covariance_of_follower(lidar, placed, covariances) : std::nullopt;
    e.observable = how.follows ? as_follower.has_value() : is_observable(lidar, covariances);
    e.converged = how.follows || placed.adjusted.converged;
    e.has_guess = guess_[lidar].has_value();
    Matrix6d by_right_ranges = Matrix6d::Zero();
    if (as_follower) {
      e.covariance = e.covariance_data_only = covariance = *as_follower;
    } else if (e.observable) {
      by_right_ranges = covariance_by_right_ranges(lidar, placed);
      e.covariance = e.covariance_data_only = covariance =
          covariance_by_planes(lidar, placed, covariances, by_right_ranges);
    }
    e.T_base_sensor = placed.state.T_base_sensor[lidar];
    Verdict verdict = judge_lidar(e, options_.require);
    if (verdict.status == Status::failed) return verdict;
    if (!how.follows && translation_bound(e.covariance) > options_.require.translation_m &&
        translation_bound(by_right_ranges) <= options_.require.translation_m) {
      weaken(verdict,
             "most of that is what the ranges of the LiDARs may be off by, each unit's by a centimetre or two, "
             "which these planes do not tell; record more stops, in other corners, or longer ones, or ask for "
             "less (--require)");
    }
    if (how.pair.by_shapes) {
      weaken(verdict, "three independent, even planes are not common to it and " +
                          views_.names[static_cast<std::size_t>(how.via)] +
                          ": all the shapes that both saw hold it, which is known to centimetres; show both a corner "
                          "of three large flat surfaces");
    } else if (how.follows) {
      weaken(verdict, "it was laid on " + views_.names[static_cast<std::size_t>(how.via)] +
                          ", which no planes join with " + e.base_name +
                          ": it is known no better than that one; show that one and " + e.base_name +
                          " a corner of three large flat surfaces");
    }
    if (is_one_of_two(how.pair, e.has_guess)) {
      weaken(verdict, "another pose fits its surfaces, too (" +
                          number(100.0 * std::max(how.pair.runner_up_score, how.pair.other_order_score), 0) +
                          " % against " + number(100.0 * how.pair.score, 0) + " % lie on what " +
                          views_.names[static_cast<std::size_t>(how.via)] + " saw); give " +
                          (e.has_guess ? "a closer" : "a") +
                          " rough pose under initial_extrinsics (45 degrees are close enough), or choose a corner "
                          "without right angles");
    }
    if (const auto unsure = unsure_on_the_way(how, placed)) {
      weaken(verdict, "it was laid on " + views_.names[*unsure] +
                          ", for whose own place another pose fits nearly as well; give a rough pose of " +
                          views_.names[*unsure] + " under initial_extrinsics, or choose a corner without right angles");
    }
    if (how.pair.score < least_overlap) {
      weaken(verdict, "only " + number(100.0 * how.pair.score, 0) + " % of what it and " +
                          views_.names[static_cast<std::size_t>(how.via)] +
                          " saw lies on each other; choose a place where both see the same surfaces");
    }
    if (placed.misfit > most_misfit) {
      weaken(
          verdict,
          "the common planes disagree by " + number(placed.misfit, 1) +
              " times what their noise explains; the LiDARs measure ranges differently (units differ by a centimetre), "
              "something moved, or the surfaces are not flat: record again before large flat walls, with all at rest");
    }
    return verdict;
  }

  CalibrationResult conclude(const RigPlacement& placed) {
    clock_.begin("verdict");
    LidarCovariances covariances;
    if (!placed.features.empty()) {
      covariances = covariances_of(placed.features, placed.state, placed.layout, placed.adjust);
    }
    CalibrationResult result;
    result.base = rig_.base_sensor().name;
    result.method = "planes";
    result.status = Status::good;
    result.sensors.resize(views_.names.size());
    for (std::size_t i = 0; i < views_.names.size(); ++i) {
      SensorResult sensor{views_.names[i], Status::good, {}, SE3{}};
      sensor.guess_T_base_sensor = guess_[i];
      if (static_cast<int>(i) != views_.base || !has_points(i)) {
        const Verdict verdict = judge(i, placed, covariances, sensor.covariance);
        sensor.status = verdict.status;
        sensor.reasons = verdict.reasons;
        sensor.T_base_sensor.reset();
        if (verdict.status == Status::failed) {
          sensor.covariance.setZero();
        } else {
          sensor.T_base_sensor = placed.state.T_base_sensor[i];
        }
      }
      result.status = std::max(result.status, sensor.status);
      result_of(i, result) = std::move(sensor);
    }
    const std::vector<int> used = used_views(placed);
    // What nobody used has nothing to show, but something must be shown.
    const int shown = used.empty() ? 0 : used.front();
    add_stops(used, shown, result);
    if (!stops_.empty()) show(placed, shown, result);
    result.stages = clock_.take();
    return result;
  }

  [[nodiscard]] SensorResult& result_of(std::size_t lidar, CalibrationResult& result) const {
    return result.sensors[static_cast<std::size_t>(places_[lidar])];
  }

  // Those of `views_` whose planes or shapes hold a LiDAR, in order.
  [[nodiscard]] std::vector<int> used_views(const RigPlacement& placed) const {
    std::set<int> used;
    for (const PlaneFeature& feature : placed.features) used.insert(feature.observations.front().stop);
    for (const LidarPlacement& how : placed.lidars) {
      if (how.follows) used.insert(how.stop);
    }
    return {used.begin(), used.end()};
  }

  // Only the first stop that was used has a place: how the rig moved to the others nobody asked.
  void add_stops(const std::vector<int>& used, int shown, CalibrationResult& result) const {
    for (const Stop& stop : recording_.stops) result.trajectory.push_back({stop, SE3{}, false});
    for (const int view : used) result.trajectory[stop_of(view)].took_part = true;
    if (!used.empty()) result.trajectory[stop_of(shown)].known = true;
    for (const PatchCells& patch : recording_.patches) {
      StopPose& stop = result.trajectory[static_cast<std::size_t>(patch.stop)];
      stop.points[views_.names[static_cast<std::size_t>(patch.lidar)]] += patch.points;
    }
  }

  [[nodiscard]] std::size_t stop_of(int view) const {
    return static_cast<std::size_t>(stops_[static_cast<std::size_t>(view)]);
  }

  // Map and cut surfaces of one of `views_`.
  void show(const RigPlacement& placed, int view, CalibrationResult& result) {
    StageReport& stage = clock_.begin("map");
    const auto stop = static_cast<int>(stop_of(view));
    RigState after = placed.state;
    after.T_G_base.assign(recording_.stops.size(), SE3{});
    RigState before = after;
    for (std::size_t i = 0; i < guess_.size(); ++i) {
      if (guess_[i]) before.T_base_sensor[i] = *guess_[i];
    }
    std::vector<char> use(recording_.patches.size(), 0);
    std::vector<char> had_guess(use.size(), 0);
    for (std::size_t k = 0; k < use.size(); ++k) {
      const PatchCells& patch = recording_.patches[k];
      const auto lidar = static_cast<std::size_t>(patch.lidar);
      use[k] = patch.stop == stop && result_of(lidar, result).T_base_sensor.has_value() ? 1 : 0;
      had_guess[k] = use[k] != 0 && guess_[lidar] ? 1 : 0;
    }
    result.map = fuse_map(recording_.patches, after, use, places_, options_.map_size_m);
    stage.counts.emplace_back("points", static_cast<double>(result.map.size()));
    std::vector<PlaneFeature> features;
    for (const PlaneFeature& f : placed.features) {
      if (f.observations.front().stop == view) features.push_back(f);
    }
    for (PlaneFeature& f : features) {
      for (PlaneObservation& o : f.observations) o.stop = stop;
    }
    result.shared_surfaces = shared_surfaces(features, before, after, views_.names);
    result.cuts = cut_surfaces(features, recording_.patches, before, after, had_guess, places_);
    result.map_at_guess = fuse_map_to_look_at(recording_.patches, before, had_guess, places_);
  }

  const Rig& rig_;
  const LidarRecording& recording_;
  const std::vector<std::optional<SE3>>& guess_;
  const CornerCalibrationOptions& options_;
  const RunContext& context_;
  RigViews views_;
  std::vector<int> places_;  ///< Of the LiDARs among the result's sensors.
  std::vector<int> stops_;   ///< Of the recording, those of `views_`.
  StageClock clock_;
};

}  // namespace

Expected<CalibrationResult> calibrate_by_planes(const Rig& rig, const LidarRecording& recording,
                                                const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                                const CornerCalibrationOptions& options, const RunContext& context) {
  return CornerCalibration(rig, recording, guess_T_base_sensor, options, context).run();
}

}  // namespace rigcal
