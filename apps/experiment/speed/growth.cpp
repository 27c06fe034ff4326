#include "apps/experiment/speed/growth.h"

#include <algorithm>

#include "apps/experiment/speed/stopwatch.h"
#include "apps/experiment/speed/used_memory.h"
#include "core/voxel/patch_of_points.h"
#include "core/voxel/plane_map.h"

namespace rigcal::speed {
namespace {

constexpr double points_of_patch = 50e3;
constexpr double points_of_voxels = 4e6;
constexpr double cell_share = 0.8;  // of the least leaf, as calibrate has it
constexpr double largest_cell_m = 0.2;
constexpr int repetitions = 3;

class Growth {
 public:
  Growth(const GrowthOptions& options, const RunContext& context) : options_(options), context_(context) {}

  Expected<void> add(const std::string& by, double size, SetOptions set_options) {
    if (context_.cancelled()) return cancelled_error();
    context_.reporter.progress("growth", static_cast<double>(rows_.size()) / rows_in_all());
    set_options.points *= options_.scale;
    set_options.seed = options_.seed;
    const Expected<SpeedSet> set = make_set(set_options);
    if (!set) return set.error();
    const Expected<StageTable> table = time_stages(*set, context_);
    if (!table) return table.error();
    rows_.push_back({by, by == "points" ? static_cast<double>(table->points) : size, table->cpu_s("points to cells"),
                     table->cpu_s("cells to planes") + table->cpu_s("planes merged"),
                     table->cpu_s("one iteration, map anew"), table->calibration_cpu_s, table->memory_mb});
    return {};
  }

  Expected<void> add_voxels() {
    SetOptions set_options;
    set_options.points = points_of_voxels * options_.scale;
    set_options.seed = options_.seed;
    const Expected<SpeedSet> set = make_set(set_options);
    if (!set) return set.error();
    const std::vector<NoiseModel> noise(set->truth.T_base_sensor.size());
    for (const double leaf_m : options_.leaves_m) {
      if (context_.cancelled()) return cancelled_error();
      CellOptions cell_options;
      cell_options.size_m = std::min(largest_cell_m, cell_share * leaf_m);
      PlaneMapOptions map_options;
      map_options.min_size_m = leaf_m;
      const MemoryWatch memory;
      std::vector<PatchCells> cells;
      const double cells_s =
          middle_of(repetitions, [&] { cells = cells_of_patches(set->patches, cell_options); }).cpu_s;
      PlaneMap map;
      const double map_s =
          middle_of(repetitions, [&] { map = build_plane_map(cells, set->truth, noise, SE3{}, map_options); }).cpu_s;
      const std::size_t leaves = map.features.size() + map.counts.leaves_dropped;
      rows_.push_back({"voxels", static_cast<double>(leaves), cells_s, map_s, 0.0, 0.0, memory.peak_mb()});
    }
    return {};
  }

  [[nodiscard]] std::vector<GrowthRow> take() { return std::move(rows_); }

 private:
  [[nodiscard]] double rows_in_all() const {
    return static_cast<double>(options_.points.size() + options_.stops.size() + options_.lidars.size() +
                               options_.leaves_m.size());
  }

  const GrowthOptions& options_;
  const RunContext& context_;
  std::vector<GrowthRow> rows_;
};

}  // namespace

Expected<std::vector<GrowthRow>> measure_growth(const GrowthOptions& options, const RunContext& context) {
  Growth growth(options, context);
  for (const double points : options.points) {
    SetOptions set;
    set.points = points;
    if (const auto done = growth.add("points", points, set); !done) return done.error();
  }
  for (const int stops : options.stops) {
    SetOptions set;
    set.stops = stops;
    set.points = points_of_patch * set.lidars * stops;
    if (const auto done = growth.add("stops", stops, set); !done) return done.error();
  }
  for (const int lidars : options.lidars) {
    SetOptions set;
    set.lidars = lidars;
    set.points = points_of_patch * lidars * set.stops;
    if (const auto done = growth.add("LiDARs", lidars, set); !done) return done.error();
  }
  if (const auto done = growth.add_voxels(); !done) return done.error();
  return growth.take();
}

}  // namespace rigcal::speed
