#include "apps/patch_export.h"

#include <filesystem>
#include <variant>

#include "core/io/las_file.h"
#include "core/io/patch_folder.h"

namespace rigcal {
namespace {

/// Writes each sensor's cloud as it comes.
class PatchFiles final : public StopSink {
 public:
  PatchFiles(const Rig& rig, PatchLayout layout, std::string out, ImageFiles* images)
      : rig_(rig), layout_(layout), out_(std::move(out)), images_(images) {}

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

  Expected<void> finish(const StreamSource& source, const std::vector<StopRecord>& stops) {
    if (clouds_) {
      if (Expected<void> synced = clouds_->sync(); !synced) return synced;
      return clouds_->commit();
    }
    if (const Expected<void> copied = patches_->copy_rig_file(source.rig_path); !copied) return copied;
    const std::map<int, SE3> poses = gyro_trajectory(rig_, stops);
    if (!poses.empty()) {
      if (const Expected<void> written = patches_->write_trajectory(poses); !written) return written;
    }
    return patches_->finish();
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
    if (patches_) return either(patches_->open(sensor, stop));
    const std::string name = rig_.sensors[static_cast<std::size_t>(sensor)].name + "_" + std::to_string(stop);
    const std::filesystem::path path = std::filesystem::path(clouds_->path()) / name;
    if (layout_ == PatchLayout::pcd) return either(PcdWriter::create(path.string() + ".pcd", true));
    // Its point source ids begin at 1: 0 is for points of no source.
    return either(LasWriter::create(path.string() + ".las", {static_cast<std::uint16_t>(sensor + 1), true}));
  }

  const Rig& rig_;
  PatchLayout layout_;
  std::string out_;
  std::optional<PatchFolderWriter> patches_;
  std::optional<StagedFolder> clouds_;
  std::map<int, CloudFile> open_;
  ImageFiles* images_;
  Expected<void> status_;
  std::uint64_t files_ = 0;
  std::uint64_t left_out_ = 0;
};

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
  return poses;
}

Expected<PatchExport> export_patches(const StreamSource& source, PatchLayout layout, const std::string& out,
                                     const RunContext& context, ImageFiles* images) {
  PatchFiles files(source.rig, layout, out, images);
  const StopOptions options;
  Expected<StopReading> summary = read_stops(source, options, files, context);
  if (!summary) return summary.error();
  if (std::optional<Error> error = reading_error(source, options, *summary)) return *error;
  for (const std::string& warning : reading_warnings(source, *summary)) context.reporter.warn(warning);
  if (files.left_out() > 0) {
    context.reporter.warn(std::to_string(files.left_out()) +
                          " points lie farther than a .las file can say (214 km) and are left out; give the LiDAR a "
                          "range in the rig file");
  }
  if (const Expected<void> finished = files.finish(source, summary->stops); !finished) return finished.error();
  return PatchExport{std::move(*summary), files.files()};
}

}  // namespace rigcal
