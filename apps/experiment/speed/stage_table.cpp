#include "apps/experiment/speed/stage_table.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "apps/experiment/speed/stopwatch.h"
#include "apps/experiment/speed/used_memory.h"
#include "apps/ingest/lidar_ingest.h"
#include "core/planes/merge_planes.h"
#include "core/planes/positive_solver.h"
#include "core/planes/refine.h"
#include "drivers/livox_codec/sample_packet.h"

namespace rigcal::speed {
namespace {

constexpr int repetitions = 3;

// One LiDAR's points as the datagrams of an AVIA, and what it takes to read them again.
class Packets {
 public:
  Packets() {
    Sensor& sensor = rig_.sensors.emplace_back();
    sensor.name = "avia";
    sensor.lidar.emplace();
    sensor.lidar->model = LidarModel::livox_avia;
    sensor.lidar->ip = {192, 168, 1, 179};
  }

  // Seconds and bytes for all points of the patches; a patch's packets are held at a time.
  StageSpeed read_all(const std::vector<Patch>& patches) {
    StageSpeed out{"packets to points", 0.0, 0.0, 0.0};
    std::uint64_t kept = 0;
    LidarIngest ingest(rig_, [&kept](PointBatch& batch) { kept += batch.points.size(); }, {});
    for (const Patch& patch : patches) {
      const std::vector<std::vector<std::uint8_t>> datagrams = encode(patch.points);
      for (const auto& bytes : datagrams) out.bytes += static_cast<double>(bytes.size());
      out.bytes += static_cast<double>(patch.points.size() * sizeof(Point));
      const Took one = took([&] {
        for (const auto& bytes : datagrams) {
          stamp_ns_ += interval_ns;
          ingest.add({stamp_ns_, {{192, 168, 1, 179}, 60001}, {{192, 168, 1, 5}, 56001}, bytes});
        }
      });
      out.seconds += one.wall_s;
      out.cpu_s += one.cpu_s;
    }
    return out;
  }

 private:
  static constexpr std::int64_t interval_ns = 400'000;
  static constexpr std::int64_t later_ns = 1'000'000'000;  // the host's clock after the device's

  std::vector<std::vector<std::uint8_t>> encode(const std::vector<Point>& points) {
    livox::SampleHeader header;
    header.data_type = livox::DataType::cartesian_tagged;
    const std::size_t slots = livox::record_layout(header.data_type).slots;
    std::vector<std::vector<std::uint8_t>> out;
    std::vector<Point> some;
    std::int64_t device_ns = stamp_ns_ - later_ns;
    for (std::size_t begin = 0; begin < points.size(); begin += slots) {
      const std::size_t end = std::min(points.size(), begin + slots);
      some.assign(points.begin() + static_cast<std::ptrdiff_t>(begin),
                  points.begin() + static_cast<std::ptrdiff_t>(end));
      for (std::size_t k = 0; k < some.size(); ++k) some[k].shot = static_cast<std::uint16_t>(k);
      header.device_stamp_ns = device_ns += interval_ns;
      livox::encode_points(header, some, out.emplace_back());
    }
    return out;
  }

