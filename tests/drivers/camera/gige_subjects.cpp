// Aravis with GigE Vision devices on the loopback network: its own, and ours.
#include <arv.h>

#include "drivers/camera/aravis/aravis_backend.h"
#include "tests/drivers/camera/contract.h"
#include "tests/drivers/camera/virtual_camera.h"

namespace rigcal::camera {
namespace {

/// Our device is slow enough for a busy machine, and small.
class VirtualGigeSubject final : public ContractSubject {
 public:
  CameraBackend& backend() override { return backend_; }
  [[nodiscard]] std::string camera() const override { return id_of(device_); }
  [[nodiscard]] std::string name() const override { return address_of(device_); }
  [[nodiscard]] CameraConfig config() const override { return small_config(); }
  [[nodiscard]] std::optional<Region> part() const override { return Region{16, 8, 128, 64}; }
  [[nodiscard]] std::uint64_t most_not_whole() const override { return 3; }

  [[nodiscard]] bool start(std::string& reason) {
    auto started = sim::CameraServer::start({device_});
    if (!started) {
      reason = started.error().message();
      return false;
    }
    server_ = *std::move(started);
    return true;
  }

 private:
  sim::ServedCamera device_ = virtual_camera(41, "00C0117AC7");
  std::unique_ptr<sim::CameraServer> server_;
  AravisBackend backend_;
};

class AravisFakeSubject final : public ContractSubject {
 public:
  ~AravisFakeSubject() override { g_object_unref(camera_); }
  CameraBackend& backend() override { return backend_; }
  [[nodiscard]] std::string camera() const override { return "Aravis-Fake-GV4711"; }
  [[nodiscard]] std::string name() const override { return "127.0.0.1"; }
  [[nodiscard]] CameraConfig config() const override {
    CameraConfig config;
    config.pixel_format = "Mono8";
    config.region = Region{0, 0, 256, 128};
    config.frame_rate = 30.0;
    return config;
  }
  [[nodiscard]] std::optional<Region> part() const override { return Region{16, 8, 128, 64}; }
  [[nodiscard]] std::uint64_t most_not_whole() const override { return 3; }
  [[nodiscard]] bool is_running() const { return arv_gv_fake_camera_is_running(camera_) != 0; }

 private:
  ArvGvFakeCamera* camera_ = arv_gv_fake_camera_new("127.0.0.1", "GV4711");
  AravisBackend backend_;
};

}  // namespace

std::unique_ptr<ContractSubject> make_virtual_gige_subject(std::string& reason) {
  auto subject = std::make_unique<VirtualGigeSubject>();
  if (!subject->start(reason)) return nullptr;
  return subject;
}

std::unique_ptr<ContractSubject> make_aravis_fake_subject(std::string& reason) {
  auto subject = std::make_unique<AravisFakeSubject>();
  if (subject->is_running()) return subject;
  reason = "Aravis' fake camera does not start on 127.0.0.1";
  return nullptr;
}

}  // namespace rigcal::camera
