#include "apps/recording/recording.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "apps/ingest/point_filter.h"
#include "apps/recording/bag_batches.h"
#include "apps/recording/bag_images.h"
#include "apps/recording/cloud_flaws.h"
#include "apps/recording/far_points.h"
#include "apps/recording/rig_lidars.h"
#include "apps/recording/still_images.h"
#include "apps/recording/stop_reader.h"
#include "apps/recording/stream_recording.h"
#include "core/base/parallel.h"
#include "core/base/spare_pool.h"
#include "core/io/pcd_file.h"
#include "core/io/session_folder.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

struct PatchJob {
  int lidar = 0;
  int sensor = 0;
  int stop = 0;
  std::string path;
  bool is_livox = false;   ///< Its tags tell noise.
  bool has_range = false;  ///< In the rig file.
  double min_range_m = 0.0;
  double max_range_m = 0.0;
};

struct PatchOutcome {
  PatchCells cells;
  std::vector<Point> near;
  PcdSummary summary;
  std::uint64_t out_of_range = 0;
  std::optional<Error> error;
};

PatchOutcome read_patch(const PatchJob& job, const CellOptions& options, double keep_within_m, CellBuilder& builder) {
  PatchOutcome out;
  CellOptions cells = options;
  cells.max_range_m = std::min(cells.max_range_m, job.max_range_m);
  builder.begin(job.lidar, job.stop, cells);
  std::vector<Point> kept;
  // Of packets and bags such points are left out, too.
  const PointFilter of_tags(true, std::array<double, 2>{0.0, std::numeric_limits<double>::infinity()});
  const auto near2 = static_cast<float>(job.min_range_m * job.min_range_m);
  const auto far2 = static_cast<float>(job.max_range_m * job.max_range_m);
  std::uint64_t beyond_range = 0;
  const auto take = [&](std::span<const Point> points) {
    builder.add(points);
    add_near_points(points, std::min(keep_within_m, cells.max_range_m), out.near);
  };
  const Expected<PcdSummary> summary = read_pcd(job.path, [&](std::span<const Point> points) {
    if (!job.has_range && !job.is_livox) {
      take(points);
      return;
    }
    kept.assign(points.begin(), points.end());
    if (job.is_livox) of_tags.apply(kept);
    if (!job.has_range) {
      take(kept);
      return;
    }
    std::erase_if(kept, [&](const Point& p) {
      const float square = p.x * p.x + p.y * p.y + p.z * p.z;
      if (square < near2 || square > far2) ++out.out_of_range;
      if (square >= far2) ++beyond_range;
      return square < near2;  // the cells know how far they go
    });
    take(kept);
  });
  if (!summary) {
    out.error = summary.error();
    return out;
  }
  out.summary = *summary;
  out.cells = builder.finish();
  out.cells.too_far -= std::min(out.cells.too_far, beyond_range);  // they are told of as out of range
  return out;
}

// What is wrong with all clouds of a LiDAR together.
struct LidarTally {
  CloudFlaws flaws;
  std::uint64_t points = 0;
  std::uint64_t out_of_range = 0;
  std::size_t clouds = 0;
  std::size_t unusable = 0;  ///< Clouds without a usable point,
  std::size_t empty = 0;     ///< and those of them that have none at all: it looked at the sky, say.
  std::string first_unusable;

  void add(const PatchOutcome& outcome, const std::string& path) {
    flaws.add(outcome.summary);
    points += outcome.summary.points;
    out_of_range += outcome.out_of_range;
    ++clouds;
    if (outcome.cells.points > 0) return;
    if (++unusable == 1) first_unusable = path;
    if (outcome.summary.points == 0) ++empty;
  }

  // All that it ever saw was left out.
  [[nodiscard]] bool is_of_another_unit() const { return unusable == clouds && points > 0; }
};

