#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>

#include "drivers/camera/v4l2/video_kernel.h"

namespace rigcal::camera {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  line.resize(std::min<std::size_t>(line.size(), 128));
  return line;
}

class SystemKernel final : public VideoKernel {
 public:
  std::vector<std::string> devices() override {
    std::vector<std::string> paths;
    std::error_code error;
    for (fs::directory_iterator entries("/dev", error), end; !error && entries != end; entries.increment(error)) {
      if (entries->path().filename().string().starts_with("video")) paths.push_back(entries->path().string());
    }
    std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
      return a.size() != b.size() ? a.size() < b.size() : a < b;  // video2 before video10.
    });
    return paths;
  }
  std::string serial(const std::string& path) override {
    // The device of a camera on the USB is an interface; the folder above it is the camera.
    std::error_code error;
    const fs::path node = fs::canonical(path, error).filename();
    const fs::path device = fs::canonical(fs::path("/sys/class/video4linux") / node / "device", error);
    if (error) return {};
    return first_line(device.parent_path() / "serial");
  }
  std::string parameter(const std::string& driver, const std::string& name) override {
    return first_line(fs::path("/sys/module") / driver / "parameters" / name);
  }
  int open(const std::string& path) override {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return descriptor < 0 ? -errno : descriptor;
  }
  void close(int descriptor) override { ::close(descriptor); }
  int control(int descriptor, unsigned long request, void* argument) override {
    while (ioctl(descriptor, request, argument) != 0) {
      if (errno != EINTR) return -errno;
    }
    return 0;
  }
  void* map(int descriptor, std::size_t bytes, std::int64_t offset) override {
    void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, offset);
    return memory == MAP_FAILED ? nullptr : memory;
  }
  void unmap(void* memory, std::size_t bytes) override { munmap(memory, bytes); }
  Ready wait(int descriptor, std::int64_t timeout_ns) override {
    pollfd asked{descriptor, POLLIN | POLLPRI, 0};
    // Rounded up: a wait of less than a millisecond is none otherwise.
    const auto timeout_ms = static_cast<int>(std::min<std::int64_t>((timeout_ns + 999'999) / 1'000'000, 1'000'000));
    if (poll(&asked, 1, timeout_ms) <= 0) return {};
    const auto has = [&asked](int bits) { return (asked.revents & bits) != 0; };
    return {has(POLLIN), has(POLLPRI), has(POLLERR), has(POLLHUP | POLLNVAL)};
  }
};

}  // namespace

std::shared_ptr<VideoKernel> system_video_kernel() { return std::make_shared<SystemKernel>(); }

}  // namespace rigcal::camera
