#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/v4l2/video_kernel.h"

struct v4l2_buffer;
struct v4l2_format;

namespace rigcal::camera {

/// A camera of Video4Linux as the kernel shows it, with faults: what is answered is what the V4L2 specification says of
/// each call. Its pixels tell which frame they are of.
class FakeVideoKernel final : public VideoKernel {
 public:
  struct Limits {
    std::int32_t least = 0;
    std::int32_t most = 0;
    std::int32_t value = 0;
  };
  // How it is made; to be set before it is used.
  std::string path = "/dev/video7";
  std::string card = "Test Camera";
  std::string serial_number = "V4L2-0815";
  std::vector<std::uint32_t> fourccs;
  std::uint32_t most_width = 640;
  std::uint32_t most_height = 480;
  std::uint32_t padding = 0;  ///< Bytes behind each row.
  std::uint32_t most_buffers = 32;
  std::string driver = "test";
  std::map<std::string, std::string> parameters;  ///< Of the driver.
  /// Of which clock its stamps are, and of which moment of a frame, as the kernel says.
  std::uint32_t stamp_flags;
  bool can_cut = true;
  bool can_set_rate = true;
  std::map<std::uint32_t, Limits> controls;
  /// Another device file of the same name, before this one: another program has it. Empty: none.
  std::string twin;
  int twin_refusals = 0;  ///< How often somebody would have set it up.
  // Faults, at any time.
  int open_answer = 0;   ///< An errno below zero in place of a descriptor.
  bool is_held = false;  ///< Another program streams.
  bool is_error_while_dry = true;
  std::uint32_t skip = 0;  ///< Frames that get lost before the next.
  bool damages_next = false;
  bool shortens_next = false;
  bool breaks_off = false;   ///< Until the stream is stopped.
  bool has_changed = false;  ///< The source, once.
  void unplug();
  void plug_in(const std::string& where);

  FakeVideoKernel();
  [[nodiscard]] static std::uint8_t pixel(std::uint32_t sequence, std::size_t place) {
    return static_cast<std::uint8_t>(7 * sequence + place);
  }
  [[nodiscard]] int open_files() const { return open_; }
  [[nodiscard]] int mapped() const { return mapped_; }

  std::vector<std::string> devices() override;
  std::string serial(const std::string&) override { return serial_number; }
  std::string parameter(const std::string& of, const std::string& name) override {
    const auto it = parameters.find(name);
    return of == driver && it != parameters.end() ? it->second : std::string();
  }
  int open(const std::string& which) override;
  void close(int descriptor) override;
  int control(int descriptor, unsigned long request, void* argument) override;
  void* map(int descriptor, std::size_t bytes, std::int64_t offset) override;
  void unmap(void* memory, std::size_t bytes) override;
  Ready wait(int descriptor, std::int64_t timeout_ns) override;

 private:
  struct Buffer {
    std::vector<std::uint8_t> bytes;
    bool is_queued = false;
    std::uint32_t used = 0;
    std::uint32_t sequence = 0;
    std::uint32_t flags = 0;
    std::int64_t stamp_ns = 0;
  };
  int set_format(v4l2_format& format);
  int describe(v4l2_buffer& buffer);
  int queue(const v4l2_buffer& buffer);
  int take(v4l2_buffer& buffer);
  int answer(unsigned long request, void* argument);
  void fill_due(std::int64_t now_ns);

  mutable std::mutex mutex_;
  bool is_there_ = true;
  int generation_ = 0;  ///< Of descriptors: those of before the camera was unplugged are dead.
  int open_ = 0;
  int mapped_ = 0;
  std::uint32_t fourcc_ = 0;
  std::uint32_t width_ = 320;
  std::uint32_t height_ = 240;
  std::uint32_t left_ = 0;
  std::uint32_t top_ = 0;
  double rate_ = 50.0;
  std::vector<std::unique_ptr<Buffer>> buffers_;
  std::vector<std::unique_ptr<Buffer>> orphans_;
  std::vector<std::size_t> queued_;  ///< In their order.
  std::vector<std::size_t> filled_;
  bool is_streaming_ = false;
  std::int64_t due_ns_ = 0;
  std::uint32_t sequence_ = 0;
};

}  // namespace rigcal::camera