void warn_of_lidars(const Rig& rig, const std::vector<PatchOutcome>& outcomes, const std::vector<PatchJob>& jobs,
                    Reporter& reporter) {
  std::map<int, LidarTally> tallies;  // by sensor
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    tallies[jobs[k].sensor].add(outcomes[k], jobs[k].path);
  }
  for (const auto& [sensor, tally] : tallies) {
    const std::string& name = rig.sensors[static_cast<std::size_t>(sensor)].name;
    if (2 * tally.out_of_range > tally.points) {
      reporter.warn(name + ": " + std::to_string(tally.out_of_range) + " of its " + std::to_string(tally.points) +
                    " points lie outside of its range in the rig file and are left out; is range in metres?");
    }
    for (const std::string& warning : tally.flaws.warnings(name)) reporter.warn(warning);
    if (tally.unusable > 0) {
      reporter.warn(name + ": " + std::to_string(tally.unusable) + " of its " + std::to_string(tally.clouds) +
                    " clouds have no usable point, the first: " + tally.first_unusable +
                    (tally.empty > 0 ? "; " + std::to_string(tally.empty) + " have none at all" : std::string()) +
                    (tally.is_of_another_unit() ? "; are they in metres?" : ""));
    }
  }
}

void warn_of(const PatchFolder& folder, const std::vector<PatchOutcome>& outcomes, Reporter& reporter) {
  for (const std::string& reason : reasons_of_unknown(folder)) reporter.warn(folder.path + ": " + reason);
  if (std::any_of(outcomes.begin(), outcomes.end(), [](const PatchOutcome& o) { return o.summary.size_missing; }))
    reporter.warn(folder.path + ": PCD headers say WIDTH or HEIGHT 0; POINTS was believed");
}

// A trajectory without any translation, as `export` writes it, holds the gyro's rotations between the stops and says
// nothing of where the base was. That of several stops may have one pose: of the first, where no turn is known.
bool has_rotations_only(const std::map<int, SE3>& trajectory, std::size_t stops) {
  return std::max(trajectory.size(), stops) > 1 &&
         std::all_of(trajectory.begin(), trajectory.end(), [](const auto& p) { return p.second.t.isZero(0.0); });
}

// Stops with a patch, and those with nothing but images whose poses are given: cameras can be found from these, too.
std::set<int> stops_of(const PatchFolder& folder, const Rig& rig, const std::vector<std::string>& image_places) {
  std::set<int> stops(folder.stops.begin(), folder.stops.end());
  if (!folder.trajectory || has_rotations_only(*folder.trajectory, stops.size())) return stops;
  for (const int stop : stops_with_images(rig, image_places)) {
    if (folder.trajectory->contains(stop)) stops.insert(stop);
  }
  return stops;
}

Expected<void> take_trajectory(const std::map<int, SE3>& trajectory, const std::map<int, int>& position,
                               const std::string& path, LidarRecording& out) {
  std::vector<std::optional<SE3>> poses(out.stops.size());
  for (const auto& [stop, T] : trajectory) {
    const auto at = position.find(stop);
    if (at != position.end()) poses[static_cast<std::size_t>(at->second)] = T;
  }
  if (has_rotations_only(trajectory, poses.size())) {
    out.R_previous_this.resize(poses.size());
    for (std::size_t j = 1; j < poses.size(); ++j) {
      if (poses[j - 1] && poses[j]) out.R_previous_this[j] = poses[j - 1]->R.transpose() * poses[j]->R;
    }
    return {};
  }
  out.trajectory.resize(poses.size());
  for (std::size_t j = 0; j < poses.size(); ++j) {
    if (!poses[j]) {
      return input_error("the trajectory has no pose for stop " + std::to_string(out.stops[j].index), path,
                         "give a pose for every stop that has a patch, or leave the trajectory out");
    }
    out.trajectory[j] = poses[j];
  }
  out.trajectory_is_prior = true;
  return {};
}

