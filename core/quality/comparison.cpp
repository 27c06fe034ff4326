#include "core/quality/comparison.h"

#include <algorithm>
#include <cmath>

#include "core/base/text.h"
#include "core/camera/camera_calibration.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

const SensorResult* find(const CalibrationResult& result, const std::string& name) {
  const auto found = std::find_if(result.sensors.begin(), result.sensors.end(),
                                  [&](const SensorResult& sensor) { return sensor.name == name; });
  return found == result.sensors.end() ? nullptr : &*found;
}

// xi^T C^-1 xi. A direction that is said to be known exactly is not: nothing is known to a nanometre.
double chi2_of(const Vector6d& xi, const Matrix6d& covariance) {
  const Matrix6d C = 0.5 * (covariance + covariance.transpose()) + 1e-18 * Matrix6d::Identity();
  const Vector6d scale = C.diagonal().cwiseSqrt().cwiseInverse();
  const SymmetricEigen6 eigen = symmetric_eigen6(scale.asDiagonal() * C * scale.asDiagonal());
  const Vector6d along = eigen.vectors.transpose() * (scale.asDiagonal() * xi);
  return along.cwiseAbs2().cwiseQuotient(eigen.values.cwiseMax(1e-12)).sum();
}

// How a sensor moved as seen from the base, with its covariance there.
struct BaseMove {
  Vector6d xi;
  Matrix6d covariance;
};

BaseMove in_base(const SensorResult& a, const SensorResult& b, const Vector6d& xi) {
  const Matrix6d Ad = a.T_base_sensor->adjoint();
  return {Ad * xi, Ad * (a.covariance + b.covariance) * Ad.transpose()};
}

bool is_placed(const CalibrationResult& result, const std::string& name) {
  const SensorResult* sensor = find(result, name);
  if (sensor == nullptr || !sensor->T_base_sensor) return false;
  return name == result.base || !sensor->covariance.isZero(0.0);
}

// From which sensor both can be told; empty: from none.
std::string common_base(const CalibrationResult& a, const CalibrationResult& b) {
  std::vector<std::string> names{a.base, b.base};
  for (const SensorResult& sensor : a.sensors) names.push_back(sensor.name);
  const auto found = std::find_if(names.begin(), names.end(),
                                  [&](const std::string& name) { return is_placed(a, name) && is_placed(b, name); });
  return found == names.end() ? std::string() : *found;
}

// The sensors as told from `base`, which must be placed: T_b_s = T_o_b^-1 T_o_s is off by both sensors' errors.
CalibrationResult told_from(CalibrationResult result, const std::string& base) {
  if (result.base == base) return result;
  const SE3 T_base_old = find(result, base)->T_base_sensor->inverse();
  const Matrix6d covariance_of_base = find(result, base)->covariance;
  for (SensorResult& sensor : result.sensors) {
    if (!sensor.T_base_sensor) continue;
    const bool has_sigma = sensor.name == result.base || !sensor.covariance.isZero(0.0);
    sensor.T_base_sensor = T_base_old * *sensor.T_base_sensor;
    const Matrix6d Ad = sensor.T_base_sensor->inverse().adjoint();
    if (has_sigma) sensor.covariance += Ad * covariance_of_base * Ad.transpose();
    if (sensor.name == base) sensor.covariance.setZero();
  }
  result.base = base;
  return result;
}

bool all_alike(const std::vector<BaseMove>& moves) {
  return std::all_of(moves.begin(), moves.end(), [&](const BaseMove& move) {
    return chi2_of(move.xi - moves.front().xi, move.covariance + moves.front().covariance) < differing_chi2;
  });
}

std::string status_words(const SensorResult* sensor, const char* which) {
  if (sensor == nullptr) return std::string("the ") + which + " result does not have it";
  return std::string("it failed in the ") + which + " result";
}

