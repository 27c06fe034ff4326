#include "tests/hil/usb3/camera_gadget.h"

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <utility>

#include "simdata/usb3/stream_packet.h"

namespace rigcal::hil {
namespace {

constexpr std::size_t most_waiting = 4;  // Frames that the host has not fetched; more are dropped, as cameras do.
constexpr auto time_step = std::chrono::microseconds(500);
constexpr std::uint8_t get_descriptor = 0x06;
constexpr std::uint8_t set_configuration = 0x09;
constexpr std::uint8_t get_configuration = 0x08;
constexpr std::uint8_t get_status = 0x00;
constexpr std::uint8_t set_interface = 0x0B;

std::int64_t now_ns() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

/// The USB tells the serial number in hexadecimal where the camera's own registers have it in decimal: so do cameras of
/// FLIR, and those who know one by either must not take it for two.
UsbNames names_of(const gige::DeviceIdentity& identity) {
  std::array<char, 24> serial{};
  std::snprintf(serial.data(), serial.size(), "%011llX", std::strtoull(identity.serial.c_str(), nullptr, 10));
  const std::string text = serial.data();
  return {identity.manufacturer, identity.model, text, "2BDF" + text.substr(text.size() - 8)};
}

}  // namespace

CameraGadget::CameraGadget(RawGadget& gadget, const sim::VirtualCameraOptions& options, std::string line_value)
    : gadget_(gadget), names_(names_of(options.identity)), camera_(options, now_ns()) {
  if (!line_value.empty()) line_ = open(line_value.c_str(), O_RDONLY | O_CLOEXEC);
}

CameraGadget::~CameraGadget() {
  stop();
  filled_.notify_all();
  for (std::thread* thread : {&control_, &stream_, &time_}) {
    if (!thread->joinable()) continue;
    // Again and again: a signal may come just before the call that it is to end.
    std::atomic<bool> is_joined{false};
    std::thread caller([&is_joined, handle = thread->native_handle()] {
      while (!is_joined.load()) {
        pthread_kill(handle, SIGUSR1);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    });
    thread->join();
    is_joined.store(true);
    caller.join();
  }
  if (line_ >= 0) close(line_);
}

Expected<void> CameraGadget::run() {
  while (is_running_.load()) {
    const auto request = gadget_.next();
    if (!request) return request.error();
    if (!*request) continue;
    if (auto served = serve(**request); !served) return served;
  }
  return {};
}

Expected<void> CameraGadget::serve(const SetupRequest& request) {
  const bool is_standard = (request.type & 0x60U) == 0;
  if (is_standard && request.request == get_descriptor) {
    const auto bytes =
        descriptor(static_cast<std::uint8_t>(request.value >> 8U), static_cast<std::uint8_t>(request.value), names_);
    if (bytes) {
      gadget_.answer(request, *bytes);
    } else {
      gadget_.refuse();
    }
  } else if (is_standard && request.request == set_configuration) {
    if (auto configured = configure(); !configured) return configured;
    gadget_.acknowledge(request);
  } else if (is_standard && (request.request == get_configuration || request.request == get_status)) {
    gadget_.answer(request, std::vector<std::uint8_t>(request.length, request.request == get_configuration ? 1 : 0));
  } else if (is_standard && request.request == set_interface) {
    gadget_.acknowledge(request);
  } else {
    gadget_.refuse();
  }
  return {};
}

Expected<void> CameraGadget::configure() {
  if (std::exchange(is_configured_, true)) return {};
  for (const auto& [address, endpoint] : {std::pair{kControlIn, &control_in_}, std::pair{kControlOut, &control_out_},
                                          std::pair{kStreamIn, &stream_in_}}) {
    const auto enabled = gadget_.enable(endpoint_descriptor(address));
    if (!enabled) return enabled.error();
    *endpoint = *enabled;
  }
  gadget_.set_configured();
  control_ = std::thread([this] { run_control(); });
  stream_ = std::thread([this] { run_stream(); });
  time_ = std::thread([this] { run_time(); });
  return {};
}

void CameraGadget::run_control() {
  while (is_running_.load()) {
    const auto packet = gadget_.read(control_out_, sim::usb3::kMaxControlBytes);
    if (!packet) {
      std::this_thread::sleep_for(time_step);  // Nobody is there, or a signal came.
      continue;
    }
    std::vector<std::uint8_t> answer;
    bool was_open = false;
    bool is_open = false;
    {
      const std::lock_guard lock(mutex_);
      was_open = camera_.may_send();
      answer = camera_.receive(now_ns(), *packet);
      is_open = camera_.may_send();
    }
    if (was_open && !is_open) flush_stream();
    if (!answer.empty()) static_cast<void>(gadget_.write(control_in_, answer));
  }
}

void CameraGadget::flush_stream() {
  is_flushing_.store(true);
  {
    const std::lock_guard lock(mutex_);
    queue_.clear();
  }
  while (is_sending_.load() && is_running_.load()) {
    pthread_kill(stream_.native_handle(), SIGUSR1);
    std::this_thread::sleep_for(time_step);
  }
  is_flushing_.store(false);
}

void CameraGadget::run_stream() {
  while (is_running_.load()) {
    std::unique_lock lock(mutex_);
    filled_.wait_for(lock, std::chrono::milliseconds(100), [this] { return !queue_.empty() || !is_running_.load(); });
    if (queue_.empty()) continue;
    const sim::FrameOrder frame = std::move(queue_.front());
    queue_.pop_front();
    is_sending_.store(true);
    lock.unlock();
    send(frame);
    is_sending_.store(false);
  }
}

void CameraGadget::send(const sim::FrameOrder& frame) {
  if (!pattern_.make(frame.wish(), pixels_)) return;
  const auto leader = sim::usb3::encode_leader(frame, sim::usb3::Usb3Camera::stamp_ns(frame));
  const auto trailer = sim::usb3::encode_trailer(frame);
  for (const ByteView part : {ByteView(leader), ByteView(pixels_), ByteView(trailer)})
    if (is_flushing_.load() || !gadget_.write(stream_in_, part)) return;
}

bool CameraGadget::is_line_high() const {
  char level = '0';
  return line_ >= 0 && pread(line_, &level, 1, 0) == 1 && level == '1';
}

void CameraGadget::run_time() {
  std::vector<sim::FrameOrder> frames;
  bool was_high = false;
  std::int64_t pulses = 0;
  while (is_running_.load()) {
    std::this_thread::sleep_for(time_step);
    const bool is_high = is_line_high();
    const std::int64_t now = now_ns();
    const std::lock_guard lock(mutex_);
    // When it falls is not known yet: only rising edges release this camera.
    if (is_high && !was_high) camera_.pulse({0, now, now + 1'000'000, pulses++});
    was_high = is_high;
    frames.clear();
    camera_.tick(now, frames);
    for (sim::FrameOrder& frame : frames)
      if (queue_.size() < most_waiting) queue_.push_back(std::move(frame));
    if (!frames.empty()) filled_.notify_one();
  }
}

}  // namespace rigcal::hil
