#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "simdata/gige/test_pattern.h"
#include "simdata/usb3/usb3_camera.h"
#include "tests/hil/usb3/descriptors.h"
#include "tests/hil/usb3/raw_gadget.h"

namespace rigcal::hil {

/// A virtual USB3 Vision camera with test patterns on the dummy host. `run` answers the host's requests in the thread
/// that calls it; three others serve the control endpoint, the stream, and time with the trigger line.
class CameraGadget {
 public:
  /// `line_value`: the file in which a simulated GPIO line shows its level (gpio-sim's `value`): line 0 of the camera;
  /// empty: none.
  CameraGadget(RawGadget& gadget, const sim::VirtualCameraOptions& options, std::string line_value);
  ~CameraGadget();
  CameraGadget(const CameraGadget&) = delete;
  CameraGadget& operator=(const CameraGadget&) = delete;

  /// Until `stop` (from a signal handler) and a signal.
  Expected<void> run();
  void stop() { is_running_.store(false); }

 private:
  Expected<void> serve(const SetupRequest& request);
  Expected<void> configure();
  void run_control();
  void run_stream();
  void run_time();
  void send(const sim::FrameOrder& frame);
  /// Takes back what the host has not read.
  void flush_stream();
  [[nodiscard]] bool is_line_high() const;

  RawGadget& gadget_;
  UsbNames names_;
  std::mutex mutex_;  ///< Of the camera and the queue.
  std::condition_variable filled_;
  sim::usb3::Usb3Camera camera_;
  std::deque<sim::FrameOrder> queue_;
  sim::TestPattern pattern_;
  std::vector<std::uint8_t> pixels_;
  int line_ = -1;
  bool is_configured_ = false;
  int control_in_ = -1;
  int control_out_ = -1;
  int stream_in_ = -1;
  std::atomic<bool> is_running_{true};
  std::atomic<bool> is_sending_{false};
  std::atomic<bool> is_flushing_{false};
  std::thread control_;
  std::thread stream_;
  std::thread time_;
};

}  // namespace rigcal::hil