std::string how_far(const SensorMove& move) {
  return fixed_text(1e3 * move.xi.tail<3>().norm(), 1) + " mm and " + fixed_text(to_deg(move.xi.head<3>().norm()), 3) +
         " degrees (" + fixed_text(move.sigmas, 1) + " times what both results are sure of)";
}

std::string number_of(std::size_t count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? " is" : "s are");
}

}  // namespace

Expected<ResultComparison> compare_results(const CalibrationResult& first, const CalibrationResult& second) {
  ResultComparison out;
  out.base = first.base == second.base ? first.base : common_base(first, second);
  if (out.base.empty()) {
    return input_error("the results have two bases, " + first.base + " and " + second.base +
                           ", and no sensor that both know the place of",
                       {}, "calibrate both recordings with the same base in the rig file");
  }
  if (first.base != second.base) out.bases = {first.base, second.base};
  const CalibrationResult a = told_from(first, out.base);
  const CalibrationResult b = told_from(second, out.base);
  std::vector<std::string> names;
  for (const SensorResult& sensor : a.sensors) names.push_back(sensor.name);
  for (const SensorResult& sensor : b.sensors) {
    if (find(a, sensor.name) == nullptr) names.push_back(sensor.name);
  }
  std::vector<BaseMove> moves;
  std::size_t compared = 0;
  for (const std::string& name : names) {
    if (name == a.base) continue;
    SensorMove& move = out.sensors.emplace_back();
    move.name = name;
    const SensorResult* in_a = find(a, name);
    const SensorResult* in_b = find(b, name);
    if (in_a == nullptr || !in_a->T_base_sensor) {
      move.why_not = status_words(in_a, "first");
    } else if (in_b == nullptr || !in_b->T_base_sensor) {
      move.why_not = status_words(in_b, "second");
    } else if (in_a->covariance.isZero(0.0) || in_b->covariance.isZero(0.0)) {
      move.why_not = "one of the files does not say how sure it is";
    } else {
      ++compared;
      move.xi = (in_a->T_base_sensor->inverse() * *in_b->T_base_sensor).log();
      const double chi2 = chi2_of(move.xi, in_a->covariance + in_b->covariance);
      move.sigmas = std::sqrt(chi2 / 6.0);
      move.verdict = chi2 > differing_chi2 ? MoveVerdict::moved : MoveVerdict::same;
      if (move.verdict == MoveVerdict::moved) moves.push_back(in_base(*in_a, *in_b, move.xi));
    }
  }
  out.base_moved = compared >= 2 && moves.size() == compared && all_alike(moves);
  return out;
}

std::string comparison_sentence(const ResultComparison& comparison) {
  std::string moved;
  std::size_t same = 0;
  std::size_t not_compared = 0;
  for (const SensorMove& move : comparison.sensors) {
    same += move.verdict == MoveVerdict::same ? 1 : 0;
    not_compared += move.verdict == MoveVerdict::not_compared ? 1 : 0;
    if (move.verdict == MoveVerdict::moved) {
      moved += (moved.empty() ? "" : ", ") + move.name + " moved by " + how_far(move);
    }
  }
  std::string text;
  if (comparison.base_moved) {
    text = comparison.base + ", the base, moved: all others moved alike, seen from it";
  } else if (!moved.empty()) {
    text = moved;
    if (same > 0) text += "; " + number_of(same, "other") + " where " + (same == 1 ? "it was" : "they were");
  } else if (same > 0) {
    text = "Nothing moved: " + number_of(same, "sensor") + " where " + (same == 1 ? "it was" : "they were");
  } else {
    text = "Nothing could be compared";
  }
  if (not_compared > 0 && !(same == 0 && moved.empty())) {
    text += "; " + number_of(not_compared, "sensor") + " not compared";
  }
  if (!comparison.bases.empty()) {
    text += "; all as seen from " + comparison.base + ", since the results have two bases, " +
            comparison.bases.front() + " and " + comparison.bases.back();
  }
  return text + ".";
}

}  // namespace rigcal
