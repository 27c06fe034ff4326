#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "apps/calibration/panorama.h"
#include "apps/recording/cell_sink.h"
#include "apps/recording/stop_image_cache.h"
#include "core/pipeline/incremental_calibration.h"

namespace rigcal {

/// What is known so far in a capture that calibrates as it goes.
struct LiveEstimates {
  std::vector<StopEstimate> estimates;  ///< In order; where stops came faster than they were solved, of the later ones.
  int waiting = 0;                      ///< Stops that are not solved yet.
  std::string trouble;                  ///< Why the last attempt gave nothing; empty where it did.
  int left_out = 0;                     ///< Stops that came when there was no room for more.
};

/// What a picture of the capture is made from, after the last estimate.
struct LiveView {
  Panorama panorama;
  std::vector<Stop> stops;
  CameraScene scene;  ///< Poses of the stops and the LiDARs' edges.
};

/// What a capture that calibrates as it goes has in the end.
struct LiveCells {
  LidarRecording lidar;
  std::shared_ptr<StopImageCache> images;  ///< That were read already.
  int left_out = 0;                        ///< Stops that are not among them, as there was no room for more.
};

/// Solves the stops of a capture as they come, in a thread of low priority of its own: neither the recorder nor whoever
/// finds the stops waits for it. Between its estimates it reads the images of the stops that are over. A capture may go
/// on for days: from the first stop for which there is no room on, it leaves all out.
class LiveCalibration {
 public:
  /// What is kept of the stops at most: some 80 of four LiDARs, which have 25 to 30 MB each. A turntable has done its
  /// turns long before.
  static constexpr std::size_t kMostBytes = std::size_t{2} << 30U;
  /// What to say where `left_out` is more than 0.
  static constexpr const char* kLeftOutText =
      "no further stops are solved as it goes, as those so far take 2 GB of memory: they are recorded, and afterwards "
      "rigcal calibrate SESSION solves all";

  /// Guesses are the rig file's. `session`: where the images come to lie; empty: none do. `with_view`: somebody will
  /// ask for it.
  LiveCalibration(const Rig& rig, const Requirement& goal, std::string session = {}, bool with_view = false,
                  std::size_t most_bytes = kMostBytes);
  /// Gives up what it is at.
  ~LiveCalibration();
  LiveCalibration(const LiveCalibration&) = delete;
  LiveCalibration& operator=(const LiveCalibration&) = delete;

  /// Where the points of the stops go.
  [[nodiscard]] StopSink& sink() { return sink_; }
  [[nodiscard]] LiveEstimates estimates() const;
  /// Null before the first estimate, and where nobody wanted it.
  [[nodiscard]] std::shared_ptr<const LiveView> view() const;
  [[nodiscard]] const Requirement& goal() const { return goal_; }
  /// All LiDARs are as sure as was asked for.
  [[nodiscard]] bool has_reached_goal() const;
  /// Gives up what it is at; all stops. To be called once, when the sink gets nothing more.
  [[nodiscard]] LiveCells finish();

 private:
  void take(CalibrationStop stop);
  void restart();
  void run();
  void solve();
  void read_images();

  Rig rig_;
  Requirement goal_;
  std::string session_;
  bool with_view_;
  std::size_t most_bytes_;
  std::shared_ptr<StopImageCache> images_ = std::make_shared<StopImageCache>();
  CellSink sink_;

  mutable std::mutex mutex_;  ///< Of what follows.
  std::condition_variable changed_;
  std::deque<CalibrationStop> waiting_;
  std::size_t bytes_ = 0;  ///< Of all stops that are kept.
  int solving_ = 0;        ///< Stops that are no longer among these and not solved yet.
  LiveEstimates told_;
  std::shared_ptr<const LiveView> view_;
  bool is_over_ = false;
  bool is_anew_ = false;
  std::stop_source stop_;  ///< Of the estimate that is under way.

  IncrementalCalibration calibration_;  ///< Of the thread, then of `finish`.
  std::thread thread_;
};

}  // namespace rigcal
