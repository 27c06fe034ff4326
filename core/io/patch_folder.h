#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/pcd_file.h"
#include "core/io/staged_folder.h"
#include "core/records/records.h"
#include "core/rig/rig.h"

namespace rigcal {

struct PatchFile {
  int stop = 0;
  std::string path;
};

/// What lies in a patch folder (docs/manual.md, "Inputs"): `<folder>/<sensor or its folder key>/<stop>.pcd`.
struct PatchFolder {
  std::string path;
  /// By the sensor's index in the rig, sorted by stop; empty for cameras and for LiDARs without a folder.
  std::vector<std::vector<PatchFile>> patches;
  std::vector<int> stops;  ///< All stop numbers that occur, sorted.
  /// T_G_base by stop number from trajectory.tum, where there is one; may hold stops without a patch.
  std::optional<std::map<int, SE3>> trajectory;
  /// What is not used, for a warning; sorted: names that belong to no sensor, and, with their folder before them, those
  /// in a sensor's folder that are no <stop>.pcd.
  std::vector<std::string> unknown;
};

/// Why what is `unknown` is not used, a sentence for each reason.
[[nodiscard]] std::vector<std::string> reasons_of_unknown(const PatchFolder& folder);

/// Lists a patch folder; clouds are not opened. That of a rig with cameras alone holds none, and no stops.
/// `trajectory_path` empty: `<folder>/trajectory.tum`, if it is there. Errors: no folder, nothing in it, no folder for
/// any LiDAR (names what is there) or no images where the rig has no LiDAR, two files for one stop, a trajectory whose
/// first column is no stop number or has one twice.
[[nodiscard]] Expected<PatchFolder> list_patch_folder(const std::string& path, const Rig& rig,
                                                      const std::string& trajectory_path = {});

/// Writes a patch folder, which appears as a whole with `finish`. An existing path is never touched.
class PatchFolderWriter {
 public:
  [[nodiscard]] static Expected<PatchFolderWriter> create(const std::string& path, const Rig& rig);

  /// Where the folder is being made.
  [[nodiscard]] const std::string& path() const { return folder_.path(); }
  Expected<void> write(const Patch& patch);
  /// The file of a patch that comes in parts; to be finished before the folder is.
  [[nodiscard]] Expected<PcdWriter> open(int sensor, int stop, PcdColumns columns = {}) const;
  /// Where the image of a camera and a stop goes; makes the folder.
  [[nodiscard]] Expected<std::string> image_path(int sensor, int stop) const;
  /// What the rig file says goes beside the patches: rig.yaml.
  Expected<void> write_rig_file(const std::string& text) const;
  /// T_G_base by stop number.
  Expected<void> write_trajectory(const std::map<int, SE3>& poses);
  /// A power cut that comes later leaves it whole.
  Expected<void> finish();

 private:
  PatchFolderWriter(StagedFolder folder, std::vector<std::string> names)
      : folder_(std::move(folder)), names_(std::move(names)) {}

  StagedFolder folder_;
  std::vector<std::string> names_;  ///< Folder of each sensor.
};

}  // namespace rigcal
