#include "apps/experiment/speed/experiment.h"

#include <algorithm>
#include <array>

#include "apps/experiment/parts.h"
#include "apps/experiment/speed/stopwatch.h"
#include "core/base/parallel.h"
#include "core/planes/adjust.h"
#include "core/planes/refine.h"

namespace rigcal::speed {
namespace {

constexpr std::size_t bandwidth_bytes = std::size_t{1} << 29;
constexpr std::array<double, 2> table_points{4e6, 4e7};
constexpr int scans = 177;
constexpr double scans_points = 1.3e7;
constexpr int scans_iterations = 5;

// The poses alone: with one LiDAR there is no extrinsic.
Expected<ManyScans> time_scans(const ExperimentOptions& options, const RunContext& context) {
  SetOptions set_options;
  set_options.lidars = 1;
  set_options.stops = options.scale < 1.0 ? std::max(8, static_cast<int>(scans * options.scale)) : scans;
  set_options.points = scans_points * options.scale;
  set_options.seed = options.seed;
  const Expected<SpeedSet> set = make_set(set_options);
  if (!set) return set.error();
  if (context.cancelled()) return cancelled_error();
  const RefinePass pass = standard_passes(1).back();
  PlaneMapOptions map_options = pass.map;
  map_options.with_rays = false;
  // Leaves that are as large as that program's.
  map_options.min_size_m = 0.5;
  ManyScans out;
  PlaneMap map;
  std::vector<PatchCells> cells;
  const std::vector<NoiseModel> noise(1);
  const Took map_took = middle_of(3, [&] {
    cells = set->cells(false);
    map = build_plane_map(cells, set->truth, noise, SE3{}, map_options);
  });
  ParameterLayout layout(set_options.stops, 1);
  for (int j = 1; j < set_options.stops; ++j) layout.free_stop(j);
  AdjustOptions adjustment;
  adjustment.form = pass.form;
  adjustment.max_iterations = scans_iterations;
  adjustment.rotation_tolerance_rad = 0.0;
  adjustment.translation_tolerance_m = 0.0;
  int iterations = 1;
  const Took all = middle_of(3, [&] {
    RigState state = set->truth;
    iterations = std::max(1, adjust(map.features, layout, adjustment, state).iterations);
  });
  out.map_s = map_took.wall_s;
  out.map_cpu_s = map_took.cpu_s;
  out.iteration_s = all.wall_s / iterations;
  out.iteration_cpu_s = all.cpu_s / iterations;
  out.table.points = set->points;
  out.table.lidars = 1;
  out.table.stops = set_options.stops;
  for (const PatchCells& patch : cells) out.table.cells += patch.cells.size() + patch.pieces.size();
  out.table.planes = map.features.size();
  for (const PlaneFeature& feature : map.features) out.table.observations += feature.observations.size();
  return out;
}

}  // namespace

std::vector<std::string> part_names() { return {"programs", "stages", "scans", "growth"}; }

Expected<Experiment> run_parts(const ExperimentOptions& options, const RunContext& context) {
  Experiment out;
  out.threads = thread_count();
  // First, while this process is small.
  if (is_wanted("programs", options.parts)) {
    ProgramOptions programs = options.programs;
    programs.scale = options.scale;
    programs.seed = options.seed;
    Expected<std::vector<ProgramRun>> done = time_programs(programs, context);
    if (!done) return done.error();
    out.programs = std::move(*done);
  }
  context.reporter.progress("bandwidth", -1.0);
  out.bandwidth = measure_bandwidth(static_cast<std::size_t>(std::min(1.0, 10.0 * options.scale) * bandwidth_bytes));
  if (is_wanted("stages", options.parts)) {
    for (const double points : table_points) {
      if (context.cancelled()) return cancelled_error();
      context.reporter.progress("stages", static_cast<double>(out.tables.size()) / table_points.size());
      SetOptions set_options;
      set_options.points = points * options.scale;
      set_options.seed = options.seed;
      const Expected<SpeedSet> set = make_set(set_options);
      if (!set) return set.error();
      Expected<StageTable> table = time_stages(*set, context);
      if (!table) return table.error();
      out.tables.push_back(std::move(*table));
    }
  }
  if (is_wanted("scans", options.parts)) {
    context.reporter.progress("scans", -1.0);
    Expected<ManyScans> done = time_scans(options, context);
    if (!done) return done.error();
    out.scans = std::move(*done);
  }
  if (is_wanted("growth", options.parts)) {
    GrowthOptions growth = options.growth;
    growth.scale = options.scale;
    growth.seed = options.seed;
    Expected<std::vector<GrowthRow>> done = measure_growth(growth, context);
    if (!done) return done.error();
    out.growth = std::move(*done);
  }
  return out;
}

std::vector<Goal> goals_of(const Experiment& experiment) {
  std::vector<Goal> goals;
  for (const ProgramRun& run : experiment.programs) {
    const double millions = 1e-6 * static_cast<double>(run.points);
    if (run.name == "patches") {
      goals.push_back(
          {"patch folder of " + std::to_string(static_cast<int>(millions + 0.5)) + " M points to extrinsics",
           run.until_lidars_s(), 0.9, 18.5, "s"});
    } else if (run.name == "dump") {
      goals.push_back({"dump of 4e7 shots to extrinsics", run.until_lidars_s(), 5.0, 25.0, "s"});
      goals.push_back({"most memory for the dump", run.peak_mb, 2147.0, 1450.0, "MB"});
    } else {
      goals.push_back({"two cameras of 20 images", run.cameras_s(), 2.0, 24.6, "s"});
    }
  }
  if (!experiment.tables.empty()) {
    goals.push_back({"one joint iteration, map anew, " +
                         std::to_string((experiment.tables.back().points + 500'000) / 1'000'000) + " M points",
                     experiment.tables.back().seconds("one iteration, map anew"), 0.1, 3.09, "s"});
  }
  if (experiment.scans) {
    goals.push_back({"177 scans: points to planes", experiment.scans->map_s, 0.5, 2.2, "s"});
    goals.push_back({"177 scans: one iteration", experiment.scans->iteration_s, 0.06, 0.3, "s"});
  }
  return goals;
}

}  // namespace rigcal::speed
