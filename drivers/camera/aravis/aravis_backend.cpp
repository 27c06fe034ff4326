#include "drivers/camera/aravis/aravis_backend.h"

#include <arv.h>

#include <mutex>

#include "drivers/camera/aravis/aravis_camera.h"

namespace rigcal::camera {
namespace {

std::string text_of(const char* text) { return text == nullptr ? std::string() : std::string(text); }

}  // namespace

Expected<std::vector<CameraIdentity>> AravisBackend::enumerate() {
  // Aravis has one list for the whole program.
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  arv_update_device_list();
  std::vector<CameraIdentity> cameras;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    CameraIdentity camera;
    camera.vendor = text_of(arv_get_device_vendor(i));
    camera.model = text_of(arv_get_device_model(i));
    camera.serial = text_of(arv_get_device_serial_nbr(i));
    camera.id = text_of(arv_get_device_id(i));
    const bool is_usb = text_of(arv_get_device_protocol(i)) == "USB3Vision";
    camera.link = is_usb ? "USB3 Vision" : "GigE Vision";
    camera.address = is_usb ? camera.id : text_of(arv_get_device_address(i));
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

std::unique_ptr<Camera> AravisBackend::make() { return make_aravis_camera(options_); }

}  // namespace rigcal::camera
