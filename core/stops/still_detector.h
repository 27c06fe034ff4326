#pragma once

#include "core/stops/still_judge.h"
#include "core/stops/turn_integrator.h"

namespace rigcal {

/// Why points are in no patch.
enum class DropReason { before_first_stop, moving, swing, short_stop, overflow, late, after_last_stop };
constexpr std::size_t drop_reasons = 7;
[[nodiscard]] const char* to_string(DropReason reason);

/// One stop as the inertial unit saw it.
struct StillStop {
  Stop stop;
  int imu_sensor = -1;
  /// Rotation from the previous stop, in the inertial unit's frame: maps directions of this stop into the previous one.
  /// Identity for the first stop.
  Matrix3d R_previous_this = Matrix3d::Identity();
  double rotation_sigma_rad = 0.0;             ///< 1 sigma about any axis; 0 for the first stop.
  bool rotation_known = true;                  ///< False: the unit was silent on the way, the rotation means nothing.
  Vector3d acceleration_g = Vector3d::Zero();  ///< Mean; points up in the unit's frame.
  Vector3d gyro_bias_rad_s = Vector3d::Zero();
  bool imu_gap = false;  ///< A short silence of the unit inside the stop was bridged.
};

/// Told, in order of time and without holes, what the rig did. Another source of stops (from the points alone, from a
/// table's angles) drives the patches through the same calls.
class StillListener {
 public:
  virtual ~StillListener() = default;
  virtual void not_still_until(std::int64_t until_ns, DropReason reason) = 0;
  virtual void still_until(std::int64_t until_ns, int stop) = 0;
  virtual void stop_ended(const StillStop& stop) = 0;
};

/// Figures for messages and `inspect`.
struct StillFigures {
  std::uint64_t imu_samples = 0;    ///< Used.
  std::uint64_t imu_doubles = 0;    ///< Came twice.
  std::uint64_t imu_unusable = 0;   ///< Too late, or no number.
  std::uint64_t imu_of_others = 0;  ///< Of other sensors' units.
  int stops = 0;
  double longest_still_s = 0.0;   ///< Also of rests too short to be a stop.
  double gyro_noise_rad_s = 0.0;  ///< 1 sigma of a sample, an axis, at the quietest half second; 0: none was seen.
  int bias_changes = 0;           ///< The bias first taken was a rotation: stops found before are doubtful.
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
  void end_stop();
  void not_still(std::int64_t until_ns, DropReason reason);

  StopOptions options_;
  StillListener& listener_;
  MotionBinner binner_;
  StillJudge judge_;
  TurnIntegrator turn_;
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
