#include "apps/experiment/planes_experiment.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/experiment/independent_trials.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/base/seconds.h"
#include "core/corner/paper_method.h"
#include "core/corner/rig_placement.h"
#include "core/pipeline/corner_calibration.h"
#include "core/voxel/patch_of_points.h"
#include "simdata/scene/random_vectors.h"
#include "simdata/targets/corner_scans.h"

namespace rigcal {
namespace {

constexpr int angles = 7;  // 60 to 120 degrees by 10

// Rotation rad, its spread, translation m, its spread, as printed: configuration 1, then 2, by angle.
constexpr std::array<std::array<ErrorFigures, angles>, 2> printed{{{{{0.0035, 0.0035, 0.0107, 0.0161},
                                                                     {0.0, 0.0, 0.0001, 0.0},
                                                                     {0.0024, 0.0056, 0.0045, 0.0085},
                                                                     {0.0016, 0.0040, 0.0100, 0.0243},
                                                                     {0.0051, 0.0107, 0.0087, 0.0178},
                                                                     {0.0043, 0.0063, 0.0097, 0.0161},
                                                                     {0.0018, 0.0051, 0.0083, 0.0243}}},
                                                                   {{{0.0096, 0.0104, 0.0260, 0.0349},
                                                                     {0.0036, 0.0083, 0.0101, 0.0274},
                                                                     {0.0021, 0.0064, 0.0039, 0.0109},
                                                                     {0.0033, 0.0071, 0.0052, 0.0101},
                                                                     {0.0126, 0.0170, 0.0245, 0.0339},
                                                                     {0.0029, 0.0057, 0.0084, 0.0163},
                                                                     {0.0097, 0.0139, 0.0217, 0.0352}}}}};

Error stopped() { return cancelled_error("stopped before the end"); }

// Errors of one way to calibrate, a trial an entry; a trial without an answer has none.
struct Errors {
  std::vector<double> rotation;
  std::vector<double> translation;