  Rig rig_;
  std::int64_t stamp_ns_ = 2 * later_ns;
};

ParameterLayout all_free(const SpeedSet& set) {
  ParameterLayout layout(static_cast<int>(set.truth.T_G_base.size()), static_cast<int>(set.truth.T_base_sensor.size()));
  for (int j = 1; j < layout.stops(); ++j) layout.free_stop(j);
  for (int i = 0; i < layout.lidars(); ++i) {
    if (i != set.rig.base) layout.free_lidar(i);
  }
  return layout;
}

// Map, factors and solution by themselves, at the truth, as a tight pass of a calibration does them.
void time_steps(const SpeedSet& set, const std::vector<PatchCells>& cells, StageTable& out) {
  RefinePass pass = standard_passes(1).back();
  pass.iterations = 1;
  const std::vector<NoiseModel> noise(set.truth.T_base_sensor.size());
  const ParameterLayout layout = all_free(set);
  const auto unknowns = static_cast<double>(layout.size());
  PlaneMap map;
  const Took map_took =
      middle_of(repetitions, [&] { map = build_plane_map(cells, set.truth, noise, SE3{}, pass.map); });
  const std::size_t leaves = map.features.size();
  MergeOptions merge;
  merge.tolerance_m = pass.merge_tolerance_m;
  std::vector<PlaneFeature> merged;
  const Took merge_took = middle_of(repetitions, [&] { merged = merge_coplanar(map.features, merge); });
  std::move(merged.begin(), merged.end(), std::back_inserter(map.features));
  NormalEquations sum;
  const Took factors_took =
      middle_of(repetitions, [&] { sum = build_normal_equations(map.features, set.truth, layout, pass.form); });
  Eigen::VectorXd step;
  const Took solve_took = middle_of(repetitions, [&] {
    Eigen::MatrixXd damped = sum.H;
    damped.diagonal() *= 1.0 + 1e-6;
    step = solve_positive(damped, sum.g).value_or(Eigen::VectorXd());
  });
  const Took iteration_took = middle_of(repetitions, [&] {
    RigState moved = set.truth;
    SilentReporter silent;
    static_cast<void>(refine({cells, noise, SE3{}, {}, {}}, layout, {pass}, {silent}, moved));
  });
  out.planes = map.features.size();
  for (const PlaneFeature& feature : map.features) out.observations += feature.observations.size();
  const double cell_bytes = static_cast<double>(out.pieces * sizeof(Cell));
  const double observation_bytes =
      static_cast<double>(out.observations) * static_cast<double>(sizeof(PlaneObservation));
  const double matrix_bytes = unknowns * unknowns * static_cast<double>(sizeof(double));
  out.stages.push_back({"cells to planes", map_took.wall_s, map_took.cpu_s, cell_bytes + observation_bytes});
  out.stages.push_back({"planes merged", merge_took.wall_s, merge_took.cpu_s,
                        static_cast<double>(leaves * sizeof(PlaneFeature)) + observation_bytes});
  out.stages.push_back({"factors", factors_took.wall_s, factors_took.cpu_s, observation_bytes + matrix_bytes});
  out.stages.push_back({"solution", solve_took.wall_s, solve_took.cpu_s, 2.0 * matrix_bytes});
  out.stages.push_back(
      {"one iteration, map anew", iteration_took.wall_s, iteration_took.cpu_s, cell_bytes + 3.0 * observation_bytes});
}

// What has to come near only goes by cubes, and planes that are fitted to the end are made of pieces.
bool goes_by_cubes(const std::string& stage) { return stage == "start" || stage == "poses" || stage == "extrinsics"; }

// The stages of a whole calibration from the cells on. Each map of a stage reads its cells once.
Expected<void> time_calibration(const SpeedSet& set, std::vector<PatchCells> cells, const RunContext& context,
                                StageTable& out) {
  LidarRecording recording = set.recording;
  recording.patches = std::move(cells);
  LidarCalibrationOptions options;
  options.with_map = false;
  std::optional<Expected<CalibrationResult>> calibrated;
  const Took whole = took([&] { calibrated = calibrate_lidars(set.rig, recording, set.guess, options, context); });
  const Expected<CalibrationResult>& result = *calibrated;
  if (!result) return result.error();
  out.calibration_cpu_s = out.cpu_s("points to cells") + whole.cpu_s;
  for (const StageReport& stage : result->stages) {
    double maps = stage.name == "start" ? 1.0 : 0.0;
    for (const auto& [name, count] : stage.counts) {
      if (name == "passes") maps = count;
    }
    const std::size_t read = goes_by_cubes(stage.name) ? out.cells - out.pieces : out.pieces;
    out.stages.push_back({stage.name, stage.wall_s, 0.0, maps * static_cast<double>(read * sizeof(Cell))});
  }
  for (std::size_t k = 0; k < result->sensors.size(); ++k) {
    const auto& T = result->sensors[k].T_base_sensor;
    out.worst_m = std::max(out.worst_m, T ? (T->t - set.truth.T_base_sensor[k].t).norm() : 1e3);
  }
  return {};
}

}  // namespace

double StageTable::seconds(const std::string& stage) const {
  const auto found = std::find_if(stages.begin(), stages.end(), [&](const StageSpeed& s) { return s.stage == stage; });
  return found == stages.end() ? 0.0 : found->seconds;
}

double StageTable::cpu_s(const std::string& stage) const {
  const auto found = std::find_if(stages.begin(), stages.end(), [&](const StageSpeed& s) { return s.stage == stage; });
  return found == stages.end() ? 0.0 : found->cpu_s;
}

double StageTable::calibration_s() const {
  // Those of the calibration itself come last, from its start on.
  double sum = seconds("points to cells");
  const auto start = std::find_if(stages.begin(), stages.end(), [](const StageSpeed& s) { return s.stage == "start"; });
  for (auto stage = start; stage != stages.end(); ++stage) sum += stage->seconds;
  return sum;
}

Expected<StageTable> time_stages(const SpeedSet& set, const RunContext& context) {
  StageTable out;
  out.points = set.points;
  out.lidars = static_cast<int>(set.truth.T_base_sensor.size());
  out.stops = static_cast<int>(set.truth.T_G_base.size());
  out.stages.push_back(Packets().read_all(set.patches));
  const MemoryWatch memory;
  std::vector<PatchCells> cells;
  const Took cells_took = middle_of(repetitions, [&] { cells = set.cells(false); });
  for (const PatchCells& patch : cells) {
    out.cells += patch.cells.size() + patch.pieces.size();
    out.pieces += patch.pieces.size();
  }
  out.stages.push_back({"points to cells", cells_took.wall_s, cells_took.cpu_s,
                        static_cast<double>(out.points * sizeof(Point) + out.cells * sizeof(Cell))});
  if (context.cancelled()) return cancelled_error();
  time_steps(set, cells, out);
  if (const auto done = time_calibration(set, std::move(cells), context, out); !done) return done.error();
  out.memory_mb = memory.peak_mb();
  return out;
}

}  // namespace rigcal::speed
