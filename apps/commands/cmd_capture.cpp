#include <stdio_ext.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "apps/calibration/estimate_text.h"
#include "apps/calibration/live_result.h"
#include "apps/capture/capture.h"
#include "apps/capture/capture_dashboard.h"
#include "apps/capture/capture_screen.h"
#include "apps/capture/capture_text.h"
#include "apps/capture/live_datagrams.h"
#include "apps/capture/packet_recorder.h"
#include "apps/commands/calibration_text.h"
#include "apps/commands/command.h"
#include "apps/commands/option_checks.h"
#include "apps/common/byte_size.h"
#include "apps/common/end_at_once.h"
#include "apps/common/service_notify.h"
#include "apps/common/tolerance.h"
#include "apps/web/web_view.h"
#include "core/base/text.h"
#include "core/report/result_folder.h"

namespace rigcal {
namespace {

struct CaptureCommand {
  std::string rig;
  CaptureOptions capture;
  livox::DriverOptions driver;
  int receive_buffer_mib = 8;
  bool calibrate = false;
  std::string target;  ///< Empty: until told otherwise.
  std::string result;  ///< Empty: beside the session.
  bool parts = false;
  std::optional<std::string> web;  ///< Where; empty: the usual place.
};

std::string check_keep(const std::string& text) {
  if (const std::string wrong = check_bytes(text); !wrong.empty()) return wrong;
  if (*parse_bytes(text) < PacketRecorder::kLeastKept) return "less than 17MB cannot be kept";
  return {};
}

// Tells of each estimate once.
class EstimateTeller {
 public:
  explicit EstimateTeller(ConsoleReporter& reporter) : reporter_(reporter) {}
  void tell(const LiveEstimates& known) {
    if (known.estimates.size() < told_) told_ = 0;  // All of it was found anew.
    for (; told_ < known.estimates.size(); ++told_) {
      reporter_.news(estimate_line(known.estimates[told_]));
      for (const std::string& remark : estimate_remarks(known.estimates[told_])) reporter_.news("  " + remark);
    }
  }