  void add(const SE3& found, const SE3& truth) {
    rotation.push_back(rotation_distance(found.R, truth.R));
    translation.push_back((found.t - truth.t).norm());
  }
};

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

double spread_of(const std::vector<double>& values) {
  if (values.size() < 2) return 0.0;
  const double mean = mean_of(values);
  double sum = 0.0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

ErrorFigures figures_of(const Errors& errors) {
  return {mean_of(errors.rotation), spread_of(errors.rotation), mean_of(errors.translation),
          spread_of(errors.translation)};
}

FittedPlane told_plane(const sim::CornerCloud& cloud, int plane) {
  PointCluster points;
  for (std::size_t k = 0; k < cloud.points.size(); ++k) {
    if (cloud.plane[k] == plane) points.add(cloud.points[k]);
  }
  return fit_plane(points).value_or(FittedPlane{});
}

// Plane fits to the points that are told to lie on each, then the same cost as the others'.
SE3 informed(const sim::CornerClouds& clouds, const SE3& truth) {
  std::vector<PlanePair> pairs;
  for (int plane = 0; plane < 3; ++plane) {
    const FittedPlane a = told_plane(clouds.a, plane);
    const FittedPlane b = told_plane(clouds.b, plane);
    pairs.push_back({a, a.normal.dot(truth.R * b.normal) < 0.0 ? b.flipped() : b});
  }
  return align_planes(pairs, truth).T_a_b;
}

// What a right place is, and asked for where it is looked at whether one is found at all.
constexpr Requirement right{0.05, to_rad(0.5)};

// Both LiDARs know which way is up, as the paper's are mounted level.
std::optional<SE3> found_by_planes(const sim::CornerClouds& clouds, const SE3& truth) {
  RigViews views;
  views.names = {"a", "b"};
  PlaneView a = plane_view(plane_cloud(clouds.a.points));
  PlaneView b = plane_view(plane_cloud(clouds.b.points));
  a.up = Vector3d::UnitZ();
  b.up = Vector3d(truth.R.transpose() * Vector3d::UnitZ());
  views.stops = {{std::move(a), std::move(b)}};
  const RigPlacement placed = place_rig(views, {SE3{}, std::nullopt});
  if (!placed.lidars[1].known) return std::nullopt;
  return placed.state.T_base_sensor[1];
}

std::optional<SE3> found_as_published(const sim::CornerClouds& clouds) {
  const auto found = calibrate_as_published(clouds.a.points, clouds.b.points);
  if (!found) return std::nullopt;
  return found->T_a_b;
}

struct Trial {
  std::optional<SE3> published;
  std::optional<SE3> found;
  SE3 informed;
};

void run_row(int trials, std::uint64_t seed, const RunContext& context, CornerRow& row) {
  const SE3 truth = sim::paper_configuration(row.configuration);
  std::vector<Trial> done(static_cast<std::size_t>(trials));
  parallel_for(done.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end && !context.cancelled(); ++k) {
      const auto clouds = sim::make_corner_clouds({.angle_deg = static_cast<double>(row.angle_deg),
                                                   .T_a_b = truth,
                                                   .shared_noise = row.shared_noise,
                                                   .seed = seed + k});
      done[k] = {found_as_published(clouds), found_by_planes(clouds, truth), informed(clouds, truth)};
    }
  });
  Errors published;
  Errors found;
  Errors told;
  for (const Trial& trial : done) {
    if (trial.published) published.add(*trial.published, truth);
    row.published_failed += trial.published ? 0 : 1;
    if (trial.found) found.add(*trial.found, truth);
    row.failed += trial.found ? 0 : 1;
    told.add(trial.informed, truth);
  }
  row.published = figures_of(published);
  row.found = figures_of(found);
  row.informed = figures_of(told);
}

PatchCells patch_of(const std::vector<Vector3d>& points, int lidar) {
  CellOptions options;
  options.keep_thinned = true;
  return patch_of_points(points, lidar, 0, options);
}

struct Mounted {
  bool is_right = false;
  Status status = Status::failed;
  double seconds = 0.0;
};

Mounted calibrate(const sim::CornerClouds& clouds, const SE3& truth, const std::optional<SE3>& guess) {
  Rig rig;
  rig.sensors.resize(2);
  rig.sensors[0].name = "a";
  rig.sensors[1].name = "b";
  for (Sensor& sensor : rig.sensors) sensor.lidar.emplace();
  LidarRecording recording;
  recording.lidar_sensors = {0, 1};
  recording.stops = {{0, 0, 0}};
  recording.patches = {patch_of(clouds.a.points, 0), patch_of(clouds.b.points, 1)};
  SilentReporter silent;
  CornerCalibrationOptions options;
  options.require = right;
  const auto start = SteadyClock::now();
  const auto result = calibrate_by_planes(rig, recording, {SE3{}, guess}, options, RunContext{silent});
  Mounted out;
  out.seconds = seconds_since(start);
  if (!result || !result->sensors[1].T_base_sensor) return out;
  const SE3& found = *result->sensors[1].T_base_sensor;
  out.is_right =
      rotation_distance(found.R, truth.R) < right.rotation_rad && (found.t - truth.t).norm() < right.translation_m;
  out.status = result->sensors[1].status;
  return out;
}

Mounted try_mounting(std::uint64_t seed) {
  Random random(seed, 7);
  const double off_deg = random.uniform(6.0, 30.0);
  sim::CornerCloudOptions options;
  options.angle_deg = random.uniform() < 0.5 ? 90.0 - off_deg : 90.0 + off_deg;
  options.sigma_m = 0.02;
  options.seed = seed;
  const Vector3d axis = sim::random_direction(random);
  options.T_a_b.R = exp_so3(random.uniform(0.0, pi) * axis);
  options.T_a_b.t = 0.5 * sim::random_normal3(random);
  return calibrate(sim::make_corner_clouds(options), options.T_a_b, std::nullopt);
}

Vector3d random_between(const Vector3d& low, const Vector3d& high, Random& random) {
  Vector3d out;
  for (int k = 0; k < 3; ++k) out[k] = random.uniform(low[k], high[k]);
  return out;
}

Mounted try_right_angle(bool with_guess, std::uint64_t seed) {
  constexpr double guess_off_rad = to_rad(45.0);
  Random random(seed, 9);
  sim::CornerScanOptions options;
  options.walls_m = random_between({3.0, 2.0, 1.2}, {5.0, 4.0, 2.7}, random);
  options.T_a_b.R = exp_so3(random_between({-0.5, -0.3, -0.2}, {0.5, 0.3, 0.9}, random));
  options.T_a_b.t = random_between({-0.3, -0.6, -0.3}, {0.3, 0.6, 0.3}, random);
  options.field_b.half_width_rad = to_rad(45.0);
  options.seed = seed;
  std::optional<SE3> guess;
  if (with_guess) guess = options.T_a_b * SE3{exp_so3(guess_off_rad * sim::random_direction(random)), Vector3d::Zero()};
  return calibrate(sim::make_corner_scans(options), options.T_a_b, guess);
}

template <class Trial>
Expected<MountingFigures> try_all(int trials, const std::string& what, std::uint64_t seed, const RunContext& context,
                                  const Trial& trial) {
  std::vector<Mounted> done(static_cast<std::size_t>(trials));
  const auto all = independent_trials(trials, what, context, [&](int k) -> Expected<void> {
    done[static_cast<std::size_t>(k)] = trial(seed + static_cast<std::uint64_t>(k));
    return {};
  });
  if (!all) return all.error();
  MountingFigures out;
  out.trials = trials;
  std::vector<double> seconds;
  for (const Mounted& m : done) {
    const bool is_good = m.status == Status::good;
    out.right += m.is_right ? 1 : 0;
    out.good += is_good ? 1 : 0;
    out.weak += m.status == Status::weak ? 1 : 0;
    out.wrong_good += is_good && !m.is_right ? 1 : 0;
    out.right_flagged += m.is_right && !is_good ? 1 : 0;
    seconds.push_back(m.seconds);
  }
  if (!seconds.empty()) out.worst_s = *std::max_element(seconds.begin(), seconds.end());
  out.median_s = median(std::move(seconds));
  return out;
}

}  // namespace

Expected<std::vector<CornerRow>> repeat_table(int trials, std::uint64_t seed, const RunContext& context) {
  std::vector<CornerRow> rows;
  for (const bool shared : {true, false}) {
    for (int configuration = 1; configuration <= 2; ++configuration) {
      for (int k = 0; k < angles; ++k) {
        CornerRow& row = rows.emplace_back();
        row.configuration = configuration;
        row.angle_deg = 60 + 10 * k;
        row.shared_noise = shared;
        row.paper = printed[static_cast<std::size_t>(configuration - 1)][static_cast<std::size_t>(k)];
      }
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    context.reporter.progress("corners", static_cast<double>(i) / static_cast<double>(rows.size()));
    run_row(trials, seed, context, rows[i]);
    if (context.cancelled()) return stopped();
  }
  context.reporter.progress("corners", 1.0);
  return rows;
}

Expected<MountingFigures> try_mountings(int trials, std::uint64_t seed, const RunContext& context) {
  return try_all(trials, "mountings", seed, context, try_mounting);
}

Expected<MountingFigures> try_right_angles(int trials, bool with_guess, std::uint64_t seed, const RunContext& context) {
  return try_all(trials, "right angles", seed, context,
                 [&](std::uint64_t each) { return try_right_angle(with_guess, each); });
}

}  // namespace rigcal