Expected<Recording> read_patches(Rig rig, const std::string& path, const std::string& trajectory_path,
                                 const std::vector<std::string>& image_places, const CellOptions& options,
                                 double keep_within_m, const RunContext& context) {
  const Expected<PatchFolder> folder = list_patch_folder(path, rig, trajectory_path);
  if (!folder) return folder.error();
  Recording out;
  out.lidar.lidar_sensors = lidar_sensors(rig);
  std::map<int, int> position;
  for (const int stop : stops_of(*folder, rig, image_places)) {
    position[stop] = static_cast<int>(out.lidar.stops.size());
    out.lidar.stops.push_back({stop, 0, 0});
  }
  std::vector<PatchJob> jobs;
  for (std::size_t i = 0; i < out.lidar.lidar_sensors.size(); ++i) {
    const auto sensor = static_cast<std::size_t>(out.lidar.lidar_sensors[i]);
    const auto& range = rig.sensors[sensor].lidar->range_m;
    for (const PatchFile& file : folder->patches[sensor]) {
      jobs.push_back({static_cast<int>(i), out.lidar.lidar_sensors[i], position.at(file.stop), file.path,
                      rig.sensors[sensor].is_livox(), range.has_value(), range ? (*range)[0] : 0.0,
                      range ? (*range)[1] : 1e9});
    }
  }
  // Stop by stop, as packets give them: the same patches in the same order give the same result.
  std::stable_sort(jobs.begin(), jobs.end(), [](const PatchJob& a, const PatchJob& b) { return a.stop < b.stop; });
  std::vector<PatchOutcome> outcomes(jobs.size());
  SparePool<CellBuilder> builders;
  parallel_for(jobs.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::unique_ptr<CellBuilder> builder = builders.take();
    for (std::size_t k = begin; k < end && !context.cancelled(); ++k)
      outcomes[k] = read_patch(jobs[k], options, keep_within_m, *builder);
    builders.give_back(std::move(builder));
  });
  if (context.cancelled()) return cancelled_error();
  for (const PatchOutcome& o : outcomes) {
    if (o.error) return *o.error;
  }
  warn_of(*folder, outcomes, context.reporter);
  warn_of_lidars(rig, outcomes, jobs, context.reporter);
  out.lidar.too_far.assign(out.lidar.stops.size(), std::vector<std::uint64_t>(out.lidar.lidar_sensors.size()));
  for (PatchOutcome& o : outcomes) {
    out.points += o.cells.points;
    out.lidar.too_far[static_cast<std::size_t>(o.cells.stop)][static_cast<std::size_t>(o.cells.lidar)] +=
        o.cells.too_far;
    const int sensor = out.lidar.lidar_sensors[static_cast<std::size_t>(o.cells.lidar)];
    if (!o.near.empty()) out.near_points.push_back({sensor, o.cells.stop, std::move(o.near)});
    out.lidar.patches.push_back(std::move(o.cells));
  }
  for (const std::string& warning : far_point_warnings(rig, out.lidar)) context.reporter.warn(warning);
  if (out.points == 0)
    return input_error("no usable point in any patch", path, "check that the files hold x, y, z in metres");
  if (folder->trajectory) {
    const std::string file = trajectory_path.empty() ? (fs::path(path) / "trajectory.tum").string() : trajectory_path;
    const Expected<void> taken = take_trajectory(*folder->trajectory, position, file, out.lidar);
    if (!taken) return taken.error();
  }
  out.rig = std::move(rig);
  return out;
}

// A rig without LiDARs: stops are those of the images.
Expected<Recording> read_images_alone(Rig rig, const std::string& path, const std::vector<std::string>& places) {
  Recording out;
  for (const int stop : stops_with_images(rig, places)) out.lidar.stops.push_back({stop, 0, 0});
  if (out.lidar.stops.empty()) {
    return input_error("holds no images of the rig's cameras", path,
                       "put them into image/<camera>/<stop>.png, or name their folder by --images DIR");
  }
  out.rig = std::move(rig);
  return out;
}

