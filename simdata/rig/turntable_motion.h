#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/se3.h"

namespace rigcal::sim {

/// The carriage trembles all the time: a sine about an axis drawn at random.
struct Vibration {
  double amplitude_rad = 0.0;
  double frequency_hz = 25.0;
};

/// Somebody knocks against the rig while it stands still: within `TurntableMotion::bump_s` it leans over by `angle_rad`
/// about an axis drawn at random, and stays so until the table has turned on.
struct Bump {
  int stop = 0;
  double time_s = 0.0;  ///< After the stop's start.
  double angle_rad = 0.0;
};

/// How the rig is carried round: a turntable that stops, dwells and goes on, or a vehicle that does. What troubles a
/// stop is off by default.
struct TurntableOptions {
  int stops = 20;
  double dwell_s = 2.0;
  double initial_still_s = 1.0;  ///< Before the first dwell, and part of it,
  double final_still_s = 0.5;    ///< after the last, and part of it.
  double turn_s = 1.5;           ///< One step of the table, an S-curve (quintic: no jump in acceleration).
  double step_sigma_deg = 1.2;   ///< Of each step about 360 deg / stops: a table turned by hand.
  /// Steps between these two (degrees), all as likely, instead of equal ones: however many, so not one full turn.
  std::optional<std::array<double, 2>> step_range_deg;
  double axis_tilt_deg = 1.5;    ///< Between the table's axis and the plumb line.
  double base_offset_min = 0.1;  ///< Distance of the base sensor from the axis, metres.
  double base_offset_max = 0.3;
  double base_tilt_deg = 1.5;  ///< Of the base sensor on the table.
  double stop_jitter_m = 0.3e-3;
  double stop_jitter_deg = 0.01;
  double swing_rad = 3e-3;  ///< First peak of the swing after each turn; it dies away within `swing_decay_s`.
  double swing_decay_s = 0.15;
  double swing_hz = 4.0;
  /// Dwells between these two instead of `dwell_s`, short ones as often as long ones (even in the logarithm).
  std::optional<std::array<double, 2>> dwell_range_s;
  /// Half the length of a figure of eight that the rig is driven along, looking 45 degrees to the right of its way, its
  /// stops all along it: a vehicle; 0: it turns where it stands.
  double drive_m = 0.0;
  double creep_rad_per_s = 0.0;  ///< The table turns on by this all the time.
  Vibration vibration;
  double overshoot_rad = 0.0;       ///< Each turn goes this much too far, and back
  double overshoot_return_s = 0.4;  ///< in this time, before the stop starts.
  std::vector<Bump> bumps;
};

/// A vehicle, not a table: each stop stands off the turn by these, root mean square, in any direction.
void let_wander(double off_m, double off_deg, TurntableOptions& options);

/// An interval in which nothing but swing, creep and vibration moves the rig: a stop, or its part between two bumps.
struct Rest {
  int stop = 0;
  double start_s = 0.0;
  double end_s = 0.0;
};

/// Pose of the base sensor as a smooth function of time. World frame G: the base sensor settled at the first stop.
class TurntableMotion {
 public:
  /// `T_scene_table`: where the table stands and x points at the first stop. The rest is drawn from `random`.
  TurntableMotion(const SE3& T_scene_table, const TurntableOptions& options, Random& random);

  [[nodiscard]] int stop_count() const { return static_cast<int>(stops_.size()); }
  /// Times (s) between which stop `k` stands still but for its swing and what else was asked for.
  [[nodiscard]] double stop_start_s(int k) const { return stops_[static_cast<std::size_t>(k)].start_s; }
  [[nodiscard]] double stop_end_s(int k) const { return stops_[static_cast<std::size_t>(k)].end_s; }
  /// The stop's length without the still time before and after the run.
  [[nodiscard]] double dwell_s(int k) const { return stops_[static_cast<std::size_t>(k)].dwell_s; }
  [[nodiscard]] double duration_s() const { return stops_.back().end_s; }
  /// The stops, cut where the rig is bumped, in order of time.
  [[nodiscard]] std::vector<Rest> rests() const;

  [[nodiscard]] SE3 T_scene_base(double time_s) const;
  /// How far the table has turned since the first stop, rad.
  [[nodiscard]] double angle_rad(double time_s) const;
  /// The same without the swing.
  [[nodiscard]] SE3 T_scene_base_unswung(double time_s) const {
    return pose_at(time_s, bump_at(time_s) + vibration_at(time_s));
  }
  /// The same without swing and vibration, for a time within a stop.
  [[nodiscard]] SE3 T_scene_base_settled(double time_s) const { return pose_at(time_s, bump_at(time_s)); }
  /// The same in the middle of stop `k`: the pose that it settles to.
  [[nodiscard]] SE3 T_scene_base_at_stop(int k) const;
  /// Whether the rig moves within its stops, the swing apart.
  [[nodiscard]] bool moves_at_rest() const {
    return options_.creep_rad_per_s != 0.0 || options_.vibration.amplitude_rad != 0.0 || !options_.bumps.empty();
  }
  [[nodiscard]] SE3 T_G_base_at_stop(int k) const;
  [[nodiscard]] SE3 T_scene_G() const { return T_scene_base_at_stop(0); }

  /// The table's axis: unit direction and foot point (nearest to the origin), in the base frame.
  [[nodiscard]] Vector3d axis_in_base() const;
  [[nodiscard]] Vector3d axis_point_in_base() const;

  static constexpr double bump_s = 0.06;

 private:
  struct StopPose {
    double start_s = 0.0;
    double end_s = 0.0;
    double dwell_s = 0.0;
    double angle = 0.0;
    Vector3d place = Vector3d::Zero();  ///< Of the carriage, in the frame of the axis.
    Vector6d jitter = Vector6d::Zero();
    Vector3d swing = Vector3d::Zero();  ///< Direction and size of the swing after arriving here.
  };
  struct Way {
    double angle = 0.0;
    Vector3d place = Vector3d::Zero();
    Vector6d jitter = Vector6d::Zero();
  };
  [[nodiscard]] Way way_at(double time_s) const;
  [[nodiscard]] SE3 pose_at(double time_s, const Vector3d& bend) const;
  [[nodiscard]] SE3 compose(const Way& way, const Vector3d& bend) const;
  [[nodiscard]] Vector3d swing_at(double time_s) const;
  [[nodiscard]] Vector3d bump_at(double time_s) const;
  [[nodiscard]] Vector3d vibration_at(double time_s) const;

  TurntableOptions options_;
  SE3 T_scene_axis_;  ///< z along the table's axis.
  SE3 T_axis_base_;
  std::vector<StopPose> stops_;
  std::vector<Vector3d> bump_axes_;  ///< By bump.
  Vector3d vibration_axis_ = Vector3d::UnitX();
  double vibration_phase_ = 0.0;
};

}  // namespace rigcal::sim
