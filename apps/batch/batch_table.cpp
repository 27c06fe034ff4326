#include "apps/batch/batch_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/common/json_text.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/io/extrinsics_file.h"

namespace rigcal::batch {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* csv_header =
    "session,input,sensor,status,sigma_mm,sigma_deg,tx,ty,tz,qx,qy,qz,qw,reasons,seconds,peak_memory_mb,host\r\n";

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

// How bad a status is.
int rank(const std::string& status) { return status == "good" ? 0 : status == "weak" ? 1 : 2; }

std::map<std::string, int> counts_of(const BatchOutcome& outcome) {
  std::map<std::string, int> counts{{"good", 0}, {"weak", 0}, {"failed", 0}, {"waiting", 0}, {"kept", 0}};
  for (const SessionRow& row : outcome.rows) {
    ++counts[row.status];
    counts["kept"] += row.kept ? 1 : 0;
  }
  return counts;
}

std::array<double, 7> pose_numbers(const SE3& T) {
  const Eigen::Vector4d q = xyzw_from_rotation(T.R);  // with the sign that extrinsics.yaml has
  return {T.t.x(), T.t.y(), T.t.z(), q[0], q[1], q[2], q[3]};
}

Json sensor_json(const SensorRow& sensor) {
  Json json{{"name", sensor.name}, {"status", sensor.status}, {"reasons", sensor.reasons}};
  if (!sensor.placed) return json;
  const std::array<double, 7> pose = pose_numbers(sensor.T_base_sensor);
  json["translation"] = {pose[0], pose[1], pose[2]};
  json["rotation_xyzw"] = {pose[3], pose[4], pose[5], pose[6]};
  json["sigma_mm"] = 1e3 * sensor.sigma_m;
  json["sigma_deg"] = to_deg(sensor.sigma_rad);
  return json;
}

std::string csv_line(const SessionRow& row, const SensorRow& sensor) {
  std::string line = csv_field(row.session.name) + "," + csv_field(row.session.input) + "," + csv_field(sensor.name) +
                     "," + sensor.status;
  if (sensor.placed) {
    line += fmt::format(",{:.4f},{:.6f}", 1e3 * sensor.sigma_m, to_deg(sensor.sigma_rad));
    for (const double number : pose_numbers(sensor.T_base_sensor)) line += fmt::format(",{:.9f}", number);
  } else {
    line += ",,,,,,,,,";
  }
  return line + fmt::format(",{},{:.2f},{:.0f},{}\r\n", csv_field(joined(sensor.reasons, "; ")), row.record.wall_s,
                            row.record.peak_memory_mb, csv_field(row.record.host));
}

}  // namespace

void complete_row(SessionRow& row) {
  row.sensors.clear();
  row.error = row.record.error;
  row.status = "failed";
  if (!row.error.empty()) return;
  const Expected<ExtrinsicsFile> found =
      load_extrinsics((std::filesystem::path(row.result) / "extrinsics.yaml").string());
  if (!found) {
    row.error = found.error().message();
    return;
  }
  row.status = "good";
  for (const std::string& name : found->names) {
    SensorRow& sensor = row.sensors.emplace_back();
    sensor.name = name;
    const auto status = found->status.find(name);
    sensor.status = status != found->status.end() ? status->second : "failed";
    if (const auto reasons = found->reasons.find(name); reasons != found->reasons.end())
      sensor.reasons = reasons->second;
    if (const auto T = found->T_base_sensor.find(name); T != found->T_base_sensor.end()) {
      sensor.placed = true;
      sensor.T_base_sensor = T->second;
    }
    if (const auto covariance = found->covariance.find(name); covariance != found->covariance.end()) {
      const Vector6d sigma = covariance->second.diagonal().cwiseMax(0.0).cwiseSqrt();
      sensor.sigma_rad = sigma.head<3>().maxCoeff();
      sensor.sigma_m = sigma.tail<3>().maxCoeff();
    }
    if (rank(sensor.status) > rank(row.status)) row.status = sensor.status;
  }
}

std::string batch_csv(const BatchOutcome& outcome) {
  std::string text = csv_header;
  for (const SessionRow& row : outcome.rows) {
    for (const SensorRow& sensor : row.sensors) text += csv_line(row, sensor);
    if (!row.sensors.empty()) continue;
    SensorRow none;
    none.status = row.status;
    if (!row.error.empty()) none.reasons = {row.error};
    text += csv_line(row, none);
  }
  return text;
}

std::string batch_json(const BatchOutcome& outcome, const std::string& out) {
  Json json{{"rigcal", format_version}, {"command", "batch"}, {"out", out}};
  for (const auto& [name, count] : counts_of(outcome)) json[name] = count;
  json["jobs"] = outcome.jobs;
  json["threads_each"] = outcome.threads_each;
  json["wall_s"] = outcome.wall_s;
  json["stopped"] = outcome.stopped;
  json["sessions"] = Json::array();
  for (const SessionRow& row : outcome.rows) {
    Json& session = json["sessions"].emplace_back(
        Json{{"name", row.session.name}, {"input", row.session.input}, {"result", row.result}, {"status", row.status}});
    if (row.status == "waiting") continue;
    session["kept"] = row.kept;
    session["why"] = row.why;
    session["exit_code"] = row.record.code;
    session["wall_s"] = row.record.wall_s;
    session["cpu_s"] = row.record.cpu_s;
    session["peak_memory_mb"] = row.record.peak_memory_mb;
    session["host"] = row.record.host;
    if (!row.error.empty()) session["error"] = row.error;
    session["sensors"] = Json::array();
    for (const SensorRow& sensor : row.sensors) session["sensors"].push_back(sensor_json(sensor));
  }
  return json_text(json);
}

std::string batch_text(const BatchOutcome& outcome, const std::string& out) {
  const std::map<std::string, int> counts = counts_of(outcome);
  std::string text =
      fmt::format("{}: {} good, {} weak, {} failed{}; {} of them from before; {:.1f} s\n",
                  counted(outcome.rows.size(), "session"), counts.at("good"), counts.at("weak"), counts.at("failed"),
                  counts.at("waiting") > 0 ? fmt::format(", {} not done", counts.at("waiting")) : "", counts.at("kept"),
                  outcome.wall_s);
  for (const SessionRow& row : outcome.rows) {
    if (row.status == "good" || row.status == "waiting") continue;
    text += fmt::format("  {:<24} {}{}\n", row.session.name, row.status, row.error.empty() ? "" : ": " + row.error);
    for (const SensorRow& sensor : row.sensors) {
      if (sensor.status == "good") continue;
      text += fmt::format("    {:<16} {:<6} {}\n", sensor.name, sensor.status, joined(sensor.reasons, "; "));
    }
  }
  return text + fmt::format("results in {}/, all sensors in {}/batch.csv\n", out, out);
}

}  // namespace rigcal::batch
