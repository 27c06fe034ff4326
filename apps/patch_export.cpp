#include "apps/patch_export.h"

#include <filesystem>

#include "core/io/patch_folder.h"

namespace rigcal {
namespace {

/// Writes each sensor's cloud as it comes.
class PatchFiles final : public StopSink {
 public:
  PatchFiles(const Rig& rig, PatchLayout layout, std::string out) : rig_(rig), layout_(layout), out_(std::move(out)) {}

  Expected<void> restart() override {
    open_.clear();
    files_ = 0;
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
    return {};
  }

  [[nodiscard]] Expected<void> status() const override { return status_; }

  void points(int sensor, int stop, std::span<const Point> points) override {
    if (!status_) return;
    auto place = open_.find(sensor);
    if (place == open_.end()) {
      Expected<PcdWriter> writer = open(sensor, stop);
      if (!writer) {
        status_ = writer.error();
        return;
      }
      place = open_.emplace(sensor, std::move(*writer)).first;
      ++files_;
    }
    place->second.write(points);
  }

  void stop_done(const StopRecord&) override {
    for (auto& [sensor, writer] : open_) {
      const Expected<void> finished = writer.finish();
      if (status_ && !finished) status_ = finished;
    }
    open_.clear();
  }

  Expected<void> finish(const StreamSource& source, const std::vector<StopRecord>& stops) {
    if (clouds_) return clouds_->commit();
    if (const Expected<void> copied = patches_->copy_rig_file(source.rig_path); !copied) return copied;
    const std::map<int, SE3> poses = gyro_trajectory(rig_, stops);
    if (!poses.empty()) {
      if (const Expected<void> written = patches_->write_trajectory(poses); !written) return written;
    }
    return patches_->finish();
  }

  [[nodiscard]] std::uint64_t files() const { return files_; }

 private:
  Expected<PcdWriter> open(int sensor, int stop) const {
    if (patches_) return patches_->open(sensor, stop);
    const std::string name = rig_.sensors[static_cast<std::size_t>(sensor)].name + "_" + std::to_string(stop) + ".pcd";
    return PcdWriter::create((std::filesystem::path(clouds_->path()) / name).string());
  }

  const Rig& rig_;
  PatchLayout layout_;
  std::string out_;
  std::optional<PatchFolderWriter> patches_;
  std::optional<StagedFolder> clouds_;
  std::map<int, PcdWriter> open_;
  Expected<void> status_;
  std::uint64_t files_ = 0;
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
                                     const RunContext& context) {
  PatchFiles files(source.rig, layout, out);
  const StopOptions options;
  Expected<StopReading> summary = read_stops(source, options, files, context);
  if (!summary) return summary.error();
  if (std::optional<Error> error = reading_error(source, options, *summary)) return *error;
  for (const std::string& warning : reading_warnings(source, *summary)) context.reporter.warn(warning);
  if (const Expected<void> finished = files.finish(source, summary->stops); !finished) return finished.error();
  return PatchExport{std::move(*summary), files.files()};
}

}  // namespace rigcal
