#include "simdata/session/session_writer.h"

#include <cmath>
#include <filesystem>

#include "core/base/seconds.h"
#include "core/base/version.h"
#include "core/io/patch_folder.h"
#include "core/io/pcapng_writer.h"
#include "core/io/session_folder.h"
#include "simdata/session/session_images.h"

namespace rigcal::sim {
namespace {

void add_sensors(const Rig& rig, const std::vector<SE3>& T_base_sensor, GroundTruth& truth) {
  truth.base = rig.base_sensor().name;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i)
    truth.T_base_sensor.emplace_back(rig.sensors[i].name, T_base_sensor[i]);
}

// Noise and biases of the LiDARs.
void add_errors(const Rig& rig, const std::vector<SimulatedLidar>& lidars, GroundTruth& truth) {
  for (const SimulatedLidar& lidar : lidars) {
    const std::string& name = rig.sensors[static_cast<std::size_t>(lidar.sensor)].name;
    truth.noise[name] = {{"range_m", lidar.noise.range_sigma},
                         {"range_per_m", lidar.noise.range_sigma_per_m},
                         {"range_max_m", lidar.noise.range_sigma_max},
                         {"angle_deg", to_deg(lidar.noise.angle_sigma_rad)}};
    truth.biases[name] = {{"range_m", lidar.noise.range_bias},
                          {"range_dark_m", lidar.noise.dark_bias},
                          {"wobble_deg", to_deg(lidar.wobble.amplitude_rad)}};
  }
}

std::map<std::string, double> named_biases(const ImuErrors& errors) {
  std::map<std::string, double> biases;
  const char* const axes[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    biases[std::string("gyro_") + axes[axis] + "_deg_s"] = to_deg(errors.gyro_bias_rad_s[axis]);
    biases[std::string("accelerometer_") + axes[axis] + "_g"] = errors.accelerometer_bias_g[axis];
  }
  return biases;
}

// "point_sent", "imu_lost" and so on.
void add_packets(const std::string& stream, const FaultCounts& counts, std::map<std::string, double>& named) {
  if (counts.sent == 0) return;
  const std::pair<const char*, std::uint64_t> all[] = {
      {"sent", counts.sent},
      {"received", counts.received()},
      {"lost", counts.lost},
      {"lost_at_start", counts.lost_at_start},
      {"lost_at_end", counts.lost_at_end},
      {"gaps", counts.gaps},
      {"duplicated", counts.duplicated},
      {"out_of_order", counts.out_of_order},
      {"delayed", counts.delayed},
      {"flipped", counts.flipped},
  };
  for (const auto& [name, count] : all) named[stream + "_" + name] = static_cast<double>(count);
}

// Takes a session that could not be finished away again; create_session has made sure that it is ours.
class Unfinished {
 public:
  explicit Unfinished(std::string path) : path_(std::move(path)) {}
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;
  ~Unfinished() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  void keep() { path_.clear(); }

 private:
  std::string path_;
};

std::string ground_truth_path(const std::string& session) {
  return (std::filesystem::path(session) / "ground_truth.yaml").string();
}

}  // namespace

GroundTruth ground_truth_of(const Rig& rig, const RunTruth& run) {
  GroundTruth truth;
  add_sensors(rig, run.T_base_sensor, truth);
  add_errors(rig, run.lidars, truth);
  for (std::size_t k = 0; k < run.stops.size(); ++k) truth.stops.push_back({run.stops[k], run.T_G_base[k]});
  truth.table_axis = TableAxis{run.axis_point, run.axis};
  for (std::size_t i = 0; i < run.devices.size(); ++i) {
    const SimDevice& device = run.devices[i];
    const std::string& name = rig.sensors[static_cast<std::size_t>(device.sensor)].name;
    const double before_s = seconds_of_ns(run.start_ns - run.sampling_ns);
    truth.clocks[name] = {device.clock.stamp_ns(before_s) - run.start_ns, device.clock.drift * 1e6};
    if (device.has_imu) truth.biases[name].merge(named_biases(run.imu_errors[i]));
    add_packets("point", run.point_packets[i], truth.packets[name]);
    add_packets("imu", run.imu_packets[i], truth.packets[name]);
  }
  return truth;
}