Expected<Rig> rig_of(const RecordingPaths& paths, const std::string& file) {
  return paths.known_rig ? Expected<Rig>(paths.known_rig->rig) : load_rig(file);
}

Expected<Recording> read_points(const RecordingPaths& paths, const CellOptions& cells, const RunContext& context) {
  const std::string& path = paths.input;
  if (const auto there = check_there(path); !there) return there.error();
  std::error_code ec;
  const bool folder = fs::is_directory(path, ec);
  if (folder && is_session_folder(path)) {
    Expected<SessionFolder> session = open_session(path);
    if (!session) return session.error();
    if (session->packets.empty()) {
      if (session->record && !session->record->end_ns)
        context.reporter.warn(path + " has no end: the recording that it was made from was cut short");
      Expected<Rig> rig = paths.rig.empty() ? Expected<Rig>(std::move(session->rig)) : rig_of(paths, paths.rig);
      if (!rig) return rig.error();
      if (lidar_sensors(*rig).empty()) return read_images_alone(std::move(*rig), path, image_places(paths));
      return read_patches(std::move(*rig), session->patches, session->trajectory, image_places(paths), cells,
                          paths.keep_points_within_m, context);
    }
  } else if (folder) {
    const Expected<std::string> rig_file = rig_file_of_folder(path, paths.rig);
    if (!rig_file) return rig_file.error();
    Expected<Rig> rig = rig_of(paths, *rig_file);
    if (!rig) return rig.error();
    if (lidar_sensors(*rig).empty()) return read_images_alone(std::move(*rig), path, image_places(paths));
    return read_patches(std::move(*rig), path, {}, image_places(paths), cells, paths.keep_points_within_m, context);
  }
  const Expected<StreamSource> source = open_stream(path, paths.rig, paths.known_rig);
  if (!source) return source.error();
  if (const std::optional<Error> none = no_lidar_error(*source)) return *none;
  return read_stream(*source, cells, paths.keep_points_within_m, context);
}

}  // namespace

Expected<void> check_images(const RecordingPaths& paths) {
  std::error_code error;
  if (paths.images.empty() || fs::is_directory(paths.images, error)) return {};
  return input_error("no such folder", paths.images, "--images wants a folder with one folder of images a camera");
}

std::vector<std::string> image_places(const RecordingPaths& paths) {
  if (!paths.images.empty()) return {paths.images};
  const fs::path input(paths.input);
  return {(input / "images").string(), (input / "patches" / "image").string(), (input / "image").string()};
}

void add_near_points(std::span<const Point> points, double within_m, std::vector<Point>& out) {
  const auto most = static_cast<float>(within_m * within_m);
  for (const Point& p : points) {
    if (p.x * p.x + p.y * p.y + p.z * p.z < most) out.push_back(p);
  }
}

Expected<Recording> read_recording(const RecordingPaths& paths, const CellOptions& cells, const RunContext& context) {
  if (const auto fit = check_images(paths); !fit) return fit.error();
  Expected<Recording> recording = read_points(paths, cells, context);
  if (!recording) return recording;
  if (paths.images.empty() && is_bag(paths.input)) {
    recording->cameras = bag_camera_recordings(recording->rig, recording->lidar.stops, paths.input);
    return recording;
  }
  take_cameras(paths, *recording);
  return recording;
}

void take_cameras(const RecordingPaths& paths, Recording& recording, const std::shared_ptr<StopImageCache>& ahead) {
  const std::string why_none =
      paths.images.empty()
          ? "the recording has no images of it; give them by --images DIR, or find the LiDARs alone by --stages joint"
          : paths.images +
                " has no folder that is named after it: --images wants the folder above those of the cameras";
  recording.cameras = camera_recordings(recording.rig, recording.lidar.stops, image_places(paths), why_none, ahead);
}

}  // namespace rigcal
