#include "apps/experiment/targetless/camera_experiment.h"

#include <array>
#include <cmath>

#include "apps/experiment/targetless/fixed_voxels.h"
#include "apps/experiment/targetless/mutual_information.h"
#include "apps/experiment/targetless/published.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/seconds.h"
#include "core/camera/edge_solver.h"
#include "simdata/scene/random_vectors.h"

namespace rigcal::targetless {
namespace {

constexpr std::uint64_t guess_stream = 970;
enum Method : std::size_t { ours, ransac, information, methods };
constexpr std::array<const char*, methods> method_names{"rigcal", "fixed voxels", "information"};

// All points of the map, in the world.
std::vector<Vector3d> map_points(const CameraSide& side) {
  std::vector<Vector3d> out;
  for (const PatchCells& patch : side.patches) {
    const SE3 T = side.solution->state.T_G_sensor(patch.stop, patch.lidar);
    for (const Point& p : patch.thinned) out.push_back(T * Vector3d(p.x, p.y, p.z));
  }
  return out;
}

SE3 spoiled_camera(const SE3& T, const published::CameraGuesses& guesses, Random& random) {
  const double angle_deg = guesses.rotation_deg + guesses.rotation_spread_deg * random.normal();
  const double shift_m = guesses.translation_m + guesses.translation_spread_m * random.normal();
  const Vector3d turn = to_rad(std::abs(angle_deg)) * sim::random_direction(random);
  const Vector3d shift = std::abs(shift_m) * sim::random_direction(random);
  return {T.R * exp_so3(turn), T.t + shift};
}

// Errors of one method with one LiDAR, of cameras and of pairs of them.
struct Errors {
  std::vector<double> rotation_rad;
  std::vector<double> translation_m;
  int trials = 0;
  double seconds = 0.0;

  void add(const std::optional<SE3>& found, const SE3& truth) {
    ++trials;
    if (!found) return;
    rotation_rad.push_back(rotation_distance(found->R, truth.R));
    translation_m.push_back((found->t - truth.t).norm());
  }

  [[nodiscard]] CameraRow row(const char* pair, const CameraSide& side, std::size_t method) const {
    CameraRow out;
    out.pair = pair;
    out.lidar = side.lidar;
    out.overlaps = side.overlaps;
    out.method = method_names[method];
    out.trials = trials;
    out.found = static_cast<int>(rotation_rad.size());
    out.rotation_rad = mean_spread(rotation_rad);
    out.translation_m = mean_spread(translation_m);
    out.median_rotation_rad = median(rotation_rad);
    out.median_translation_m = median(translation_m);
    out.seconds = trials > 0 ? seconds / trials : 0.0;
    return out;
  }
};

Expected<std::optional<SE3>> find_by_edges(const CameraScene& scene, const CameraTask& task,
                                           const RunContext& context) {
  SilentReporter silent;
  const Expected<CameraEstimate> estimate = calibrate_camera(scene, task, {}, {silent, context.stop});
  if (!estimate) return estimate.error();
  return estimate->found ? std::optional(estimate->pose.T_base_camera) : std::nullopt;
}

Expected<std::optional<SE3>> find_camera(std::size_t method, const CameraSide& side, const CameraScene& fixed,
                                         const CameraTask& task, const RunContext& context) {
  if (method == ours) return find_by_edges(side.scene, task, context);
  if (method == ransac) return find_by_edges(fixed, task, context);
  const auto found = maximise_information(side.scene, task, *task.guess_T_base_camera);
  return found ? std::optional(found->T_base_camera) : std::nullopt;
}

Expected<void> try_side(const CameraSide& side, int trials, std::uint64_t seed, const RunContext& context,
                        CameraExperiment& out) {
  CameraScene fixed = side.scene;
  fixed.edges = find_edges_in_fixed_voxels(map_points(side), {}).edges;
  std::array<Errors, methods> cameras;
  std::array<Errors, methods> pairs;
  const published::CameraGuesses& guesses = side.overlaps ? published::fig13 : published::fig14;
  for (int k = 0; k < trials; ++k) {
    context.reporter.progress("cameras by " + side.lidar, static_cast<double>(k) / trials);
    std::array<std::vector<std::optional<SE3>>, methods> found;
    Random random(seed + static_cast<std::uint64_t>(k), guess_stream);
    for (std::size_t c = 0; c < side.cameras.size(); ++c) {
      CameraTask task = side.cameras[c];
      task.guess_T_base_camera = spoiled_camera(side.T_lidar_camera[c], guesses, random);
      for (std::size_t method = 0; method < methods; ++method) {
        const auto begin = SteadyClock::now();
        const auto answer = find_camera(method, side, fixed, task, context);
        if (!answer) return answer.error();
        if (context.cancelled()) return cancelled_error();
        cameras[method].seconds += seconds_since(begin);
        cameras[method].add(*answer, side.T_lidar_camera[c]);
        found[method].push_back(*answer);
      }
    }
    const SE3 truth = side.T_lidar_camera[0].inverse() * side.T_lidar_camera[1];
    for (std::size_t method = 0; method < methods; ++method) {
      const auto& both = found[method];
      pairs[method].add(both[0] && both[1] ? std::optional(both[0]->inverse() * *both[1]) : std::nullopt, truth);
    }
  }
  for (std::size_t method = 0; method < methods; ++method)
    out.rows.push_back(cameras[method].row("LiDAR to camera", side, method));
  for (std::size_t method = 0; method < methods; ++method)
    out.rows.push_back(pairs[method].row("camera to camera", side, method));
  return {};
}

// The middle one of a few.
template <class Work>
double middle_seconds(const Work& work) {
  constexpr int repetitions = 5;
  std::vector<double> all;
  for (int k = 0; k < repetitions; ++k) {
    const auto begin = SteadyClock::now();
    work();
    all.push_back(seconds_since(begin));
  }
  return median(std::move(all));
}

// One matching and one step with all images, as the solver does them; what is not matching is solving.
void measure_iteration(const CameraScene& scene, const CameraTask& task, const SE3& T_base_camera, CameraSeconds& out) {
  std::vector<EdgeView> views = make_edge_views(scene, task);
  const CameraState state{T_base_camera};
  find_visible(scene, task.intrinsics, state, VisibleOptions{}, views);
  const MatchOptions match = standard_levels().back().match;
  const CameraModel model(task.intrinsics);
  out.match_s = middle_seconds([&] {
    parallel_for(views.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t v = first; v < last; ++v) {
        const SE3& T_G_base = scene.T_G_base[static_cast<std::size_t>(views[v].stop)];
        static_cast<void>(match_view(scene, views[v], camera_at(model, state, T_G_base), match));
      }
    });
  });
  const double all_s =
      middle_seconds([&] { static_cast<void>(sum_segments(scene, task.intrinsics, state, match, views)); });
  out.solve_s = std::max(0.0, all_s - out.match_s);
  out.edge_points = scene.edges.size();
}

}  // namespace