Expected<SessionSummary> simulate_session(const Scene& scene, const Rig& rig, const RunOptions& options,
                                          const std::string& path, const RunContext& context) {
  // Asked for first, so that a rig that cannot be simulated leaves nothing behind.
  if (const auto devices = make_devices(rig, options.seed, options.clock_drift_ppm); !devices) return devices.error();
  if (const auto known = check_cameras(rig); !known && options.images_per_stop > 0) return known.error();
  SessionRecord record;
  record.software = version();
  record.start_ns = options.start_ns;
  if (const auto made = create_session(path, rig, record); !made) return made.error();
  Unfinished unfinished(path);
  auto writer = PcapngWriter::create(session_packets_path(path));
  if (!writer) return writer.error();
  const auto run = simulate_run(
      scene, rig, options, [&](const Datagram& datagram) { return writer->write(datagram); }, context);
  if (!run) return run.error();
  if (const auto closed = writer->close(); !closed) return closed.error();
  GroundTruth truth = ground_truth_of(rig, *run);
  if (options.turntable.drive_m > 0.0) truth.table_axis.reset();  // It was driven, not turned.
  // The same seed gives the same rig and motion again.
  const auto simulated = make_simulated_rig(rig, scene.T_scene_table, options.turntable, options.mount_error,
                                            options.seed, options.unit_errors);
  if (!simulated) return simulated.error();
  const auto images = write_session_images(scene, rig, *simulated, options.seed, {run->start_ns, run->sampling_ns},
                                           options.images_per_stop, path, context, truth);
  if (!images) return images.error();
  if (const auto written = write_ground_truth(ground_truth_path(path), truth); !written) return written.error();
  record.end_ns = run->end_ns;
  for (std::size_t i = 0; i < run->devices.size(); ++i)
    record.counters[rig.sensors[static_cast<std::size_t>(run->devices[i].sensor)].name]["packets"] =
        run->point_packets[i].received() + run->imu_packets[i].received();
  if (const auto written = write_session_record(path, record); !written) return written.error();
  unfinished.keep();
  return SessionSummary{static_cast<int>(run->stops.size()),
                        seconds_of_ns(run->end_ns - run->sampling_ns),
                        writer->datagrams(),
                        writer->bytes(),
                        0,
                        *images};
}

Expected<SessionSummary> simulate_patches(const Scene& scene, const Rig& rig, const LightRigOptions& options,
                                          const std::string& path, const RunContext& context) {
  if (const auto known = check_cameras(rig); !known && options.with_images) return known.error();
  context.reporter.progress("simulate", 0.0);
  const auto light = make_light_rig(scene, options, rig);
  if (!light) return light.error();
  SessionRecord record;
  record.software = version();
  record.start_ns = RunOptions{}.start_ns;
  record.end_ns = record.start_ns;
  if (const auto made = create_session(path, rig, record); !made) return made.error();
  Unfinished unfinished(path);
  auto folder = PatchFolderWriter::create((std::filesystem::path(path) / "patches").string(), rig);
  if (!folder) return folder.error();
  SessionSummary summary;
  summary.stops = static_cast<int>(light->T_G_base.size());
  for (std::size_t i = 0; i < light->patches.size(); ++i) {
    if (context.cancelled()) return cancelled_error();
    if (const auto written = folder->write(light->patches[i]); !written) return written.error();
    summary.points += light->patches[i].points.size();
    context.reporter.progress("write patches", static_cast<double>(i + 1) / static_cast<double>(light->patches.size()));
  }
  if (options.with_images) {
    const auto simulated = make_simulated_rig(rig, scene.T_scene_table, options.turntable, options.mount_error,
                                              options.seed, options.unit_errors);
    if (!simulated) return simulated.error();
    const auto images = write_patch_images(scene, rig, *simulated, options.seed, *folder, context);
    if (!images) return images.error();
    summary.images = *images;
  }
  if (const auto finished = folder->finish(); !finished) return finished.error();
  GroundTruth truth;
  add_sensors(rig, light->T_base_sensor, truth);
  add_errors(rig, light->lidars, truth);
  if (options.turntable.drive_m == 0.0) truth.table_axis = TableAxis{light->axis_point, light->axis};
  for (std::size_t k = 0; k < light->T_G_base.size(); ++k)
    truth.stops.push_back({{static_cast<int>(k), 0, 0}, light->T_G_base[k]});
  if (const auto written = write_ground_truth(ground_truth_path(path), truth); !written) return written.error();
  unfinished.keep();
  return summary;
}

}  // namespace rigcal::sim
