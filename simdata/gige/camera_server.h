#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "simdata/gige/frame_source.h"
#include "simdata/gige/stream_sender.h"
#include "simdata/gige/virtual_camera.h"

namespace rigcal::sim {

/// A camera as the network sees it.
struct ServedCamera {
  VirtualCameraOptions device;
  StreamFaults faults;
  std::shared_ptr<FrameSource> source;
};

struct CameraServerOptions {
  /// Datagrams to this port of any camera's address are pulses of 1 ms on line 0 of all cameras, or on the line whose
  /// name the datagram holds ("Line2"); 0: nobody is asked.
  std::uint16_t trigger_port = 0;
  std::uint64_t seed = 1;
  /// Told of every exposure that a camera sends a frame of, in the server's thread: what a strobe line shows.
  std::function<void(std::size_t camera, const FrameOrder& frame)> on_frame;
};

struct CameraCounts {
  StreamCounts stream;
  std::uint64_t frames = 0;            ///< Exposed.
  std::uint64_t dropped_frames = 0;    ///< Their source was too slow for them.
  std::uint64_t ignored_triggers = 0;  ///< Came too soon after the one before.
  std::uint64_t unsent_packets = 0;    ///< Refused by the system.
  bool is_owned = false;
  bool is_acquiring = false;
  bool is_idle = true;  ///< No frame waits, nor any packet.
};

/// Virtual GigE Vision cameras on the network, each on its own address, served by a thread until this is destroyed:
/// to their hosts that looks as if they had been unplugged.
class CameraServer {
 public:
  /// Errors: an address that this machine does not have, a port that is taken.
  [[nodiscard]] static Expected<std::unique_ptr<CameraServer>> start(std::vector<ServedCamera> cameras,
                                                                     const CameraServerOptions& options = {});
  ~CameraServer();
  CameraServer(const CameraServer&) = delete;
  CameraServer& operator=(const CameraServer&) = delete;

  /// A pulse on all cameras' lines; its edges are CLOCK_MONOTONIC, now or to come. From any thread.
  void pulse(const LinePulse& pulse);
  /// Faults, from any thread, at once.
  void reboot(std::size_t camera);
  void fall_silent(std::size_t camera, std::int64_t until_ns);
  void set_owned_by_other(std::size_t camera, bool owned);
  /// By camera, as of now; from any thread.
  [[nodiscard]] std::vector<CameraCounts> counts() const;

 private:
  class Impl;
  explicit CameraServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rigcal::sim
