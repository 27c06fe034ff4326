#include "apps/capture/capture_text.h"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/calibration/estimate_text.h"
#include "apps/capture/capture_record.h"
#include "apps/capture/doctor.h"
#include "apps/common/json_text.h"
#include "core/base/text.h"
#include "core/base/utc_text.h"
#include "core/base/version.h"
#include "core/turntable/coach.h"
#include "drivers/livox_codec/status.h"

namespace rigcal {
namespace {

const char* temperature_text(const livox::Status& status) {
  switch (status.temperature) {
    case livox::Level::normal:
      return "ok";
    case livox::Level::warning:
      return "high or low";
    case livox::Level::error:
      return "extreme";
  }
  return "?";
}

// A column is narrower than the words that `livox::sync_text` has.
const char* sync_word(const livox::Status& status) {
  switch (status.time_sync) {
    case livox::TimeSync::not_started:
      return "none";
    case livox::TimeSync::ptp:
      return "PTP";
    case livox::TimeSync::gps:
      return "GPS";
    case livox::TimeSync::pps:
      return "PPS";
    case livox::TimeSync::abnormal:
      return "failed";
  }
  return "?";
}

double lost_share(const CaptureDevice& device) {
  return device.expected == 0 ? 0.0 : static_cast<double>(device.lost) / static_cast<double>(device.expected);
}

std::string state_text(const livox::LinkInfo& link) {
  const bool spins_up = link.state == livox::LinkState::preparing && link.work_state == livox::WorkState::initialising;
  return spins_up ? "starts " + std::to_string(link.progress_percent) + " %" : livox::to_string(link.state);
}

std::string device_line(const CaptureDevice& device) {
  const livox::LinkInfo& link = device.report.link;
  const livox::Status status = livox::decode_status(link.status);
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), "%-15.15s %-12.12s %9.0f %8.2f  %-11s %-6s %9.1f", device.sensor.c_str(),
                state_text(link).c_str(), device.packets_per_s, 100.0 * lost_share(device), temperature_text(status),
                sync_word(status), device.drift_ppm);
  return line.data();
}

std::string camera_line(const CaptureCamera& camera) {
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), "%-15.15s %-12.12s %9.1f %8llu %8llu %8llu", camera.sensor.c_str(),
                camera.state.c_str(), camera.frames_per_s, static_cast<unsigned long long>(camera.counters.missing),
                static_cast<unsigned long long>(camera.counters.damaged()),
                static_cast<unsigned long long>(camera.dropped_by_queue));
  return line.data();
}

nlohmann::ordered_json matching_json(const CaptureCamera& camera) {
  nlohmann::ordered_json json = matching_counters(*camera.matching);
  if (camera.clock) {
    json["clock_drift_ppm"] = camera.clock->drift_ppm;
    json["clock_error_us"] = 1e-3 * camera.clock->error_ns;
  }
  return json;
}

std::string trigger_line(const trigger::TriggerReport& report) {
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), "%llu pulses, %llu left out, set %.0f us late (%.0f at most)",
                static_cast<unsigned long long>(report.pulses), static_cast<unsigned long long>(report.skipped),
                1e-3 * report.lateness.mean_ns(), 1e-3 * static_cast<double>(report.lateness.most_ns()));
  std::string text = line.data();
  if (report.strobe_pulses > 0) text += ", " + std::to_string(report.strobe_pulses) + " strobes";
  if (report.pps_pulses > 0) text += ", " + std::to_string(report.pps_pulses) + " PPS";
  return text;
}

nlohmann::ordered_json trigger_json(const trigger::TriggerReport& report) {
  nlohmann::ordered_json json = trigger_counters(report);
  for (const auto& [name, times] :
       {std::pair{"lateness_us", &report.lateness}, {"strobe_delay_us", &report.strobe_delay}})
    json[name] = {{"mean", 1e-3 * times->mean_ns()},
                  {"deviation", 1e-3 * times->deviation_ns()},
                  {"most", 1e-3 * static_cast<double>(times->most_ns())}};
  return json;
}

