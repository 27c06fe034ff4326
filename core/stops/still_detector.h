#pragma once

#include "core/stops/brief_rests.h"
#include "core/stops/still_judge.h"
#include "core/stops/still_listener.h"
#include "core/stops/turn_integrator.h"

namespace rigcal {

/// Figures for messages and `inspect`.
struct StillFigures {
  std::uint64_t imu_samples = 0;    ///< Used.
  std::uint64_t imu_unusable = 0;   ///< Too late, or nothing that a unit can read.
  std::uint64_t imu_of_others = 0;  ///< Of other sensors' units.
  int stops = 0;
  double longest_still_s = 0.0;       ///< Also of rests too short to be a stop.
  int brief_rests = 0;                ///< Pauses between turns that were too short to be stops (brief_rests.h),
  double longest_brief_rest_s = 0.0;  ///< and the longest of them.
  double gyro_noise_rad_s = 0.0;      ///< 1 sigma of a sample, an axis, at the quietest half second; 0: none was seen.
  int bias_changes = 0;               ///< The bias first taken was a rotation: stops found before are doubtful.
};

/// Finds the still intervals of an IMU stream: causal, bounded memory, verdicts about 0.75 s behind the stream.
///
/// A stop is a run of still bins (StillJudge), from when the swing has settled (swing.h), cut by a margin at both ends.
/// Limits: a constant slow rotation from the stream's first moment on is told from a bias only once the rig has rested;
/// a constant rotation below `creep_limit_rad_s` never is.
class StillDetector {
 public:
  StillDetector(const StopOptions& options, StillListener& listener);
  void add(const ImuSample& sample);
  /// The end of the stream: closes the last stop.
  void flush();
  [[nodiscard]] StillFigures figures() const;
  [[nodiscard]] std::optional<RestNow> rest() const;

 private:
  enum class State { moving, candidate, stopped };
  void add_bins(const std::vector<MotionBin>& bins);
  void take_finals(bool at_end);
  void step(const MotionBin& bin);
  void begin_candidate(const MotionBin& bin);
  void extend_candidate(const MotionBin& bin);
  void reject_candidate();
  void confirm_candidate();
  void extend_stop(const MotionBin& bin);
  void end_stop(StopEnd end);
  void not_still(std::int64_t until_ns, DropReason reason);

  StopOptions options_;
  StillListener& listener_;
  MotionBinner binner_;
  StillJudge judge_;
  TurnIntegrator turn_;
  BriefRests brief_rests_;
  State state_ = State::moving;
  int imu_sensor_;
  std::vector<MotionBin> candidate_;  ///< The bins of a rest that is not yet long enough.
  std::int64_t run_start_ns_ = 0;
  std::int64_t start_ns_ = 0;      ///< Of the stop: settled, margin cut.
  std::int64_t still_end_ns_ = 0;  ///< End of the last still bin.
  StillStop open_;
  double bins_ = 0.0;  ///< In the means of `open_`.
  double samples_ = 0.0;
  StillGyro previous_gyro_;
  std::uint64_t imu_of_others_ = 0;
  int stops_ = 0;
  double longest_still_s_ = 0.0;
};

}  // namespace rigcal
