// A virtual USB3 Vision camera, plugged into the kernel's dummy USB host until SIGTERM.
// Usage: usb3_camera_gadget [FILE]     FILE shows the level of the line that triggers it (gpio-sim's `value`)
#include <csignal>
#include <cstdio>

#include "tests/hil/usb3/camera_gadget.h"

namespace {

rigcal::hil::CameraGadget* running = nullptr;

void on_signal(int number) {
  if (number != SIGUSR1 && running != nullptr) running->stop();
}

}  // namespace

int main(int count, char** words) {
  struct sigaction action {};
  action.sa_handler = on_signal;  // Without SA_RESTART: calls that block come back.
  for (const int number : {SIGTERM, SIGINT, SIGUSR1}) sigaction(number, &action, nullptr);
  const auto gadget = rigcal::hil::RawGadget::plug_in();
  if (!gadget) {
    std::fprintf(stderr, "usb3_camera_gadget: %s\n", gadget.error().message().c_str());
    return 4;
  }
  rigcal::sim::VirtualCameraOptions options;
  options.identity.manufacturer = "Hikrobot";
  options.identity.model = "MV-CA013-21UC";
  options.identity.serial = "64729929336";  // 00F12345678 on the USB.
  options.identity.device_version = "1.0";
  options.pixel_formats = {"Mono8", "BayerRG8", "Mono12"};
  rigcal::hil::CameraGadget camera(**gadget, options, count > 1 ? words[1] : "");
  running = &camera;
  const auto run = camera.run();
  running = nullptr;
  if (run) return 0;
  std::fprintf(stderr, "usb3_camera_gadget: %s\n", run.error().message().c_str());
  return 4;
}