nlohmann::ordered_json camera_json(const CaptureCamera& camera) {
  const camera::CameraCounters& counters = camera.counters;
  nlohmann::ordered_json json{{"sensor", camera.sensor},
                              {"images", camera.written},
                              {"bytes", camera.bytes},
                              {"frames", counters.whole()},
                              {"damaged", counters.damaged()},
                              {"missing", counters.missing},
                              {"no_buffer", counters.no_buffer},
                              {"dropped_by_queue", camera.dropped_by_queue},
                              {"resent_packets", counters.resent_packets},
                              {"connection_losses", counters.losses}};
  if (camera.matching) json["matching"] = matching_json(camera);
  return json;
}

nlohmann::ordered_json device_json(const CaptureDevice& device) {
  const livox::LinkInfo& link = device.report.link;
  std::vector<std::string> missing_settings;
  for (const livox::MissingSetting& missing : link.missing_settings) missing_settings.push_back(missing.setting);
  return {{"sensor", device.sensor},
          {"broadcast_code", link.broadcast.broadcast_code},
          {"ip", to_string(link.ip)},
          {"packets", device.report.packets},
          {"bytes", device.report.bytes},
          {"expected", device.expected},
          {"lost", device.lost},
          {"drift_ppm", device.drift_ppm},
          {"connection_losses", link.counters.losses},
          {"interruptions", link.counters.interruptions},
          {"missing_settings", missing_settings},
          {"control", link_counters(link.counters)},
          {"status", link.status},
          {"says", status_words(link.status)}};
}

nlohmann::ordered_json interface_json(const livox::InterfaceReport& report) {
  return {{"name", report.interface.name},
          {"ip", to_string(report.interface.ip)},
          {"receive_buffer", report.receive_bytes},
          {"received", report.counters.received},
          {"dropped_by_kernel", report.counters.dropped_by_kernel},
          {"dropped_by_queue", report.counters.dropped_by_queue},
          {"strangers", report.counters.strangers},
          {"errors", report.counters.errors},
          {"queue_high_water", report.queue_high_water},
          {"queue_capacity", report.queue_capacity}};
}

std::string remarks_of(const std::vector<Shortfall>& shortfalls, const std::string& sensor) {
  std::string text;
  for (const Shortfall& shortfall : shortfalls)
    if (shortfall.about == sensor) text += shortfall.remark;
  return text;
}

}  // namespace

std::vector<std::string> capture_lines(const CaptureStatus& status) {
  std::array<char, 96> head{};
  std::snprintf(head.data(), head.size(), "captured %.0f s, %.1f MB", status.seconds,
                1e-6 * static_cast<double>(status.bytes));
  std::vector<std::string> lines{head.data(),
                                 "LiDAR           state        packets/s   lost %  temperature sync   clock ppm"};
  for (const CaptureDevice& device : status.devices) lines.push_back(device_line(device));
  for (const CaptureDevice& device : status.devices) {
    for (const std::string& word : status_words(device.report.link.status))
      lines.push_back(device.sensor + " says: " + word);
  }
  if (!status.cameras.empty()) lines.emplace_back("camera          state         frames/s  missing  damaged  dropped");
  for (const CaptureCamera& camera : status.cameras) lines.push_back(camera_line(camera));
  if (status.trigger) lines.push_back("trigger: " + trigger_line(*status.trigger));
  return lines;
}

