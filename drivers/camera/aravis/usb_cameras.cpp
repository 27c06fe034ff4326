#include "drivers/camera/aravis/usb_cameras.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace rigcal::camera {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  line.resize(std::min<std::size_t>(line.size(), 256));
  return line;
}

int number_in(const fs::path& file) { return std::atoi(first_line(file).c_str()); }

/// Its interfaces are folders named after it: "2-1:1.0" of "2-1".
bool is_vision(const fs::path& device) {
  std::error_code error;
  for (fs::directory_iterator entries(device, error), end; !error && entries != end; entries.increment(error)) {
    const std::string name = entries->path().filename().string();
    if (name.find(':') == std::string::npos) continue;
    if (first_line(entries->path() / "bInterfaceClass") == "ef" &&
        first_line(entries->path() / "bInterfaceSubClass") == "05") {
      return true;
    }
  }
  return false;
}

}  // namespace

std::vector<UsbCamera> list_usb_cameras(const std::string& devices, const std::string& nodes) {
  std::vector<UsbCamera> cameras;
  std::error_code error;
  for (fs::directory_iterator entries(devices, error), end; !error && entries != end; entries.increment(error)) {
    const fs::path& device = entries->path();
    if (device.filename().string().find(':') != std::string::npos || !is_vision(device)) continue;
    UsbCamera camera;
    camera.vendor = first_line(device / "manufacturer");
    camera.model = first_line(device / "product");
    camera.serial = first_line(device / "serial");
    char place[32];
    std::snprintf(place, sizeof place, "%03d/%03d", number_in(device / "busnum"), number_in(device / "devnum"));
    camera.node = (fs::path(nodes) / place).string();
    camera.is_allowed = access(camera.node.c_str(), R_OK | W_OK) == 0;
    cameras.push_back(std::move(camera));
  }
  std::sort(cameras.begin(), cameras.end(), [](const UsbCamera& a, const UsbCamera& b) { return a.node < b.node; });
  return cameras;
}

}  // namespace rigcal::camera
