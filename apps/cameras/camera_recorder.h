#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "apps/cameras/capture_event.h"
#include "apps/cameras/frame_matching.h"
#include "apps/cameras/rig_cameras.h"
#include "core/base/heartbeat.h"
#include "core/base/seconds.h"
#include "core/clocks/device_clock.h"
#include "core/io/frame_files.h"
#include "drivers/net/session_clock.h"

namespace rigcal {

/// How a camera of a running capture does.
struct CaptureCamera {
  std::string sensor;
  std::string state;         ///< One word or two.
  std::string pixel_format;  ///< Of its frames, once it was set up.
  camera::CameraCounters counters;
  std::uint64_t written = 0;           ///< Images on the disk.
  std::uint64_t dropped_by_queue = 0;  ///< Frames that the disk, or packing them, was too slow for.
  std::uint64_t bytes = 0;
  std::size_t most_waiting = 0;    ///< Frames that waited for the disk at once.
  std::int64_t worst_wait_ns = 0;  ///< From when a frame was there until its image was on the disk.
  std::int64_t last_image_ns = 0;  ///< Stamp of the last image on the disk; 0: none yet.
  std::optional<Error> failure;    ///< Its images could not be written any more: it was given up then.
  double frames_per_s = 0.0;       ///< Since the last look.
  /// Of a camera that waits for the pulses of the rig's own line: what became of both.
  std::optional<MatchLedger> matching;
  std::optional<CameraClockFigures> clock;  ///< Likewise, once its clock is mapped by its pulses.
};

/// A camera's frames on their way into a session: one thread takes them, and asks for no memory while it does; another
/// packs and writes them. A camera that is not there is looked for until the end; one whose images cannot be written
/// any more is given free, and says so. Whole frames alone become images. Of a camera that waits for the rig's own
/// pulses each image gets its pulse.
class CameraRecorder {
 public:
  /// How long the end waits for a camera to be free. One that does not answer is left as it is: what was set in it is
  /// known on the disk, and put back at the next start.
  static constexpr auto kMostClosing = std::chrono::milliseconds(1500);
  /// Frames that may wait to be written.
  static constexpr std::size_t kMostWaiting = 16;

  /// Starts at once; `drivers` must outlive the call only. What it gives finishes when it is let go. Errors: the disk.
  [[nodiscard]] static Expected<std::shared_ptr<CameraRecorder>> start(const RigCamera& wanted, CameraDrivers& drivers,
                                                                       const std::string& session,
                                                                       const net::ClockReading& session_start);
  ~CameraRecorder() = default;
  CameraRecorder(const CameraRecorder&) = delete;
  CameraRecorder& operator=(const CameraRecorder&) = delete;

  /// A pulse on the rig's trigger line began, or ended, with the time of that edge; in the order of time. The camera
  /// takes the edge at which it exposes. From any thread; returns at once.
  void add_pulse(const TriggerPulse& pulse) { add_edge(pulse, false); }
  void end_pulse(const TriggerPulse& pulse) { add_edge(pulse, true); }
  /// Whether images are wanted from now on, of a camera that is triggered by software: then it is told as often as it
  /// is to send. Not at first. From any thread; returns at once.
  void want_images(bool are_wanted) { are_wanted_ = are_wanted; }
  /// No frames are taken any more; returns at once.
  void stop();
  /// Waits until the camera is free, at most kMostClosing after `stop`, and until what it sent is written.
  void finish();
  /// Whether any recorder left a camera: then a thread still waits for its answer, and the program must be left without
  /// tidying up under it.
  [[nodiscard]] static bool has_left_a_camera();

  [[nodiscard]] CaptureCamera status() const;
  /// Since the last call.
  [[nodiscard]] std::vector<CaptureEvent> take_events();
  /// Of the thread that takes frames, and of the one that writes them.
  [[nodiscard]] const Heartbeat& taking() const { return taking_; }
  [[nodiscard]] const Heartbeat& writing() const { return writing_; }

 private:
  struct Waiting {
    camera::Frame frame;
    FrameRecord record;
    FrameSighting sighting;
  };

  CameraRecorder(RigCamera wanted, std::unique_ptr<camera::Camera> camera, std::string folder, FrameTable table,
                 const net::ClockReading& session_start);
  void take();
  /// Until the camera streams, or the end.
  bool prepare_camera();
  void take_frames();
  std::int64_t tell_camera();
  void queue(camera::Frame frame);
  void write();
  /// As an image; its line of the table with the name of the file.
  Expected<FrameRecord> write(const Waiting& waiting);
  Expected<void> list_matched();
  void expect_pulses(const camera::CameraSetup& setup);
  void add_edge(const TriggerPulse& pulse, bool is_falling);
  [[nodiscard]] std::int64_t now_ns() const;
  void tell(std::string text, bool is_gap);
  void give_up(const Error& error);
  [[nodiscard]] bool has_failed() const;
  void set_state(const char* state);
  void publish();

  RigCamera wanted_;
  std::unique_ptr<camera::Camera> camera_;
  std::string folder_;
  FrameTable table_;
  net::SessionClock clock_;
  DeviceClock device_clock_;
  std::optional<double> exposure_us_;
  camera::HostStamp host_stamp_ = camera::HostStamp::arrival_start;
  std::atomic<bool> is_stopped_{false};
  std::atomic<bool> are_wanted_{false};
  std::int64_t image_due_ns_ = 0;  ///< CLOCK_MONOTONIC: when a camera that is told is told again.
  Heartbeat taking_;
  Heartbeat writing_;

  mutable std::mutex mutex_;  ///< Of what follows.
  std::condition_variable changed_;
  std::vector<Waiting> waiting_;               ///< A ring of kMostWaiting places.
  std::optional<FrameMatching> new_matching_;  ///< Of the camera as it was set up last, for the writing thread.
  bool expects_pulses_ = false;
  std::vector<TriggerPulse> pulses_;  ///< Not yet taken to the matching.
  bool has_dropped_pulses_ = false;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  bool has_ended_ = false;  ///< No more frames.
  bool is_free_ = false;    ///< The camera is closed.
  std::optional<SteadyClock::time_point> stopped_at_;
  CaptureCamera status_;
  std::vector<CaptureEvent> events_;
  std::string last_trouble_;

  std::optional<FrameMatching> matching_;  ///< This and what follows: of the writing thread alone.
  std::vector<TriggerPulse> taken_pulses_;

  std::thread taker_;
  std::thread writer_;
};

}  // namespace rigcal
