#include "drivers/camera/images/image_camera.h"
#include "tests/drivers/camera/contract.h"
#include "tests/drivers/camera/image_folder_fixture.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::camera {
namespace {

class ImagesSubject final : public ContractSubject {
 public:
  ImagesSubject() {
    write_camera_folder(scratch_ / "camera_left", 100, 20'000'000);
    write_camera_folder(scratch_ / "camera_right", 2, 20'000'000);
  }
  CameraBackend& backend() override { return backend_; }
  [[nodiscard]] std::string camera() const override { return "camera_left"; }
  [[nodiscard]] CameraConfig config() const override { return {}; }
  [[nodiscard]] std::optional<Region> part() const override { return Region{8, 4, 32, 16}; }
  [[nodiscard]] bool allocates_for_frames() const override { return true; }

 private:
  std::filesystem::path scratch_ = scratch_folder("images_subject");
  ImageBackend backend_{{scratch_.string(), ImageCameraOptions::Pace::recorded}};
};

}  // namespace

std::unique_ptr<ContractSubject> make_images_subject(std::string&) { return std::make_unique<ImagesSubject>(); }

}  // namespace rigcal::camera
