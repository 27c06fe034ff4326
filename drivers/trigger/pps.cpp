#include "drivers/trigger/pps.h"

#include <fcntl.h>
#include <linux/pps.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/base/seconds.h"

namespace rigcal::trigger {
namespace {

namespace fs = std::filesystem;

Error pps_error(const std::string& device, int refusal) {
  if (refusal == EACCES || refusal == EPERM)
    return system_error(
        "this user may not read the PPS device", device,
        "install the rules of rigcal (rigcal doctor says how), and: sudo adduser $USER plugdev (then log in again)");
  if (refusal == ENOENT || refusal == ENODEV || refusal == ENXIO) {
    std::string there = "there is none";
    for (const std::string& known : list_pps())
      there = (there == "there is none" ? "there are: " : there + ", ") + known;
    return system_error("there is no such PPS device", device,
                        there + "; load the driver of the input (pps-gpio, or ldattach PPS for a serial port)");
  }
  return system_error(std::string("the PPS device cannot be used: ") + std::strerror(refusal), device,
                      "see whether it gives pulses: sudo ppstest " + device);
}

/// What the device saw last, waited for at most that long: 0, or an errno.
int fetch(int descriptor, std::int64_t timeout_ns, pps_fdata& fetched) {
  fetched = {};
  fetched.timeout.sec = timeout_ns / ns_per_second;
  fetched.timeout.nsec = static_cast<std::int32_t>(timeout_ns % ns_per_second);
  return ioctl(descriptor, PPS_FETCH, &fetched) == 0 ? 0 : errno;
}

}  // namespace

std::vector<std::string> list_pps() {
  std::vector<std::string> devices;
  std::error_code error;
  for (fs::directory_iterator entry("/dev", error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with("pps") && name.size() > 3 && std::isdigit(static_cast<unsigned char>(name[3])) != 0)
      devices.push_back(entry->path().string());
  }
  std::sort(devices.begin(), devices.end());
  return devices;
}

Expected<PpsDevice> PpsDevice::open(const std::string& device) {
  const std::string path = device.starts_with("/") ? device : "/dev/" + device;
  FileDescriptor file(::open(path.c_str(), O_RDWR | O_CLOEXEC));
  if (!file.is_open()) return pps_error(path, errno);
  const int descriptor = file.get();
  PpsDevice opened(path, std::move(file));
  int abilities = 0;
  if (ioctl(descriptor, PPS_GETCAP, &abilities) != 0) return pps_error(path, errno);
  if ((abilities & PPS_CAPTUREASSERT) == 0)
    return system_error("the PPS device does not see rising edges", path, "wire it to another input");
  pps_kparams parameters{};
  if (ioctl(descriptor, PPS_GETPARAMS, &parameters) != 0) return pps_error(path, errno);
  // To change this needs CAP_SYS_TIME, so it is left as it is where it does already what is needed.
  if ((parameters.mode & PPS_CAPTUREASSERT) == 0) {
    parameters.api_version = PPS_API_VERS;
    parameters.mode |= PPS_CAPTUREASSERT | PPS_TSFMT_TSPEC;
    if (ioctl(descriptor, PPS_SETPARAMS, &parameters) != 0) return pps_error(path, errno);
  }
  pps_fdata before{};
  if (const int refusal = fetch(descriptor, 0, before); refusal != 0) return pps_error(path, refusal);
  opened.count_ = PpsCount(before.info.assert_sequence);
  return opened;
}

Expected<std::optional<PpsPulse>> PpsDevice::next(std::int64_t timeout_ns) {
  pps_fdata fetched{};
  const int refusal = fetch(file_.get(), timeout_ns, fetched);
  if (refusal == ETIMEDOUT) {
    // The kernel lets a device that was taken away time out for ever.
    if (!is_still_there(file_.get(), device_)) return pps_error(device_, ENODEV);
    return std::optional<PpsPulse>();
  }
  if (refusal == EINTR) return std::optional<PpsPulse>();
  if (refusal != 0) return pps_error(device_, refusal);
  const std::uint32_t sequence = fetched.info.assert_sequence;
  const std::optional<std::uint32_t> missed = count_.missed_before(sequence);
  if (!missed) return std::optional<PpsPulse>();
  const pps_ktime& rose = fetched.info.assert_tu;
  return std::optional<PpsPulse>(PpsPulse{sequence, *missed, rose.sec * ns_per_second + rose.nsec});
}

bool is_still_there(int descriptor, const std::string& path) {
  struct stat held {};
  struct stat named {};
  return fstat(descriptor, &held) == 0 && stat(path.c_str(), &named) == 0 && held.st_dev == named.st_dev &&
         held.st_ino == named.st_ino && held.st_rdev == named.st_rdev;
}

}  // namespace rigcal::trigger
