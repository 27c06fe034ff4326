#pragma once

#include <arv.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "drivers/camera/aravis/buffer_image.h"
#include "drivers/net/udp_socket.h"
#include "simdata/gige/camera_server.h"
#include "tests/support/served_camera.h"

/// Aravis as the host of virtual cameras.
namespace rigcal::sim {

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
template <class T>
using Held = std::unique_ptr<T, Unref>;

/// What Aravis says went wrong, for one call.
class Problem {
 public:
  Problem() = default;
  ~Problem() { g_clear_error(&error_); }
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;
  GError** operator&() {  // NOLINT: as the library wants it.
    g_clear_error(&error_);
    return &error_;
  }
  [[nodiscard]] std::string text() const { return error_ == nullptr ? "" : error_->message; }
  [[nodiscard]] bool is_none() const { return error_ == nullptr; }

 private:
  GError* error_ = nullptr;
};

/// A test pattern on an address of the loopback network.
inline ServedCamera served_camera(std::uint8_t last, const char* serial = "00F12345678") {
  return served_camera_at(7, last, serial);
}

/// A socket of the host.
inline Expected<net::UdpSocket> host_socket() {
  net::UdpOptions options;
  options.local = {{127, 0, 0, 1}, 0};
  options.broadcast = true;
  return net::UdpSocket::open(options);
}

inline std::string address_of(const ServedCamera& camera) { return to_string(camera.device.identity.ip); }

inline Held<ArvCamera> open_camera(const std::string& address, Problem& problem) {
  return Held<ArvCamera>(arv_camera_new(address.c_str(), &problem));
}

/// A frame as Aravis gives it; `bytes` are the pixels alone.
struct Frame {
  ArvBufferStatus status = ARV_BUFFER_STATUS_UNKNOWN;
  std::uint64_t id = 0;
  std::uint64_t device_ns = 0;
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> bytes;
};

struct HostOptions {
  bool resend = true;
  unsigned packet_timeout_us = 20'000;
  unsigned frame_retention_us = 1'000'000;  ///< Long: the tests' machine may be busy with something else.
  std::size_t buffers = 30;
};

/// A running acquisition.
class Stream {
 public:
  explicit Stream(ArvCamera* camera, const HostOptions& options = {}) : camera_(camera) {
    Problem problem;
    stream_.reset(arv_camera_create_stream(camera, nullptr, nullptr, &problem));
    EXPECT_TRUE(problem.is_none()) << problem.text();
    if (!stream_) return;
    g_object_set(stream_.get(), "packet-resend",
                 options.resend ? ARV_GV_STREAM_PACKET_RESEND_ALWAYS : ARV_GV_STREAM_PACKET_RESEND_NEVER,
                 "packet-timeout", options.packet_timeout_us, "frame-retention", options.frame_retention_us, nullptr);
    const guint payload = arv_camera_get_payload(camera, &problem);
    EXPECT_TRUE(problem.is_none()) << problem.text();
    for (std::size_t i = 0; i < options.buffers; ++i)
      arv_stream_push_buffer(stream_.get(), arv_buffer_new(payload, nullptr));
  }
  ~Stream() { stop(); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  void start() {
    Problem problem;
    arv_camera_start_acquisition(camera_, &problem);
    EXPECT_TRUE(problem.is_none()) << problem.text();
    is_running_ = true;
  }
  void stop() {
    if (!is_running_) return;
    is_running_ = false;
    arv_camera_stop_acquisition(camera_, nullptr);
  }
  ArvStream* get() { return stream_.get(); }

  /// Calls `use` with the next buffer, or not at all where none comes in time.
  template <class Use>
  bool next(std::chrono::milliseconds timeout, const Use& use) {
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream_.get(), static_cast<guint64>(timeout.count()) * 1000);
    if (buffer == nullptr) return false;
    use(buffer);
    arv_stream_push_buffer(stream_.get(), buffer);
    return true;
  }
  /// Waits for a frame; one without bytes and status where none comes.
  Frame frame(std::chrono::milliseconds timeout = std::chrono::milliseconds(2000)) {
    Frame frame;
    next(timeout, [&frame](ArvBuffer* buffer) { frame = read(buffer); });
    return frame;
  }
  static Frame read(ArvBuffer* buffer) {
    Frame frame;
    frame.status = arv_buffer_get_status(buffer);
    frame.id = arv_buffer_get_frame_id(buffer);
    if (frame.status != ARV_BUFFER_STATUS_SUCCESS) return frame;
    frame.device_ns = arv_buffer_get_timestamp(buffer);
    frame.width = arv_buffer_get_image_width(buffer);
    frame.height = arv_buffer_get_image_height(buffer);
    std::size_t size = 0;
    const auto* data = camera::image_data(buffer, &size);
    frame.bytes.assign(data, data + size);
    return frame;
  }

 private:
  ArvCamera* camera_;
  Held<ArvStream> stream_;
  bool is_running_ = false;
};

/// Numbers of frames from their ids of 16 bits, the first of which was `first`.
class FrameNumbers {
 public:
  explicit FrameNumbers(std::uint16_t first = 1) : last_id_(first) {}
  std::uint64_t of(std::uint64_t id) {
    // 0 is no id, so a round has 65535.
    const std::uint64_t step = (id + 65535 - last_id_) % 65535;
    if (step > 32767) return number_ - (65535 - step);
    number_ += step;
    last_id_ = id;
    return number_;
  }

 private:
  std::uint64_t last_id_;
  std::uint64_t number_ = 0;
};

/// The test pattern of a frame of the whole sensor.
inline std::vector<std::uint8_t> pattern_of(std::uint64_t number, int width, int height,
                                            const char* format = "BayerRG8") {
  TestPattern pattern;
  FrameWish wish;
  wish.number = number;
  wish.pixel_format = format;
  wish.width = width;
  wish.height = height;
  std::vector<std::uint8_t> image;
  pattern.make(wish, image);
  return image;
}

}  // namespace rigcal::sim
