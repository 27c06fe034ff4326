#include <CLI/CLI.hpp>
#include <charconv>
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "apps/capture.h"
#include "apps/capture_dashboard.h"
#include "apps/capture_text.h"
#include "apps/command.h"
#include "apps/live_datagrams.h"
#include "apps/packet_recorder.h"

namespace rigcal {
namespace {

struct CaptureCommand {
  std::string rig;
  CaptureOptions capture;
  livox::DriverOptions driver;
  int receive_buffer_mib = 8;
};

// "4GB", "500 MB", "1.5GiB"; nothing where it is none.
std::optional<std::uint64_t> parse_bytes(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !(value > 0.0) || value > 1e9) return std::nullopt;
  std::string unit(end, text.data() + text.size());
  if (!unit.empty() && unit.front() == ' ') unit.erase(0, 1);
  constexpr std::pair<const char*, double> units[] = {
      {"MB", 1e6}, {"GB", 1e9}, {"TB", 1e12}, {"MiB", 1048576.0}, {"GiB", 1073741824.0}};
  for (const auto& [name, bytes] : units)
    if (unit == name) return static_cast<std::uint64_t>(value * bytes);
  return std::nullopt;
}

std::string check_keep(const std::string& text) {
  const auto bytes = parse_bytes(text);
  if (!bytes) return "write a size like 4GB or 500MB, not '" + text + "'";
  if (*bytes < PacketRecorder::kLeastKept) return "less than 17MB cannot be kept";
  return {};
}

Expected<ExitCode> run_capture(CaptureCommand command, CommandContext& context) {
  std::signal(SIGXFSZ, SIG_IGN);  // A file that may not grow is an error like a full disk, and no end of the program.
  const Expected<Rig> rig = load_rig(command.rig);
  if (!rig) return rig.error();
  const auto devices = driver_options(*rig);
  if (!devices) return devices.error();
  command.driver.devices = devices->devices;
  command.driver.interface = devices->interface;
  command.driver.host_ip = devices->host_ip;
  command.driver.receive_bytes = static_cast<std::size_t>(command.receive_buffer_mib) << 20U;
  std::uint64_t told = 0;
  const auto show = [&context, &told](const CaptureStatus& status) {
    for (const std::string& line : new_lines(status, told)) context.reporter.news(line);
    told = status.events;
    context.reporter.block(dashboard_lines(status));
  };
  const Expected<CaptureSummary> summary = capture(*rig, command.driver, command.capture, context.run_context(), show);
  context.reporter.clear();
  if (!summary) return summary.error();
  if (context.json) {
    CommandContext::print(capture_json(*summary));
  } else if (!context.quiet) {
    CommandContext::print(capture_text(*summary));
  }
  bool is_anybody_there = false;
  for (const CaptureDevice& device : summary->status.devices)
    is_anybody_there = is_anybody_there || device.report.packets > 0;
  if (!is_anybody_there)
    return system_error("no LiDAR of the rig has sent anything", command.rig,
                        "rigcal doctor --rig RIG tells what keeps them from it");
  return summary->is_complete() ? ExitCode::good : ExitCode::not_trustworthy;
}

}  // namespace

void add_capture_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<CaptureCommand>();
  CLI::App* command = app.add_subcommand(
      "capture", "Record the LiDARs and cameras of a rig into a session until told to stop (Ctrl-C)");
  command->add_option("--rig", options->rig, "Rig file; its LiDARs and cameras are found, set up and started")
      ->required()
      ->option_text("RIG");
  command->add_option("--out", options->capture.out, "Session to make; must not exist")
      ->required()
      ->option_text("SESSION");
  command
      ->add_option_function<double>(
          "--duration", [options](double seconds) { options->capture.duration_s = seconds; },
          "Stop after so many seconds (default: when told to)")
      ->check(CLI::Range(0.1, 1e7))
      ->option_text("S");
  command
      ->add_option("--stops", options->capture.goal.stops,
                   "End when the rig has stood still at so many places (default: when told to)")
      ->check(CLI::Range(1, 10'000))
      ->option_text("N");
  command
      ->add_option("--dwell", options->capture.goal.dwell_s,
                   "Seconds of rest that a stop is to have before the rig is turned on (default 1)")
      ->check(CLI::Range(0.5, 3600.0))
      ->option_text("S");
  command
      ->add_option("--table-timeout", options->capture.goal.table_s,
                   "Seconds that a table on a serial line may take for a step (default 60)")
      ->check(CLI::Range(1.0, 3600.0))
      ->option_text("S");
  command
      ->add_option_function<std::string>(
          "--keep", [options](const std::string& text) { options->capture.keep_bytes = *parse_bytes(text); },
          "Keep only the newest packets, so many bytes (default: all)")
      ->check(CLI::Validator(check_keep, ""))
      ->option_text("SIZE");
  command->add_option("--receive-buffer", options->receive_buffer_mib, "MiB of socket buffer to ask for (default 8)")
      ->check(CLI::Range(1, 1024))
      ->option_text("MIB");
  command->add_flag("--realtime", options->driver.realtime, "Receive with real-time priority, where that is permitted");
  command->add_flag("--lock-memory", options->driver.lock_memory, "Keep the program's memory from being swapped out");
  command->add_flag("--bind-interface", options->driver.bind_to_interface,
                    "Keep each socket to its interface (SO_BINDTODEVICE; needs CAP_NET_RAW)");
  command->footer("Example:\n  rigcal capture --rig turntable --out session --stops 20");
  command->callback([options, &context] { context.run = [=, &context] { return run_capture(*options, context); }; });
}

}  // namespace rigcal
