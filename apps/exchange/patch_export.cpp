#include "apps/exchange/patch_export.h"

#include <cmath>
#include <filesystem>
#include <functional>
#include <variant>

#include "apps/exchange/patch_images.h"
#include "apps/recording/cloud_flaws.h"
#include "apps/recording/recorded_formats.h"
#include "core/io/las_file.h"
#include "core/io/patch_folder.h"
#include "core/io/pcd_file.h"

namespace rigcal {
namespace {

/// Writes each sensor's cloud as it comes.
class PatchFiles final : public StopSink {
 public:
  /// `of_patches`: the points have no times, but the numbers of their rings, where the rig file says so.
  PatchFiles(const Rig& rig, PatchLayout layout, bool of_patches, std::string out, ImageFiles* images)
      : rig_(rig), layout_(layout), of_patches_(of_patches), out_(std::move(out)), images_(images) {}

  Expected<void> restart() override {
    open_.clear();
    files_ = 0;
    left_out_ = 0;
    patches_.reset();
    clouds_.reset();
    if (layout_ == PatchLayout::patches) {
      Expected<PatchFolderWriter> folder = PatchFolderWriter::create(out_, rig_);
      if (!folder) return folder.error();
      patches_.emplace(std::move(*folder));
    } else {
      Expected<StagedFolder> folder = StagedFolder::create(out_);
      if (!folder) return folder.error();
      clouds_.emplace(std::move(*folder));
    }
    return images_ == nullptr ? Expected<void>{} : images_->restart();
  }

  [[nodiscard]] Expected<void> status() const override {
    return status_ && images_ != nullptr ? images_->status() : status_;
  }

  void points(int sensor, int stop, std::span<const Point> part) override { timed_points(sensor, stop, {}, part); }

  void timed_points(int sensor, int stop, const ShotTimes& times, std::span<const Point> part) override {
    if (!status_) return;
    auto place = open_.find(sensor);
    if (place == open_.end()) {
      Expected<CloudFile> writer = open(sensor, stop);
      if (!writer) {
        status_ = writer.error();
        return;
      }
      place = open_.emplace(sensor, std::move(*writer)).first;
      ++files_;
    }
    std::visit([&](auto& file) { file.write(part, times.stamp_ns, times.shot_interval_ns); }, place->second);
  }

  void image(const RecordedImage& image) override {
    if (images_ != nullptr) images_->write(image);
  }

  void stop_done(const StopRecord&) override {
    for (auto& [sensor, writer] : open_) {
      const Expected<void> finished = std::visit([](auto& file) { return file.finish(); }, writer);
      if (status_ && !finished) status_ = finished;
      if (const auto* las = std::get_if<LasWriter>(&writer)) left_out_ += las->left_out();
    }
    open_.clear();
  }

  /// Returns the number of images. Those that `images` got are not written once more.
  Expected<std::uint64_t> finish(const StreamSource& source, const std::vector<StopRecord>& stops,
                                 const std::map<int, SE3>& poses, const RunContext& context) {
    if (clouds_) {
      Expected<void> done = clouds_->sync();
      if (done) done = clouds_->commit();
      return done ? Expected<std::uint64_t>(0) : done.error();
    }
    if (const auto written = patches_->write_rig_file(source.rig_text); !written) return written.error();
    Rig rig = source.rig;
    if (!of_patches_) {
      if (const auto said = take_back_rings(patches_->path(), rig, context.reporter); !said) return said.error();
    }
    PatchImages images;
    if (images_ == nullptr) {
      Expected<PatchImages> written = write_patch_images(source, stops, *patches_, context);
      if (!written) return written.error();
      images = std::move(*written);
    }
    if (const auto named = name_formats(patches_->path(), rig, images.missing_formats, context.reporter); !named)
      return named.error();
    if (!poses.empty()) {
      if (const Expected<void> written = patches_->write_trajectory(poses); !written) return written.error();
    }
    if (const Expected<void> finished = patches_->finish(); !finished) return finished.error();
    return images.files;
  }

