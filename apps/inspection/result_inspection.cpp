// What inspect says of results.
#include "apps/inspection/inspection.h"
#include "core/io/extrinsics_file.h"
#include "core/quality/comparison.h"
#include "core/report/report_file.h"
#include "core/report/result_formats.h"
#include "core/report/summary_text.h"

namespace rigcal {
namespace {

struct LoadedResult {
  CalibrationResult result;
  bool judged = false;  ///< False for a rig file or a ground truth, which have no verdict.
};

Expected<LoadedResult> load(const std::string& path) {
  const Expected<ExtrinsicsFile> extrinsics = load_extrinsics(path);
  if (!extrinsics) return extrinsics.error();
  Expected<CalibrationResult> result = result_from(*extrinsics, path);
  if (!result) return result.error();
  return LoadedResult{std::move(*result), !extrinsics->status.empty()};
}

Inspection triple(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Inspection sensor_json(const LoadedResult& loaded, const SensorResult& sensor) {
  Inspection json{{"name", sensor.name}};
  if (loaded.judged) {
    json["status"] = to_string(sensor.status);
    json["reasons"] = sensor.reasons;
    json["bounds"] = bounds_text(loaded.result, sensor);
  }
  if (!sensor.T_base_sensor) return json;
  const Eigen::Vector4d q = xyzw_from_rotation(sensor.T_base_sensor->R);
  json["translation"] = triple(sensor.T_base_sensor->t);
  json["rotation_xyzw"] = {q[0], q[1], q[2], q[3]};
  if (loaded.judged) {
    const Vector6d sigma = sensor.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    json["stddev_deg"] = triple(sigma.head<3>() * (180.0 / pi));
    json["stddev_mm"] = triple(1e3 * sigma.tail<3>());
  }
  return json;
}

const char* word_of(MoveVerdict verdict) {
  switch (verdict) {
    case MoveVerdict::same:
      return "same";
    case MoveVerdict::moved:
      return "moved";
    case MoveVerdict::not_compared:
      break;
  }
  return "not compared";
}

}  // namespace

Expected<Inspection> inspect_result(const std::string& path) {
  const Expected<LoadedResult> loaded = load(path);
  if (!loaded) return loaded.error();
  const Expected<std::optional<ReportFile>> report = read_report(path);
  if (!report) return report.error();
  Inspection json = begin_inspection("result", path);
  if (loaded->judged) {
    json["status"] = to_string(loaded->result.status);
    json["verdict"] = summary_sentence(loaded->result);
  }
  json["base"] = loaded->result.base;
  json["sensors"] = Inspection::array();
  for (const SensorResult& sensor : loaded->result.sensors) json["sensors"].push_back(sensor_json(*loaded, sensor));
  json["warnings"] = *report ? (*report)->warnings : std::vector<std::string>();
  return json;
}

Expected<Inspection> inspect_two_results(const std::string& first, const std::string& second) {
  const Expected<LoadedResult> a = load(first);
  if (!a) return a.error();
  const Expected<LoadedResult> b = load(second);
  if (!b) return b.error();
  const Expected<ResultComparison> comparison = compare_results(a->result, b->result);
  if (!comparison) return Error{comparison.error().kind, comparison.error().what, second, comparison.error().mend};
  Inspection json = begin_inspection("comparison", first);
  json["other"] = second;
  json["verdict"] = comparison_sentence(*comparison);
  json["base"] = comparison->base;
  if (!comparison->bases.empty()) json["bases"] = comparison->bases;
  json["base_moved"] = comparison->base_moved;
  bool same = true;
  json["moves"] = Inspection::array();
  for (const SensorMove& move : comparison->sensors) {
    Inspection one{{"name", move.name}, {"verdict", word_of(move.verdict)}};
    same = same && move.verdict == MoveVerdict::same;
    if (move.verdict == MoveVerdict::not_compared) {
      one["why_not"] = move.why_not;
    } else {
      one["translation_mm"] = 1e3 * move.xi.tail<3>().norm();
      one["rotation_deg"] = to_deg(move.xi.head<3>().norm());
      one["sigmas"] = move.sigmas;
      one["by_axis_mm"] = triple(1e3 * move.xi.tail<3>());
      one["by_axis_deg"] = triple(move.xi.head<3>() * (180.0 / pi));
    }
    json["moves"].push_back(std::move(one));
  }
  json["same"] = same;
  json["warnings"] = Inspection::array();
  return json;
}

}  // namespace rigcal
