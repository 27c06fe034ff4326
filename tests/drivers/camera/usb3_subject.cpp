// Aravis with a USB3 Vision device: our virtual one on the kernel's dummy USB host, in the virtual machine of
// tests/hil.
#include <cstdlib>

#include "drivers/camera/aravis/aravis_backend.h"
#include "tests/drivers/camera/contract.h"

namespace rigcal::camera {
namespace {

class Usb3Subject final : public ContractSubject {
 public:
  explicit Usb3Subject(std::string serial) : serial_(std::move(serial)) {}
  CameraBackend& backend() override { return backend_; }
  [[nodiscard]] std::string camera() const override {
    const auto there = AravisBackend().enumerate();
    for (const CameraIdentity& camera : *there)
      if (camera.serial == serial_) return camera.id;
    return {};
  }
  [[nodiscard]] std::string name() const override { return serial_; }
  [[nodiscard]] CameraConfig config() const override {
    CameraConfig config;
    config.pixel_format = "Mono8";
    config.region = Region{0, 0, 256, 128};
    config.frame_rate = 20.0;
    config.exposure_us = 1000.0;
    return config;
  }
  [[nodiscard]] std::optional<Region> part() const override { return Region{16, 8, 128, 64}; }
  [[nodiscard]] std::uint64_t most_not_whole() const override { return 3; }

 private:
  std::string serial_;
  AravisBackend backend_;
};

}  // namespace

std::unique_ptr<ContractSubject> make_usb3_subject(std::string& reason) {
  if (const char* serial = std::getenv("RIGCAL_TEST_USB3")) return std::make_unique<Usb3Subject>(serial);
  reason = "no USB3 Vision camera: set RIGCAL_TEST_USB3 to the serial number of one";
  return nullptr;
}

}  // namespace rigcal::camera
