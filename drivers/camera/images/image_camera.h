#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/camera/camera.h"

namespace rigcal::camera {

struct ImageCameraOptions {
  enum class Pace : std::uint8_t {
    recorded,  ///< As the images' stamps are apart; as taken where they have none.
    as_taken,  ///< The next one whenever it is asked for.
  };
  std::string folder;  ///< Holds a folder of images for each camera, as `images/` of a session does; may be empty.
  Pace pace = Pace::recorded;  ///< Unless CameraConfig::frame_rate or a software trigger says otherwise.
};

/// Folders of images (frames.csv, or files named by numbers: core/io/image_folder.h) as cameras. `open` also takes the
/// path of any folder. Each image is a frame: its id is its place in the folder, from 0; its device stamp what
/// frames.csv or its name says. An image that cannot be read is a device_error, one of another size or depth than the
/// first is of the wrong size. Grey images may be named as any grey or Bayer format of their depth. A trigger by
/// software gives an image each; lines are not asked, with a note. Decoding asks for memory of its own, for each frame.
class ImageBackend final : public CameraBackend {
 public:
  explicit ImageBackend(ImageCameraOptions options) : options_(std::move(options)) {}
  [[nodiscard]] std::string_view name() const override { return "images"; }
  [[nodiscard]] Expected<std::vector<CameraIdentity>> enumerate() override;
  [[nodiscard]] std::unique_ptr<Camera> make() override;

 private:
  ImageCameraOptions options_;
};

}  // namespace rigcal::camera
