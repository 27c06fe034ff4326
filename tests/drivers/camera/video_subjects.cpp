// Video4Linux: answered by the test, and a device of this machine.
#include <cstdlib>

#include "drivers/camera/v4l2/video_backend.h"
#include "tests/drivers/camera/contract.h"
#include "tests/drivers/camera/fake_video_kernel.h"

namespace rigcal::camera {
namespace {

class FakeVideoSubject final : public ContractSubject {
 public:
  CameraBackend& backend() override { return backend_; }
  [[nodiscard]] std::string camera() const override { return "Test-Camera-V4L2-0815"; }
  [[nodiscard]] CameraConfig config() const override {
    CameraConfig config;
    config.pixel_format = "BayerRG8";
    config.frame_rate = 50.0;
    return config;
  }
  [[nodiscard]] std::optional<Region> part() const override { return Region{16, 8, 64, 48}; }
  [[nodiscard]] bool has_software_trigger() const override { return false; }

 private:
  VideoBackend backend_{std::make_shared<FakeVideoKernel>()};
};

/// Any camera that sends Mono8, or the format that is named, at its own size and rate, for example one of the kernel's
/// module `vivid`.
class VideoDeviceSubject final : public ContractSubject {
 public:
  explicit VideoDeviceSubject(std::string path) : path_(std::move(path)) {}
  CameraBackend& backend() override { return backend_; }
  [[nodiscard]] std::string camera() const override {
    const auto there = VideoBackend().enumerate();
    for (const CameraIdentity& camera : *there) {
      if (camera.address == path_) return camera.id;
    }
    return {};
  }
  [[nodiscard]] std::string name() const override { return path_; }
  [[nodiscard]] CameraConfig config() const override {
    CameraConfig config;
    const char* format = std::getenv("RIGCAL_TEST_V4L2_FORMAT");
    config.pixel_format = format == nullptr ? "Mono8" : format;
    return config;
  }
  [[nodiscard]] std::optional<Region> part() const override { return Region{0, 0, 640, 480}; }
  [[nodiscard]] std::string missing_format() const override { return "Mono7"; }
  [[nodiscard]] bool has_software_trigger() const override { return false; }

 private:
  std::string path_;
  VideoBackend backend_;
};

}  // namespace

std::unique_ptr<ContractSubject> make_fake_video_subject(std::string&) { return std::make_unique<FakeVideoSubject>(); }

std::unique_ptr<ContractSubject> make_video_device_subject(std::string& reason) {
  if (const char* path = std::getenv("RIGCAL_TEST_V4L2")) return std::make_unique<VideoDeviceSubject>(path);
  reason = "no V4L2 camera: set RIGCAL_TEST_V4L2=/dev/videoN (and RIGCAL_TEST_V4L2_FORMAT where it has no Mono8)";
  return nullptr;
}

}  // namespace rigcal::camera
