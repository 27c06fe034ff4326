#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/rig/rig.h"
#include "simdata/camera/rendered_frames.h"
#include "simdata/gige/camera_server.h"
#include "simdata/live/live_incident.h"
#include "simdata/packets/run_stream.h"
#include "simdata/rig/sim_rig.h"

namespace rigcal::sim {

/// How the cameras of a rig are served on the network.
struct LiveCameraOptions {
  bool is_test_pattern = false;    ///< Moving stripes at any rate instead of the scene.
  std::uint16_t trigger_port = 0;  ///< Pulses come from there instead of from the run, see CameraServerOptions.
  StreamFaults faults;
  bool can_resend = true;
  double answer_delay_s = 0.0;
};

/// What became of one of them.
struct LiveCameraSummary {
  std::string name;
  gige::Ipv4 ip{};
  CameraCounts counts;
};

/// The cameras of a rig whose driver is `aravis` and that have intrinsics, as GigE Vision devices: each on its own
/// address, with the images of the run and its trigger's pulses on line 0.
class LiveCameras {
 public:
  /// References must outlive this. Errors: what simulated_cameras refuses, a pixel format that has no number on the
  /// wire, two cameras with one address, what CameraServer refuses.
  [[nodiscard]] static Expected<std::unique_ptr<LiveCameras>> start(const Scene& scene, const RayCaster& caster,
                                                                    const Rig& rig, const SimulatedRig& simulated,
                                                                    const RunOptions& run,
                                                                    const LiveCameraOptions& options,
                                                                    std::vector<Incident> incidents);

  /// The run's time 0, CLOCK_MONOTONIC, how fast it goes, and whether it begins again at its end.
  void begin(std::int64_t start_ns, double speed, bool repeat);
  /// To be called all the time: gives the pulses that come next, lets happen what is to happen.
  void tick(std::int64_t now_ns);
  [[nodiscard]] bool is_any_acquiring() const;
  /// Whether all frames that were exposed are on the network.
  [[nodiscard]] bool is_idle() const;
  [[nodiscard]] std::vector<LiveCameraSummary> summary() const;

 private:
  class Source;
  /// When the run began, for the sources; they live in the server's thread.
  struct Clock {
    std::atomic<std::int64_t> start_ns = INT64_MAX;
    std::atomic<double> speed = 1.0;
  };
  struct Unit {
    std::string name;
    gige::Ipv4 ip{};
  };
  struct Event {
    Incident incident;
    std::size_t camera = 0;
    bool has_begun = false;
    bool has_ended = false;
  };
  LiveCameras() = default;
  void give_pulses(std::int64_t now_ns);
  void happen(std::int64_t now_ns);

  std::vector<Unit> units_;
  std::vector<Event> events_;
  std::vector<ExposurePulse> pulses_;
  double duration_s_ = 0.0;
  double pulse_s_ = 1e-3;
  bool has_own_pulses_ = true;
  bool repeats_ = false;
  std::uint64_t given_ = 0;  ///< Pulses, over all repetitions of the run.
  std::int64_t switched_on_ns_ = 0;
  std::int64_t looked_ns_ = INT64_MIN;  ///< At who is wanted.
  std::shared_ptr<Clock> clock_ = std::make_shared<Clock>();
  std::shared_ptr<RenderedFrames> frames_;
  std::unique_ptr<CameraServer> server_;  ///< Last: its sources use all of the others.
};

}  // namespace rigcal::sim