 private:
  ConsoleReporter& reporter_;
  std::size_t told_ = 0;
};

// The goal of --target; without one that of `calibrate`.
Expected<Requirement> goal_of(const CaptureCommand& command) {
  if (command.target.empty()) return Requirement{};
  const Expected<Tolerance> target = parse_tolerance(command.target);
  if (!target) return target.error();
  return Requirement{target->translation_m, target->rotation_rad};
}

// SESSION, or where that exists SESSION.2 and so on.
std::string next_part(const std::string& session) {
  std::error_code error;
  std::string path = session;
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  const std::string first = path;
  for (int part = 2; std::filesystem::exists(path, error); ++part) path = first + "." + std::to_string(part);
  return path;
}

std::filesystem::path own_place(const std::string& path) {
  std::error_code error;
  std::filesystem::path place = std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
  return place.has_filename() ? place : place.parent_path();  // It may end with a slash.
}

// Whether it is that folder, or lies in it.
bool lies_in(const std::string& path, const std::string& folder) {
  const std::filesystem::path inner = own_place(path);
  const std::filesystem::path outer = own_place(folder);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

std::string check_web(const std::string& text) {
  const Expected<WebAddress> address = parse_web_address(text);
  return address ? std::string() : address.error().message();
}

std::string result_folder(const CaptureCommand& command) {
  if (!command.result.empty()) return command.result;
  std::string session = command.capture.out;
  while (session.size() > 1 && session.back() == '/') session.pop_back();
  return session + "_result";
}

// The session is there whatever becomes of its calibration: what keeps that from being done is a warning.
std::optional<LiveResult> calibrate_in_the_end(const CaptureCommand& command, const CaptureSummary& summary,
                                               LiveCalibration& calibration, WebView* page, CaptureScreen& screen) {
  if (!summary.reading) {
    screen.warn("no calibration: the stops of the session could not be read to its end");
    return std::nullopt;
  }
  // Told to end is a normal end of the capture, not of this.
  const auto tell = [&screen, page](const CalibrationResult& numbers, double after_s) {
    if (page != nullptr) page->show_result(numbers);
    screen.tell("the extrinsics stand " + fixed_text(after_s, 1) + " s after the end of the recording, " +
                to_string(numbers.status) + "; map and report follow");
  };
  Expected<LiveResult> result = finish_live(summary.session, *summary.reading, summary.forgotten_until_ns, calibration,
                                            result_folder(command), RunContext{screen, {}}, tell);
  if (!result) {
    screen.warn("no calibration: " + result.error().message());
    return std::nullopt;
  }
  return std::move(*result);
}

// Nobody may read it any more (`| head`). The session is there all the same, and how it is stays what the exit code
// says.
void print_if_anybody_reads(const std::string& text, ConsoleReporter& reporter) {
  CommandContext::print(text);
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  reporter.warn("the summary could not be written to standard output");
  __fpurge(stdout);  // What is left of it would be tried again at the program's end.
  std::clearerr(stdout);
}

Expected<ExitCode> run_capture(CaptureCommand command, CommandContext& context) {
  std::signal(SIGPIPE, SIG_IGN);  // Ctrl-C ends who reads the output (`| tee log`), too; the recording is what counts.
  const Expected<Rig> rig = load_rig(command.rig);
  if (!rig) return rig.error();
  const auto devices = driver_options(*rig);
  if (!devices) {
    Error error = devices.error();
    error.where = command.rig + ": " + error.where;
    return error;
  }
  livox::DriverOptions driver = *devices;  // What the rig says; the rest is the command line's.
  driver.bind_to_interface = command.driver.bind_to_interface;
  driver.realtime = command.driver.realtime;
  driver.lock_memory = command.driver.lock_memory;
  driver.receive_bytes = static_cast<std::size_t>(command.receive_buffer_mib) << 20U;
  const Expected<Requirement> goal = goal_of(command);
  if (!goal) return goal.error();
  std::optional<LiveCalibration> calibration;
  if (command.calibrate || !command.target.empty()) {
    if (const auto target = check_result_target(result_folder(command)); !target) return target.error();
    calibration.emplace(*rig, *goal, command.capture.out, command.web.has_value());
    command.capture.sink = &calibration->sink();
  }
  if (!command.target.empty()) command.capture.is_enough = [&calibration] { return calibration->has_reached_goal(); };
  command.capture.give_up = [](const std::string& words) {
    end_at_once("rigcal: error: " + words + "\n", ExitCode::system);
  };
  std::unique_ptr<WebView> page;
  if (command.web) {
    auto started = WebView::start(*parse_web_address(*command.web), *rig, command.capture.out,
                                  calibration ? &*calibration : nullptr);
    if (started) {
      page = *std::move(started);
      context.reporter.say("the page is at " + page->url());
    } else {
      context.reporter.warn("recorded without a page: " + started.error().message());
    }
  }
  ServiceNotify service;
  std::uint64_t told = 0;
  EstimateTeller teller(context.reporter);
  const auto draw = [&](const CaptureStatus& status) {
    const LiveEstimates known = calibration ? calibration->estimates() : LiveEstimates{};
    teller.tell(known);
    if (known.left_out > 0) context.reporter.warn(LiveCalibration::kLeftOutText);
    for (const std::string& line : new_lines(status, told)) context.reporter.news(line);
    told = status.events;
    std::vector<std::string> lines;
    if (calibration) {
      if (!known.estimates.empty()) lines = estimate_block(known.estimates.back());
      lines.insert(lines.begin(), lines.empty() ? "calibration: waits for the first stop" : "calibration:");
    }
    context.reporter.block(dashboard_lines(status, lines));
  };
  const auto tell = [&](const std::string& line) {
    context.reporter.clear();
    context.reporter.say(line);
  };
  CaptureScreen screen(context.reporter, draw, tell);
  const auto show = [&](const CaptureStatus& status) {
    service.alive(to_string(status.progress.state) + std::string(", ") + std::to_string(status.progress.stops) +
                  " stops");
    if (page) page->show(status);
    screen.show(status);
  };
  const Expected<CaptureSummary> summary =
      capture(*rig, driver, command.capture, {screen, context.run_context().stop}, show);
  service.stopping();
  std::optional<LiveResult> result;
  if (summary) screen.show(summary->status);  // With what happened last, and the last estimates.
  if (summary && calibration) {
    screen.show_progress();
    result = calibrate_in_the_end(command, *summary, *calibration, page.get(), screen);
    if (result) result->estimates = calibration->estimates().estimates;
  }
  screen.finish();  // What nobody takes is waited for only now that all is done.
  context.reporter.clear();
  if (!summary) return summary.error();
  const std::vector<Shortfall> shortfalls = summary->shortfalls();
  const bool is_anybody_there = shortfalls.empty() || shortfalls.front().kind != Shortfall::Kind::no_lidar;
  if (is_anybody_there) {  // Otherwise the error says it.
    for (const Shortfall& shortfall : shortfalls) context.reporter.warn(shortfall.message());
  }
  if (context.json) {
    print_if_anybody_reads(capture_json(*summary, result ? &*result : nullptr), context.reporter);
  } else if (!context.quiet) {
    std::string text = capture_text(*summary);
    if (result) text += calibration_text(result->result, result->out);
    print_if_anybody_reads(text, context.reporter);
  }
  if (!is_anybody_there) return system_error(shortfalls.front().text, command.rig, shortfalls.front().mend);
  for (const Shortfall& shortfall : shortfalls)
    if (shortfall.error) return *shortfall.error;
  if (calibration && (!result || result->result.status != Status::good)) return ExitCode::not_trustworthy;
  return shortfalls.empty() ? ExitCode::good : ExitCode::not_trustworthy;
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
      ->check(named_path())
      ->option_text("SESSION");
  command
      ->add_option_function<double>(
          "--duration", [options](double seconds) { options->capture.duration_s = seconds; },
          "Stop after so many seconds (default: when told to)")
      ->check(number_range(0.1, 1e7))
      ->option_text("S");
  command
      ->add_option("--stops", options->capture.goal.stops,
                   "End when the rig has stood still at so many places (default: when told to)")
      ->check(CLI::Range(1, 10'000))
      ->option_text("N");
  command
      ->add_option("--dwell", options->capture.goal.dwell_s,
                   "Seconds of rest that a stop is to have before the rig is turned on (default 1)")
      ->check(number_range(0.5, 3600.0))
      ->option_text("S");
  command
      ->add_option("--table-timeout", options->capture.goal.table_s,
                   "Seconds that a table on a serial line may take for a step (default 60)")
      ->check(number_range(1.0, 3600.0))
      ->option_text("S");
  command->add_flag(
      "--parts", options->parts,
      "Where SESSION exists, record the next part beside it: SESSION.2 (for services that are restarted)");
  command
      ->add_option_function<std::string>(
          "--web", [options](const std::string& text) { options->web = text; },
          "Show it as a web page, to this machine alone unless another address is given (default 127.0.0.1:8340)")
      ->expected(0, 1)
      ->check(CLI::Validator(check_web, ""))
      ->option_text("[ADDR:PORT]");
  command->add_flag("--calibrate", options->calibrate,
                    "Solve as it goes: after each stop what is known by then, at the end the result");
  command
      ->add_option("--target", options->target,
                   "Solve as it goes, and end when every LiDAR is as sure as this (95 % bounds)")
      ->check(CLI::Validator(check_tolerance, ""))
      ->option_text("MM,DEG");
  command
      ->add_option("--result", options->result,
                   "Where the result of --calibrate goes (default: SESSION_result); an older one is replaced")
      ->check(named_path())
      ->option_text("RESULT");
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
  command->callback([options, &context] {
    if (!options->result.empty() && !options->calibrate && options->target.empty())
      throw CLI::ValidationError("--result", "there is none without --calibrate or --target; add one of them");
    if (options->parts) options->capture.out = next_part(options->capture.out);
    // A result takes the place of its folder as a whole.
    if (!options->result.empty() && lies_in(options->capture.out, options->result))
      throw CLI::ValidationError("--result", "the session would lie there; choose another place for the result");
    context.run = [=, &context] { return run_capture(*options, context); };
  });
}

}  // namespace rigcal
