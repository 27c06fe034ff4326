#pragma once

#include <string>
#include <vector>

namespace rigcal::camera {

/// A USB3 Vision camera as the kernel sees it, also where nobody may open it.
struct UsbCamera {
  std::string vendor;
  std::string model;
  std::string serial;
  std::string node;         ///< Its device file, "/dev/bus/usb/002/003".
  bool is_allowed = false;  ///< This user may read and write the device file.
};

/// Those that are plugged in: a device with an interface of class EF, subclass 05 (USB3 Vision 1.0.1, 3.1.1). Reads
/// `devices` as sysfs lays it out; what cannot be read is left out.
[[nodiscard]] std::vector<UsbCamera> list_usb_cameras(const std::string& devices = "/sys/bus/usb/devices",
                                                      const std::string& nodes = "/dev/bus/usb");

}  // namespace rigcal::camera
