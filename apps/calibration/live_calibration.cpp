#include "apps/calibration/live_calibration.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "apps/recording/recording.h"
#include "apps/recording/rig_lidars.h"
#include "apps/recording/still_images.h"

namespace rigcal {
namespace {

constexpr int background_niceness = 15;

CellOptions cells_for_result() {
  CellOptions options;
  options.keep_thinned = true;  // for the map, as `calibrate` does
  return options;
}

std::size_t bytes_of(const CalibrationStop& stop) {
  std::size_t bytes = 0;
  for (const PatchCells& patch : stop.patches)
    bytes += (patch.cells.size() + patch.pieces.size()) * sizeof(Cell) + patch.thinned.size() * sizeof(Point);
  return bytes;
}

IncrementalCalibration begin(const Rig& rig, const Requirement& goal) {
  IncrementalOptions options;
  options.goal = goal;
  return {rig, lidar_sensors(rig), lidar_guesses(rig), options};
}

std::shared_ptr<const LiveView> make_view(const Rig& rig, const IncrementalCalibration& calibration,
                                          const std::stop_token& stop) {
  auto view = std::make_shared<LiveView>();
  const LidarSolution& solved = *calibration.solution();
  const LidarRecording& recording = calibration.recording();
  view->panorama = find_panorama(recording, solved.state, solved.start.stop_known, solved.start.lidar_known);
  view->stops = recording.stops;
  const bool has_camera =
      std::any_of(rig.sensors.begin(), rig.sensors.end(), [](const Sensor& s) { return !s.is_lidar(); });
  if (has_camera) view->scene = make_camera_scene(rig, recording, solved, stop);
  return stop.stop_requested() ? nullptr : view;
}

}  // namespace

LiveCalibration::LiveCalibration(const Rig& rig, const Requirement& goal, std::string session, bool with_view,
                                 std::size_t most_bytes)
    : rig_(rig),
      goal_(goal),
      session_(std::move(session)),
      with_view_(with_view),
      most_bytes_(most_bytes),
      sink_(
          rig_, cells_for_result(), [this](CalibrationStop stop) { take(std::move(stop)); }, [this] { restart(); }),
      calibration_(begin(rig_, goal_)),
      thread_([this] { run(); }) {}

LiveCalibration::~LiveCalibration() {
  if (thread_.joinable()) static_cast<void>(finish());
}

LiveEstimates LiveCalibration::estimates() const {
  const std::lock_guard lock(mutex_);
  LiveEstimates out = told_;
  out.waiting = static_cast<int>(waiting_.size()) + solving_;
  return out;
}

std::shared_ptr<const LiveView> LiveCalibration::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

bool LiveCalibration::has_reached_goal() const {
  const std::lock_guard lock(mutex_);
  return waiting_.empty() && !told_.estimates.empty() && told_.estimates.back().reached;
}

LiveCells LiveCalibration::finish() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    stop_.request_stop();
  }
  changed_.notify_all();
  thread_.join();
  if (is_anew_) calibration_ = begin(rig_, goal_);
  for (CalibrationStop& stop : waiting_) calibration_.add_stop(std::move(stop));
  waiting_.clear();
  return {calibration_.take_recording(), std::move(images_), told_.left_out};
}

void LiveCalibration::take(CalibrationStop stop) {
  {
    const std::lock_guard lock(mutex_);
    const std::size_t bytes = bytes_of(stop);
    if (told_.left_out > 0 || bytes > most_bytes_ - bytes_) {
      ++told_.left_out;
      return;
    }
    bytes_ += bytes;
    waiting_.push_back(std::move(stop));
  }
  changed_.notify_all();
}

void LiveCalibration::restart() {
  const std::lock_guard lock(mutex_);
  waiting_.clear();
  bytes_ = 0;
  told_ = {};
  view_.reset();
  solving_ = 0;
  is_anew_ = true;
  stop_.request_stop();
}

void LiveCalibration::run() {
  // Threads that this one begins inherit it.
  static_cast<void>(::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), background_niceness));
  while (true) {
    std::deque<CalibrationStop> stops;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return is_over_ || !waiting_.empty(); });
      if (is_over_) return;
      stops.swap(waiting_);
      solving_ = static_cast<int>(stops.size());
      stop_ = {};
      if (std::exchange(is_anew_, false)) calibration_ = begin(rig_, goal_);
    }
    for (CalibrationStop& stop : stops) calibration_.add_stop(std::move(stop));
    read_images();
    solve();
    read_images();  // Those of a stop come a little later than its points.
  }
}

void LiveCalibration::read_images() {
  if (session_.empty()) return;
  std::stop_token stop;
  {
    const std::lock_guard lock(mutex_);
    stop = stop_.get_token();
  }
  read_images_ahead(rig_, calibration_.recording().stops, image_places({session_, {}, {}}), *images_, stop);
}

void LiveCalibration::solve() {
  std::stop_token stop;
  {
    const std::lock_guard lock(mutex_);
    stop = stop_.get_token();
  }
  SilentReporter silent;
  Expected<StopEstimate> estimate = calibration_.estimate({silent, stop});
  std::shared_ptr<const LiveView> view;
  if (with_view_ && estimate && !stop.stop_requested()) view = make_view(rig_, calibration_, stop);
  const std::lock_guard lock(mutex_);
  solving_ = 0;
  if (is_anew_ || stop.stop_requested()) return;
  if (view) view_ = std::move(view);
  told_.trouble = estimate ? std::string() : estimate.error().message();
  if (estimate) told_.estimates.push_back(std::move(*estimate));
}

}  // namespace rigcal
