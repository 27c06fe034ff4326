#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/option_checks.h"
#include "apps/recording/lvx_datagrams.h"
#include "apps/replay/replay.h"
#include "core/base/parse_number.h"

namespace rigcal {
namespace {

/// "192.168.1.5" or "192.168.1.5:56001".
bool read_receiver(const std::string& text, ReplayOptions& options) {
  const std::size_t colon = text.find(':');
  const auto ip = parse_ip(text.substr(0, colon));
  if (!ip) return false;
  options.to = *ip;
  options.to_port = 0;
  if (colon == std::string::npos) return true;
  options.to_port = parse_number<std::uint16_t>(std::string_view(text).substr(colon + 1)).value_or(0);
  return options.to_port != 0;
}

std::string check_receiver(const std::string& text) {
  ReplayOptions ignored;
  return read_receiver(text, ignored) ? std::string()
                                      : "'" + text + "' is no address: write 192.168.1.5 or 192.168.1.5:56001";
}

std::string check_prefix(const std::string& text) {
  const auto ip = parse_ip(text);
  return ip && (*ip)[3] == 0 ? std::string() : "'" + text + "' is no network: write it like 127.0.0.0";
}

// Its end is a good one whether the recording was over or the user stopped it.
Expected<ExitCode> run_replay(const ReplayOptions& options, CommandContext& context) {
  const Expected<ReplaySummary> summary = replay(options, context.run_context());
  if (!summary) return summary.error();
  if (!summary->truncation.empty())
    context.reporter.warn(options.input + " " + summary->truncation + ": played up to there");
  if (context.json) {
    CommandContext::print(replay_json(options, *summary));
  } else if (!context.quiet) {
    CommandContext::print(replay_text(options, *summary));
  }
  return summary->truncation.empty() ? ExitCode::good : ExitCode::not_trustworthy;
}

}  // namespace

void add_replay_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<ReplayOptions>();
  CLI::App* command = app.add_subcommand("replay", "Send what the LiDARs of a recording sent onto the network again");
  command->add_option("INPUT", options->input, "A session, a packet dump or an .lvx recording")->required();
  CLI::Option* to = command
                        ->add_option_function<std::string>(
                            "--to", [options](const std::string& text) { read_receiver(text, *options); },
                            "Plain packets to this address, byte for byte; without a port to the ports as recorded "
                            "(default: to the host to which the LiDARs sent)")
                        ->check(CLI::Validator(check_receiver, ""))
                        ->option_text("ADDRESS[:PORT]");
  CLI::Option* as_devices = command->add_flag(
      "--as-devices", options->as_devices,
      "Virtual devices that hosts find, take and start, and that then stream what was recorded of them");
  as_devices->excludes(to);
  command
      ->add_option_function<std::string>(
          "--network", [options](const std::string& text) { options->network = parse_ip(text); },
          "The LiDARs appear in this network with the last numbers of their addresses, for example 127.0.0.0 on this "
          "machine without privileges (default: at their recorded addresses)")
      ->check(CLI::Validator(check_prefix, ""))
      ->option_text("NETWORK");
  command->add_option("--rig", options->rig, "Rig file, for LiDARs that do not say in the recording what they are")
      ->option_text("RIG");
  command->add_option("--speed", options->speed, "So many times faster than recorded (default 1)")
      ->check(number_range(0.01, 100.0))
      ->option_text("N");
  command->add_flag("--loop", options->loop, "Begin again at the end");
  command
      ->add_option("--spin-up", options->spin_up_s,
                   "With --as-devices: seconds from switching a device on until it can sample (default 2)")
      ->check(number_range(0.0, 600.0))
      ->needs(as_devices)
      ->option_text("SECONDS");
  command->footer("Example:\n  rigcal replay session --as-devices --network 127.0.0.0");
  command->callback([options, to, &context] {
    if (!options->as_devices && to->count() == 0 && is_lvx(options->input))
      throw CLI::RequiredError("--to ADDRESS or --as-devices");
    context.run = [options, &context] { return run_replay(*options, context); };
  });
}

}  // namespace rigcal