  [[nodiscard]] std::uint64_t files() const { return files_; }
  [[nodiscard]] std::uint64_t left_out() const { return left_out_; }  ///< Points that their format cannot hold.

 private:
  using CloudFile = std::variant<PcdWriter, LasWriter>;

  template <class Writer>
  static Expected<CloudFile> either(Expected<Writer> writer) {
    if (!writer) return writer.error();
    return CloudFile(std::move(*writer));
  }

  Expected<CloudFile> open(int sensor, int stop) const {
    const Sensor& lidar = rig_.sensors[static_cast<std::size_t>(sensor)];
    const bool has_rings = of_patches_ && lidar.lidar->rings;
    if (patches_) return either(patches_->open(sensor, stop, {false, has_rings}));
    const std::string name = lidar.name + "_" + std::to_string(stop);
    const std::filesystem::path path = std::filesystem::path(clouds_->path()) / name;
    if (layout_ == PatchLayout::pcd)
      return either(PcdWriter::create(path.string() + ".pcd", {!of_patches_, has_rings}));
    // Its point source ids begin at 1: 0 is for points of no source.
    return either(LasWriter::create(path.string() + ".las", {static_cast<std::uint16_t>(sensor + 1), !of_patches_}));
  }

  const Rig& rig_;
  PatchLayout layout_;
  bool of_patches_;
  std::string out_;
  std::optional<PatchFolderWriter> patches_;
  std::optional<StagedFolder> clouds_;
  std::map<int, CloudFile> open_;
  ImageFiles* images_;
  Expected<void> status_;
  std::uint64_t files_ = 0;
  std::uint64_t left_out_ = 0;
};

/// What a recording gives: its points go to a PatchFiles meanwhile.
struct ExportReading {
  StopReading stops;
  std::map<int, SE3> poses;
};

Expected<ExportReading> read_recording_of_packets(const StreamSource& source, PatchFiles& files,
                                                  const RunContext& context) {
  if (const std::optional<Error> none = no_lidar_error(source)) return *none;
  const StopOptions options;
  Expected<StopReading> reading = read_stops(source, options, files, context);
  if (!reading) return reading.error();
  if (std::optional<Error> error = reading_error(source, options, *reading)) {
    warn_of_file(source, *reading, context.reporter);
    return *error;
  }
  for (const std::string& warning : reading_warnings(source, *reading)) context.reporter.warn(warning);
  std::map<int, SE3> poses = gyro_trajectory(source.rig, reading->stops);
  return ExportReading{std::move(*reading), std::move(poses)};
}

/// The points of a cloud that lie within the LiDAR's range. Returns how many these are.
Expected<std::uint64_t> read_cloud(const std::string& path, const Sensor& sensor, CloudFlaws& flaws,
                                   const std::function<void(std::span<const Point>)>& take) {
  const auto& range = sensor.lidar->range_m;
  std::uint64_t count = 0;
  std::vector<Point> within;
  const Expected<PcdSummary> cloud = read_pcd(path, [&](std::span<const Point> points) {
    within.clear();
    for (const Point& p : points) {
      const double distance_m = std::hypot(p.x, p.y, p.z);
      if (!range || (distance_m >= (*range)[0] && distance_m <= (*range)[1])) within.push_back(p);
    }
    count += within.size();
    take(within);
  });
  if (!cloud) return cloud.error();
  flaws.add(*cloud);
  return count;
}

Expected<ExportReading> read_recording_of_patches(const StreamSource& source, PatchFiles& files,
                                                  const RunContext& context) {
  // That of a session lies beside its patches.
  const std::filesystem::path tum = std::filesystem::path(source.path) / "trajectory.tum";
  std::error_code error;
  const Expected<PatchFolder> folder =
      list_patch_folder(source.file, source.rig, std::filesystem::exists(tum, error) ? tum.string() : std::string());
  if (!folder) return folder.error();
  if (folder->stops.empty()) return input_error("holds no clouds", source.path, "give a recording of LiDARs");
  for (const std::string& reason : reasons_of_unknown(*folder)) context.reporter.warn(folder->path + ": " + reason);
  if (const Expected<void> ready = files.restart(); !ready) return ready.error();
  std::vector<CloudFlaws> flaws(source.rig.sensors.size());
  ExportReading out;
  if (folder->trajectory) out.poses = *folder->trajectory;
  for (const int stop : folder->stops) {
    StopRecord record;
    record.stop.index = stop;
    for (std::size_t i = 0; i < folder->patches.size(); ++i) {
      for (const PatchFile& file : folder->patches[i]) {
        if (file.stop != stop) continue;
        if (context.cancelled()) return cancelled_error("stopped", source.path);
        const int sensor = static_cast<int>(i);
        const Expected<std::uint64_t> count =
            read_cloud(file.path, source.rig.sensors[i], flaws[i],
                       [&](std::span<const Point> part) { files.points(sensor, stop, part); });
        if (!count) return count.error();
        record.points[sensor] = *count;
        out.stops.points.in_stops += *count;
      }
    }
    files.stop_done(record);
    if (const Expected<void> written = files.status(); !written) return written.error();
    out.stops.stops.push_back(std::move(record));
    context.reporter.progress("exporting",
                              static_cast<double>(out.stops.stops.size()) / static_cast<double>(folder->stops.size()));
  }
  for (std::size_t i = 0; i < flaws.size(); ++i) {
    for (const std::string& warning : flaws[i].warnings(source.rig.sensors[i].name)) context.reporter.warn(warning);
  }
  return out;
}

// Stops before which a gyro told how far the rig turned, and that have no pose all the same.
std::size_t turns_left_out(const std::vector<StopRecord>& stops, const std::map<int, SE3>& poses) {
  std::size_t count = 0;
  for (std::size_t j = 1; j < stops.size(); ++j) {
    if (stops[j].rotation_known && poses.count(stops[j].stop.index) == 0) ++count;
  }
  return count;
}

}  // namespace

std::map<int, SE3> gyro_trajectory(const Rig& rig, const std::vector<StopRecord>& stops) {
  std::map<int, SE3> poses;
  SE3 pose;
  for (const StopRecord& stop : stops) {
    const std::optional<Matrix3d> rotation = base_rotation(rig, stop);
    if (!rotation) break;
    pose.R = pose.R * *rotation;
    poses[stop.stop.index] = pose;
  }
  if (poses.size() == 1) poses.clear();  // That of the first stop alone tells no turn.
  return poses;
}

Expected<PatchExport> export_patches(const StreamSource& source, PatchLayout layout, const std::string& out,
                                     const RunContext& context, ImageFiles* images) {
  std::error_code error;
  const bool patches = std::filesystem::is_directory(source.file, error);
  PatchFiles files(source.rig, layout, patches, out, images);
  Expected<ExportReading> reading =
      patches ? read_recording_of_patches(source, files, context) : read_recording_of_packets(source, files, context);
  if (!reading) return reading.error();
  if (files.left_out() > 0) {
    context.reporter.warn(std::to_string(files.left_out()) +
                          " points lie farther than a .las file can say (214 km) and are left out; give the LiDAR a "
                          "range in the rig file");
  }
  const bool has_turns = layout == PatchLayout::patches && !patches;
  if (const std::size_t lost = turns_left_out(reading->stops.stops, reading->poses); has_turns && lost > 0) {
    context.reporter.warn(
        "the turns before " + std::to_string(lost) +
        " stops, which a gyro told, are not in trajectory.tum: it has all turns up to the first that is "
        "not known in the base's frame, and calibrating these patches may go worse than the recording; "
        "give the LiDAR with the gyro an initial_extrinsics in the rig file");
  }
  const Expected<std::uint64_t> written = files.finish(source, reading->stops.stops, reading->poses, context);
  if (!written) return written.error();
  return PatchExport{std::move(reading->stops), files.files(), *written};
}

}  // namespace rigcal
