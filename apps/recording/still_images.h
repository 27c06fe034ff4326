#pragma once

#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "apps/recording/image_mean.h"
#include "apps/recording/stop_image_cache.h"
#include "core/base/error.h"
#include "core/io/image_folder.h"
#include "core/pipeline/camera_stage.h"
#include "core/records/records.h"
#include "core/rig/rig.h"

namespace rigcal {

/// Where the images of a camera lie: `<place>/<camera or its folder key>`, the first of `places` that has it; empty: in
/// none.
[[nodiscard]] std::string image_folder_of(const Sensor& camera, const std::vector<std::string>& places);
/// Warns of what in a camera's folder nobody uses. Returns how it lies or is named instead, to be appended to a
/// sentence; mostly empty.
std::string tell_of_unused(const std::string& folder, const ImageFolder& listed, Reporter& reporter);
/// The numbers of the stops that hold the exposures of a folder's images, in the order of these.
[[nodiscard]] std::vector<std::optional<int>> stops_of_images(const ImageFolder& folder, const Sensor& camera,
                                                              const std::vector<Stop>& stops);

/// Reads the images of one camera from its folder (`list_image_folder`) and keeps those taken in a stop: the whole
/// exposure must lie in it. Stops without times are told by frames.csv's remark, or by the files' names. Several images
/// of a stop become their mean, which has less noise; the rig stood still. What cannot be used is left out with a
/// warning: damaged files, another size than the intrinsics', exposures outside of all stops. What `ahead` has of them,
/// read in the camera's pixel format, is taken from there; it may be null.
[[nodiscard]] StillImages read_still_images(const std::string& folder, const Sensor& camera,
                                            const std::vector<Stop>& stops, const RunContext& context,
                                            StopImageCache* ahead = nullptr);

/// Reads what there is so far of the images of a recording that goes on, of all cameras of the rig in stops that are
/// over, and looks for their edges. Files that cannot be read are left for the end, which tells of them.
void read_images_ahead(const Rig& rig, const std::vector<Stop>& stops, const std::vector<std::string>& places,
                       StopImageCache& ahead, const std::stop_token& stop);

/// The images of one stop: checked, and their mean taken. `camera` must outlive it.
class StopImages {
 public:
  explicit StopImages(const Sensor& camera) : camera_(&camera) {}
  /// `name` stands for the image in sentences about it.
  void add(const std::string& name, const Expected<Image>& image);
  /// Nothing where no image could be used.
  [[nodiscard]] std::optional<StillImage> take(int stop) const;
  [[nodiscard]] const std::vector<std::string>& complaints() const { return complaints_; }

 private:
  const Sensor* camera_;
  ImageMean mean_;
  std::string first_;
  std::vector<std::string> complaints_;
};

/// Warns of what was left out, the first few by name; where nothing else is left it becomes `why_none`.
void conclude_images(const std::string& camera, const std::vector<std::string>& complaints, const RunContext& context,
                     StillImages& out);

/// The numbers of the stops of which the cameras of a rig have images, where the recording has no times: then
/// frames.csv remarks them, or files are named by their stop.
[[nodiscard]] std::set<int> stops_with_images(const Rig& rig, const std::vector<std::string>& places);

/// The cameras of a rig whose images lie in `<place>/<camera or its folder key>/`, the first of `places` that has it;
/// `why_none` says so where none has. Guesses are the rig file's.
[[nodiscard]] std::vector<CameraRecording> camera_recordings(const Rig& rig, const std::vector<Stop>& stops,
                                                             const std::vector<std::string>& places,
                                                             const std::string& why_none,
                                                             const std::shared_ptr<StopImageCache>& ahead = nullptr);

}  // namespace rigcal
