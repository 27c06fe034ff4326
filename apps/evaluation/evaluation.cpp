#include "apps/evaluation/evaluation.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace rigcal {
namespace {

const KnownRig::Entry* find(const KnownRig& rig, const std::string& name) {
  const auto found = std::find_if(rig.sensors.begin(), rig.sensors.end(),
                                  [&](const KnownRig::Entry& entry) { return entry.name == name; });
  return found == rig.sensors.end() ? nullptr : &*found;
}

std::optional<SE3> transform_of(const KnownRig& rig, const std::string& name) {
  if (name == rig.base) return SE3{};
  const KnownRig::Entry* entry = find(rig, name);
  return entry == nullptr ? std::nullopt : entry->T_base_sensor;
}

std::optional<double> nees_per_dof(const Vector6d& xi, const std::optional<Matrix6d>& covariance) {
  if (!covariance || !covariance->allFinite()) return std::nullopt;
  const Eigen::LLT<Matrix6d> cholesky(*covariance);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  return xi.dot(cholesky.solve(xi)) / 6.0;
}

SensorError compare(const KnownRig::Entry& entry, const SE3& truth) {
  SensorError error;
  error.name = entry.name;
  error.status = entry.status;
  if (!entry.T_base_sensor) return error;
  const SE3& estimate = *entry.T_base_sensor;
  error.compared = true;
  error.rotation_rad = rotation_distance(estimate.R, truth.R);
  error.translation_m = (estimate.t - truth.t).norm();
  error.xi = (truth.inverse() * estimate).log();
  error.nees_per_dof = nees_per_dof(error.xi, entry.covariance);
  return error;
}

// Of an even count the mean of the two in the middle, not one of them as `median`: of few stops it is nearer the truth.
double interpolated_median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

bool is_same_stop(const KnownRig::Pose& estimate, const KnownRig::Pose& truth) {
  if (estimate.stop) return estimate.stop == truth.stop;
  return estimate.start_ns >= truth.start_ns && estimate.end_ns <= truth.end_ns;
}

std::optional<PoseErrors> compare_poses(const KnownRig& result, const KnownRig& truth, const SE3& T_truth_base_base) {
  PoseErrors errors;
  std::optional<SE3> T_first_G_estimate;
  std::optional<SE3> T_first_G_truth;
  std::vector<double> rotations;
  std::vector<double> translations;
  for (const KnownRig::Pose& stop : truth.poses) {
    const auto pose = std::find_if(result.poses.begin(), result.poses.end(),
                                   [&](const KnownRig::Pose& candidate) { return is_same_stop(candidate, stop); });
    if (pose == result.poses.end()) {
      ++errors.unmatched;
      continue;
    }
    const SE3 T_G_base_true = stop.T_G_base * T_truth_base_base;
    ++errors.compared;
    if (!T_first_G_estimate) {
      T_first_G_estimate = pose->T_G_base.inverse();
      T_first_G_truth = T_G_base_true.inverse();
      continue;
    }
    const SE3 estimate = *T_first_G_estimate * pose->T_G_base;
    const SE3 expected = *T_first_G_truth * T_G_base_true;
    rotations.push_back(rotation_distance(estimate.R, expected.R));
    translations.push_back((estimate.t - expected.t).norm());
  }
  if (errors.compared == 0) return std::nullopt;
  if (!rotations.empty()) {
    errors.median_rotation_rad = interpolated_median(rotations);
    errors.median_translation_m = interpolated_median(translations);
    errors.worst_rotation_rad = *std::max_element(rotations.begin(), rotations.end());
    errors.worst_translation_m = *std::max_element(translations.begin(), translations.end());
  }
  return errors;
}

}  // namespace

Expected<Evaluation> evaluate(const KnownRig& result, const KnownRig& truth) {
  const std::optional<SE3> T_truth_base_base = transform_of(truth, result.base);
  if (!T_truth_base_base) {
    return input_error("the truth does not say where the base of the result, " + result.base + ", is", {},
                       "give a truth that has this sensor");
  }
  const SE3 T_base_truth_base = T_truth_base_base->inverse();
  Evaluation evaluation;
  evaluation.base = result.base;
  for (const KnownRig::Entry& entry : result.sensors) {
    if (entry.name == result.base) continue;
    const std::optional<SE3> T_truth_base_sensor = transform_of(truth, entry.name);
    if (T_truth_base_sensor) {
      evaluation.sensors.push_back(compare(entry, T_base_truth_base * *T_truth_base_sensor));
    } else {
      evaluation.not_in_truth.push_back(entry.name);
    }
  }
  const auto add_missing = [&](const std::string& name) {
    if (name == result.base || find(result, name) != nullptr || !transform_of(truth, name)) return;
    SensorError error;
    error.name = name;
    error.missing = true;
    evaluation.sensors.push_back(error);
  };
  if (find(truth, truth.base) == nullptr) add_missing(truth.base);
  for (const KnownRig::Entry& entry : truth.sensors) add_missing(entry.name);
  evaluation.poses = compare_poses(result, truth, *T_truth_base_base);
  // A pose is compared with that of the first common stop.
  const bool has_poses = evaluation.poses && evaluation.poses->compared > 1;
  if (!has_sensors(evaluation) && !has_poses) {
    return input_error("the result and the truth have no sensor in common besides the base, and no two stops", {},
                       "give the truth of this rig");
  }
  return evaluation;
}

bool has_sensors(const Evaluation& evaluation) {
  return !std::all_of(evaluation.sensors.begin(), evaluation.sensors.end(),
                      [](const SensorError& e) { return e.missing; });
}

bool is_within(const Evaluation& evaluation, double translation_m, double rotation_rad) {
  return std::all_of(evaluation.sensors.begin(), evaluation.sensors.end(), [&](const SensorError& error) {
    if (error.missing) return true;
    return error.compared && error.translation_m <= translation_m && error.rotation_rad <= rotation_rad;
  });
}

}  // namespace rigcal
