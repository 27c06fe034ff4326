#include "apps/live_options.h"

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "core/base/version.h"

namespace rigcal {
namespace {

constexpr const char* incident_forms =
    "write SENSOR,SECONDS,reboot or SENSOR,SECONDS,silence,SECONDS or SENSOR,SECONDS,taken,SECONDS or "
    "SENSOR,SECONDS,status,HEX";

std::optional<double> parse_seconds(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= 0.0) || value > 1e6) return std::nullopt;
  return value;
}

std::optional<std::uint32_t> parse_hex(const std::string& text) {
  const std::size_t start = text.rfind("0x", 0) == 0 ? 2 : 0;
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data() + start, text.data() + text.size(), value, 16);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

Error incident_error(const std::string& text) {
  return input_error("'" + text + "' is no incident", "--incident", incident_forms);
}

}  // namespace

Expected<sim::Incident> parse_incident(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  if (parts.size() < 3 || parts.size() > 4 || parts[0].empty()) return incident_error(text);
  const auto time_s = parse_seconds(parts[1]);
  if (!time_s) return incident_error(text);
  sim::Incident incident;
  incident.sensor = parts[0];
  incident.time_s = *time_s;
  if (parts[2] == "reboot" && parts.size() == 3) return incident;
  if (parts.size() != 4) return incident_error(text);
  if (parts[2] == "status") {
    const auto status = parse_hex(parts[3]);
    if (!status) return incident_error(text);
    incident.kind = sim::Incident::Kind::status;
    incident.status = *status;
    return incident;
  }
  const auto length_s = parse_seconds(parts[3]);
  if (!length_s || (parts[2] != "silence" && parts[2] != "taken")) return incident_error(text);
  incident.kind = parts[2] == "silence" ? sim::Incident::Kind::silence : sim::Incident::Kind::owned_by_other;
  incident.length_s = *length_s;
  return incident;
}

void add_live_options(CLI::App& command, CLI::Option& live, sim::LiveOptions& options) {
  command.add_option("--speed", options.speed, "With --live: so many times faster than real time (default 1)")
      ->check(CLI::Range(0.01, 100.0))
      ->needs(&live)
      ->option_text("N");
  command.add_flag("--loop", options.loop, "With --live: begin again when the run is over")->needs(&live);
  command
      .add_option("--spin-up", options.device.spin_up_s,
                  "With --live: seconds from switching a device on until it can sample (default 2)")
      ->check(CLI::Range(0.0, 600.0))
      ->needs(&live)
      ->option_text("SECONDS");
  const auto add_share = [&](const char* name, double& share, const char* text) {
    command.add_option(name, share, text)->check(CLI::Range(0.0, 0.9))->needs(&live)->option_text("SHARE");
  };
  add_share("--control-loss", options.control.drop, "With --live: share of the devices' answers that get lost");
  add_share("--control-duplicate", options.control.duplicate, "With --live: share of answers that come twice");
  add_share("--control-delay", options.control.delay, "With --live: share of answers up to 0.3 s late");
  add_share("--control-damage", options.control.wrong_checksum, "With --live: share of answers with a wrong bit");
  add_share("--frame-loss", options.cameras.faults.loss,
            "With --live: share of the cameras' stream packets that get lost");
  add_share("--frame-reorder", options.cameras.faults.reorder,
            "With --live: share of the cameras' stream packets that others overtake");
  command
      .add_flag_callback(
          "--no-resend", [&options] { options.cameras.can_resend = false; },
          "With --live: the cameras send no packet a second time")
      ->needs(&live);
  command
      .add_option("--camera-delay", options.cameras.answer_delay_s,
                  "With --live: seconds that the cameras take for an answer (default 0)")
      ->check(CLI::Range(0.0, 60.0))
      ->needs(&live)
      ->option_text("SECONDS");
  command
      .add_flag("--test-pattern", options.cameras.is_test_pattern,
                "With --live: the cameras send moving stripes, at any rate, instead of the scene")
      ->needs(&live);
  command
      .add_option(
          "--trigger-port", options.cameras.trigger_port,
          "With --live: a datagram to this UDP port of a camera is a pulse on all cameras' trigger lines, instead "
          "of the run's own")
      ->check(CLI::Range(1, 65535))
      ->needs(&live)
      ->option_text("PORT");
  command
      .add_option_function<std::vector<std::string>>(
          "--incident",
          [&options](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) options.incidents.push_back(*parse_incident(text));
          },
          "With --live: what happens to a device, for example avia,10,reboot or avia,10,silence,5 or avia,10,taken,5 "
          "(another host has it) or avia,10,status,0x40000001; may be given several times")
      ->check(CLI::Validator(
          [](const std::string& text) {
            const auto incident = parse_incident(text);
            return incident ? std::string() : incident.error().message();
          },
          ""))
      ->expected(1)
      ->take_all()
      ->needs(&live)
      ->option_text("INCIDENT");
}

std::string live_summary_text(const sim::LiveSummary& summary) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), "served %.1f s of a run of %d stops: %llu packets, %.0f MB%s\n",
                summary.seconds, summary.stops, static_cast<unsigned long long>(summary.packets),
                static_cast<double>(summary.bytes) * 1e-6, summary.is_complete ? "" : " (stopped)");
  std::string all = text.data();
  if (summary.unsent > 0) all += std::to_string(summary.unsent) + " packets could not be sent\n";
  for (const sim::LiveCameraSummary& camera : summary.cameras) {
    all += camera.name + " on " + to_string(camera.ip) + ": " + std::to_string(camera.counts.stream.blocks) +
           " frames in " + std::to_string(camera.counts.stream.packets) + " packets\n";
  }
  return all;
}

std::string live_summary_json(const std::string& scene, std::uint64_t seed, const sim::LiveSummary& summary) {
  std::uint64_t lost = 0;
  std::uint64_t duplicated = 0;
  for (const sim::FaultCounts& counts : summary.faults) {
    lost += counts.lost;
    duplicated += counts.duplicated;
  }
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (const sim::LiveCameraSummary& camera : summary.cameras) {
    const sim::CameraCounts& counts = camera.counts;
    cameras.push_back({{"name", camera.name},
                       {"address", to_string(camera.ip)},
                       {"frames", counts.stream.blocks},
                       {"dropped_frames", counts.dropped_frames + counts.stream.skipped_blocks},
                       {"ignored_triggers", counts.ignored_triggers},
                       {"packets", counts.stream.packets},
                       {"lost", counts.stream.lost},
                       {"resent", counts.stream.resent},
                       {"unsent", counts.unsent_packets}});
  }
  const nlohmann::ordered_json json{{"rigcal", format_version},
                                    {"command", "simulate"},
                                    {"live", true},
                                    {"scene", scene},
                                    {"seed", seed},
                                    {"stops", summary.stops},
                                    {"seconds", summary.seconds},
                                    {"complete", summary.is_complete},
                                    {"packets", summary.packets},
                                    {"bytes", summary.bytes},
                                    {"unsent", summary.unsent},
                                    {"latest_s", summary.latest_s},
                                    {"lost", lost},
                                    {"duplicated", duplicated},
                                    {"cameras", cameras}};
  return json.dump(2) + "\n";
}

}  // namespace rigcal