std::string capture_text(const CaptureSummary& summary) {
  const std::vector<Shortfall> shortfalls = summary.shortfalls();
  std::array<char, 160> head{};
  std::snprintf(head.data(), head.size(), ": %.1f s, %llu datagrams, %.1f MB%s\n", summary.status.seconds,
                static_cast<unsigned long long>(summary.recorded), 1e-6 * static_cast<double>(summary.status.bytes),
                shortfalls.empty() ? "" : ", incomplete");
  std::string text = summary.session + head.data();
  const CaptureProgress& progress = summary.status.progress;
  if (progress.state != CaptureState::idle) {
    text += "  " + advice(progress);
    if (progress.short_stops > 0) text += ", " + std::to_string(progress.short_stops) + " more were left too early";
    text += "; " + counted(summary.status.stops.size(), "stop") + " found\n";
  }
  for (const CaptureDevice& device : summary.status.devices) {
    text += "  " + device.sensor + ": " + std::to_string(device.report.packets) + " packets, " +
            std::to_string(device.lost) + " lost" + remarks_of(shortfalls, device.sensor) + "\n";
  }
  for (const CaptureCamera& camera : summary.status.cameras) {
    std::array<char, 200> line{};
    std::snprintf(line.data(), line.size(), "  %s: %llu images, %llu frames missing, %llu damaged, %llu dropped%s\n",
                  camera.sensor.c_str(), static_cast<unsigned long long>(camera.written),
                  static_cast<unsigned long long>(camera.counters.missing),
                  static_cast<unsigned long long>(camera.counters.damaged()),
                  static_cast<unsigned long long>(camera.dropped_by_queue),
                  remarks_of(shortfalls, camera.sensor).c_str());
    text += line.data();
    if (camera.matching)
      text += "    " + std::to_string(camera.matching->matched) + " of them with their pulse, " +
              std::to_string(camera.matching->pulses_without_frame) + " pulses without an image\n";
  }
  if (summary.status.trigger) text += "  trigger: " + trigger_line(*summary.status.trigger) + "\n";
  if (summary.forgotten_until_ns)
    text += "  everything before " + utc_text(*summary.forgotten_until_ns) + " UTC was thrown away (--keep)\n";
  constexpr std::size_t most_gaps = 20;
  for (std::size_t i = 0; i < summary.gaps.size() && i < most_gaps; ++i) text += "  " + summary.gaps[i] + "\n";
  if (summary.gaps.size() > most_gaps)
    text += "  and " + std::to_string(summary.gaps.size() - most_gaps) + " more in session.json\n";
  return text;
}

std::string capture_json(const CaptureSummary& summary, const LiveResult* calibration) {
  nlohmann::ordered_json json{{"rigcal", format_version},
                              {"command", "capture"},
                              {"session", summary.session},
                              {"complete", summary.is_complete()},
                              {"seconds", summary.status.seconds},
                              {"datagrams", summary.recorded},
                              {"control_datagrams", summary.control_datagrams},
                              {"dropped_control", summary.dropped_control},
                              {"control", control_counters(summary.control)},
                              {"bytes", summary.status.bytes}};
  const CaptureProgress& progress = summary.status.progress;
  json["state"] = to_string(progress.state);
  if (!progress.failure.empty()) json["failure"] = progress.failure;
  json["stops_that_count"] = progress.stops;
  json["stops"] = nlohmann::ordered_json::array();
  for (const Stop& stop : summary.status.stops)
    json["stops"].push_back({{"stop", stop.index}, {"start_ns", stop.start_ns}, {"end_ns", stop.end_ns}});
  json["worst_wait_ms"] = 1e3 * summary.status.worst_wait_s;
  json["worst_write_ms"] = 1e3 * summary.status.worst_write_s;
  json["forgotten_until_ns"] = nullptr;
  if (summary.forgotten_until_ns) json["forgotten_until_ns"] = *summary.forgotten_until_ns;
  json["sensors"] = nlohmann::ordered_json::array();
  for (const CaptureDevice& device : summary.status.devices) json["sensors"].push_back(device_json(device));
  json["cameras"] = nlohmann::ordered_json::array();
  for (const CaptureCamera& camera : summary.status.cameras) json["cameras"].push_back(camera_json(camera));
  if (summary.status.trigger) json["trigger"] = trigger_json(*summary.status.trigger);
  json["interfaces"] = nlohmann::ordered_json::array();
  for (const livox::InterfaceReport& report : summary.interfaces) json["interfaces"].push_back(interface_json(report));
  json["gaps"] = summary.gaps;
  json["notes"] = summary.notes;
  if (calibration != nullptr) {
    json["calibration"] = {{"out", calibration->out},        {"status", to_string(calibration->result.status)},
                           {"closing_s", summary.closing_s}, {"solved_s", calibration->solved_s},
                           {"wall_s", calibration->wall_s},  {"estimates", estimates_json(calibration->estimates)}};
  }
  return json_text(json);
}

}  // namespace rigcal
