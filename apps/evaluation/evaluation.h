#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/se3.h"
#include "core/quality/result.h"

namespace rigcal {

/// Extrinsics and poses on one side of a comparison.
struct KnownRig {
  struct Entry {
    std::string name;
    Status status = Status::good;
    std::optional<SE3> T_base_sensor;
    std::optional<Matrix6d> covariance;  ///< Of xi in T exp(xi).
  };
  /// The truth knows number and interval of a stop; a result has one time (start_ns = end_ns), or only the number
  /// where its input had no times.
  struct Pose {
    std::optional<int> stop;
    std::int64_t start_ns = 0;
    std::int64_t end_ns = 0;
    SE3 T_G_base;
  };
  std::string base;
  std::vector<Entry> sensors;  ///< The base may be left out.
  std::vector<Pose> poses;
};

/// How far one sensor of the result is from the truth. The numbers are absent where the result has no transform.
struct SensorError {
  std::string name;
  bool missing = false;  ///< The truth has this sensor, the result does not name it.
  Status status = Status::failed;
  bool compared = false;
  double rotation_rad = 0.0;   ///< Angle of R_est R_true^-1.
  double translation_m = 0.0;  ///< Norm of t_est - t_true.
  /// log(T_true^-1 T_est) = [rotation rad; translation m], along the sensor's own axes.
  Vector6d xi = Vector6d::Zero();
  /// xi^T C^-1 xi / 6: about 1 where the covariance C of the result is right. Absent without a regular covariance.
  std::optional<double> nees_per_dof;
};

/// Errors of the poses of the stops, each taken relative to the first stop that both sides have.
struct PoseErrors {
  int compared = 0;   ///< The first one, which has no error, included.
  int unmatched = 0;  ///< Stops of the truth without a pose in the result.
  double median_rotation_rad = 0.0;
  double median_translation_m = 0.0;
  double worst_rotation_rad = 0.0;
  double worst_translation_m = 0.0;
};

struct Evaluation {
  std::string base;
  std::vector<SensorError> sensors;       ///< All but the base: those of the result, then those only the truth has.
  std::vector<std::string> not_in_truth;  ///< Sensors of the result about which the truth says nothing.
  std::optional<PoseErrors> poses;        ///< Absent where one side has no poses, or no stop is common.
};

/// Compares. A truth with another base is first expressed in the base of the result. An Error where the truth does not
/// know that base, or neither a sensor besides the base nor two stops are common to both.
[[nodiscard]] Expected<Evaluation> evaluate(const KnownRig& result, const KnownRig& truth);

/// Whether a sensor besides the base was asked about: a result of the base alone has poses only.
[[nodiscard]] bool has_sensors(const Evaluation& evaluation);

/// True when every sensor that the result names and the truth knows has a transform within both bounds. A sensor that
/// only the truth has was not solved for (a camera of a run without images) and does not count; a failed one does.
[[nodiscard]] bool is_within(const Evaluation& evaluation, double translation_m, double rotation_rad);

}  // namespace rigcal