Expected<CameraExperiment> try_cameras(int trials, const CameraSetOptions& options, const RunContext& context) {
  Expected<std::vector<CameraSide>> sides = make_camera_sides(options, context);
  if (!sides) return sides.error();
  CameraExperiment out;
  out.trials = trials;
  for (const CameraSide& side : *sides) {
    if (const auto done = try_side(side, trials, options.seed, context, out); !done) return done.error();
  }
  // As they were drawn for the first LiDAR.
  std::vector<double> rotations;
  std::vector<double> translations;
  for (int k = 0; k < trials; ++k) {
    Random random(options.seed + static_cast<std::uint64_t>(k), guess_stream);
    for (const SE3& truth : sides->front().T_lidar_camera) {
      const SE3 guess = spoiled_camera(truth, published::fig13, random);
      rotations.push_back(rotation_distance(guess.R, truth.R));
      translations.push_back((guess.t - truth.t).norm());
    }
  }
  out.guess_rotation_rad = mean_spread(rotations);
  out.guess_translation_m = mean_spread(translations);
  context.reporter.progress("cameras", 1.0);
  return out;
}

Expected<std::vector<CameraSeconds>> measure_cameras(const CameraSetOptions& options, const RunContext& context) {
  Expected<std::vector<CameraSide>> sides = make_camera_sides(options, context);
  if (!sides) return sides.error();
  const CameraSide& side = sides->front();
  const CameraTask& task = side.cameras.front();
  const SE3& T = side.T_lidar_camera.front();

  CameraSeconds by_ours{method_names[ours]};
  const RigState& state = side.solution->state;
  const auto begin = SteadyClock::now();
  const PlaneMap map =
      build_plane_map(side.patches, state, side.solution->noise, side.solution->T_grid_G, PlaneMapOptions{});
  by_ours.planes_s = side.cells_s + seconds_since(begin);
  by_ours.voxels = map.features.size();
  const auto planed = SteadyClock::now();
  static_cast<void>(find_lidar_edges(map.features, side.patches, state, side.solution->noise, {}));
  by_ours.edges_s = seconds_since(planed);
  measure_iteration(side.scene, task, T, by_ours);

  CameraSeconds by_ransac{method_names[ransac]};
  const FixedVoxelEdges edges = find_edges_in_fixed_voxels(map_points(side), {});
  by_ransac.planes_s = edges.planes_s;
  by_ransac.edges_s = edges.edges_s;
  by_ransac.voxels = edges.voxels;
  CameraScene fixed = side.scene;
  fixed.edges = edges.edges;
  measure_iteration(fixed, task, T, by_ransac);

  CameraSeconds by_information{method_names[information]};
  if (const auto found = maximise_information(side.scene, task, T); found && found->evaluations > 0) {
    by_information.match_s = found->match_s / found->evaluations;
    by_information.solve_s = found->solve_s / found->evaluations;
  }
  return std::vector<CameraSeconds>{by_ours, by_ransac, by_information};
}

}  // namespace rigcal::targetless
