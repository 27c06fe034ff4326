#include "apps/commands/live_options.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "apps/commands/option_checks.h"
#include "apps/common/json_text.h"
#include "core/base/version.h"

namespace rigcal {

void add_live_options(CLI::App& command, CLI::Option& live, sim::LiveOptions& options) {
  command.add_option("--speed", options.speed, "With --live: so many times faster than real time (default 1)")
      ->check(number_range(0.01, 100.0))
      ->needs(&live)
      ->option_text("N");
  command.add_flag("--loop", options.loop, "With --live: begin again when the run is over")->needs(&live);
  command
      .add_option("--spin-up", options.device.spin_up_s,
                  "With --live: seconds from switching a device on until it can sample (default 2)")
      ->check(number_range(0.0, 600.0))
      ->needs(&live)
      ->option_text("SECONDS");
  command
      .add_option_function<std::string>(
          "--time-source",
          [&options](const std::string& source) {
            options.time_source = source == "pps"   ? sim::TimeSource::pps
                                  : source == "ptp" ? sim::TimeSource::ptp
                                                    : sim::TimeSource::none;
          },
          "With --live: what the devices' clocks follow: none (default), pps (pulses at full seconds of UTC; with the "
          "time of day from the host they are as with GPS) or ptp")
      ->check(CLI::IsMember({"none", "pps", "ptp"}))
      ->needs(&live)
      ->option_text("SOURCE");
  const auto add_share = [&](const char* name, double& share, const char* text) {
    command.add_option(name, share, text)->check(number_range(0.0, 0.9))->needs(&live)->option_text("SHARE");
  };
  add_share("--control-loss", options.control.drop, "With --live: share of the devices' answers that get lost");
  add_share("--control-duplicate", options.control.duplicate, "With --live: share of answers that come twice");
  add_share("--control-delay", options.control.delay, "With --live: share of answers up to 0.3 s late");
  add_share("--control-stray", options.control.wrong_number, "With --live: share of answers to another request");
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
      ->check(number_range(0.0, 60.0))
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
      .add_option("--table", options.table,
                  "With --live: a turntable on a serial line, a link to which is made here; it turns as the run does, "
                  "in equal steps")
      ->needs(&live)
      ->option_text("PATH");
  command
      .add_flag_callback(
          "--table-ascii", [&options] { options.table_speaks_grbl = false; },
          "With --table: it speaks plain words instead of grbl's G-code")
      ->needs(&live);
  command
      .add_option("--table-jams", options.table_jams_s, "With --table: it turns no more from this second of the run on")
      ->check(number_range(0.0, 1e6))
      ->needs(&live)
      ->option_text("SECONDS");
  command
      .add_option_function<std::vector<std::string>>(
          "--incident",
          [&options](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) options.incidents.push_back(*sim::parse_incident(text));
          },
          "With --live: what happens to a device, for example avia,10,reboot or avia,10,silence,5 or avia,10,taken,5 "
          "(another host has it) or avia,10,status,0x40000001 or avia,10,clock,-2 (it jumps) or "
          "avia,10,refuse,coordinates; may be given several times")
      ->check(CLI::Validator(
          [](const std::string& text) {
            const auto incident = sim::parse_incident(text);
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
  return json_text(json);
}

}  // namespace rigcal
