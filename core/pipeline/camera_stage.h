#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/run_context.h"
#include "core/camera/camera_calibration.h"
#include "core/pipeline/lidar_result.h"
#include "core/pipeline/map_colours.h"
#include "core/quality/result.h"
#include "core/records/image.h"

namespace rigcal {

/// What is looked for in an image, whatever the poses are.
struct ImageFeatures {
  GreyImage grey;  ///< On the scale of the image's own bits, halved so often.
  std::shared_ptr<const std::vector<ImageEdge>> edges;
  int halvings = 0;
};
[[nodiscard]] ImageFeatures find_features(const Image& image, int halvings);

/// An image taken while the rig stood still.
struct StillImage {
  int stop = 0;  ///< Index into LidarRecording::stops.
  std::string file;
  Image image;
  /// Where somebody has found them already; null: they are found when they are needed.
  std::shared_ptr<const ImageFeatures> features = nullptr;
};

/// What a recording has of one camera. Without an image, `why_none` says why, in a sentence a user can act on.
struct StillImages {
  std::vector<StillImage> images;
  std::string why_none;
};

/// A camera of a recording. Its images are read when its turn has come, so that those of one camera at a time are held.
struct CameraRecording {
  int sensor = 0;  ///< Index in the rig.
  std::optional<SE3> guess_T_base_camera;
  std::function<StillImages(const RunContext&)> read_images;
};

/// How wide the beams of these LiDARs of a rig are: outlines are looked for by it.
[[nodiscard]] std::vector<BeamWidth> beam_widths(const Rig& rig, const std::vector<int>& lidar_sensors);

/// Poses, edges and samples of the map that the LiDAR calibration ended with. Told to stop, it leaves out what it has
/// not begun.
[[nodiscard]] CameraScene make_camera_scene(const Rig& rig, const LidarRecording& recording,
                                            const LidarSolution& solution, const std::stop_token& stop = {});

/// The images in grey, halved so often (core/camera/working_size.h), all of them on the scale of the one with the most
/// bits, without those that show nothing (warned of by name).
[[nodiscard]] std::vector<CameraView> camera_views(const std::vector<StillImage>& images, int halvings,
                                                   const std::string& camera, const RunContext& context);

/// The same images for the colours of the map, on the same scale.
[[nodiscard]] std::vector<ColourPicture> colour_pictures(const std::vector<StillImage>& images);

/// Finds the cameras one after the other, each on all threads, and adds to `result` their sensors (in the order of the
/// rig), evidence, edges and stages; its status becomes the worst. What keeps a camera from being found is a reason of
/// its verdict, never an Error. `solved` is called when all that is a number stands, and may complete the result;
/// colours of its map come after that. Errors: cancelled.
Expected<void> add_cameras(const Rig& rig, const std::vector<CameraRecording>& cameras, const LidarRecording& recording,
                           const LidarSolution& solution, const Requirement& require,
                           const CameraCalibrationOptions& options, const RunContext& context,
                           CalibrationResult& result, const std::function<void()>& solved);

}  // namespace rigcal
