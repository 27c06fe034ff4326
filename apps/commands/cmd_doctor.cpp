#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "apps/capture/camera_checks.h"
#include "apps/capture/doctor.h"
#include "apps/capture/live_datagrams.h"
#include "apps/capture/machine_checks.h"
#include "apps/commands/command.h"
#include "apps/commands/known_files.h"
#include "apps/commands/option_checks.h"
#include "apps/recording/batch_source.h"
#include "core/base/seconds.h"
#include "drivers/net/socket_limits.h"

namespace rigcal {
namespace {

struct DoctorOptions {
  std::string rig;
  double seconds = 5.0;
};

constexpr const char* nobody = "LiDAR";  // What is said of LiDARs where no rig names them.

std::vector<Check> list_all(const std::vector<net::Interface>& interfaces) {
  std::vector<Check> checks;
  for (const net::Interface& interface : interfaces)
    checks.push_back({CheckLevel::good,
                      "interface " + interface.name,
                      to_string(interface.ip) + "/" + std::to_string(net::prefix_length(interface.mask)) + ", MTU " +
                          std::to_string(interface.mtu) + (interface.is_up ? "" : ", down"),
                      {}});
  return checks;
}

// Who broadcasts; nobody is taken.
Expected<std::vector<Check>> listen(double seconds, CommandContext& context) {
  auto socket = net::UdpSocket::open({{{0, 0, 0, 0}, livox::kDiscoveryPort}, true, false, 0, {}});
  if (!socket) return socket.error();
  auto waiter = net::Waiter::create({socket->descriptor()});
  if (!waiter) return waiter.error();
  net::ReceiveBatch batch(16);
  std::map<std::string, std::string> heard;
  const auto start = SteadyClock::now();
  const auto passed = [&start] { return seconds_since(start); };
  while (passed() < seconds && !context.stop.stop_requested()) {
    context.reporter.progress("listen", passed() / seconds);
    waiter->wait(100'000'000);
    const auto count = socket->receive(batch);
    if (!count) return count.error();
    for (std::size_t i = 0; i < *count && heard.size() < livox::kMaxSightings; ++i) {
      const auto frame = livox::parse_control_frame(batch[i].bytes);
      if (!frame || !livox::is_broadcast(*frame)) continue;
      const auto broadcast = livox::parse_broadcast(*frame);
      if (!broadcast) continue;
      heard[broadcast->broadcast_code] = livox::model_name(broadcast->type) + " " + broadcast->broadcast_code + " at " +
                                         to_string(batch[i].from.ip) + " waits for a host";
    }
  }
  std::vector<Check> checks;
  for (const auto& [code, text] : heard) checks.push_back({CheckLevel::good, nobody, text, {}});
  if (heard.empty())
    checks.push_back(
        {CheckLevel::warning, nobody, "none was heard",
         "look at power and cables, let UDP port 55000 through the firewall, end programs that have them"});
  return checks;
}

// Takes the LiDARs of the rig for some seconds.
Expected<std::vector<Check>> examine(const Rig& rig, const std::string& rig_file, double seconds,
                                     CommandContext& context) {
  const auto options = driver_options(rig);
  if (!options) {
    Error error = options.error();
    error.where = rig_file + ": " + error.where;
    return error;
  }
  auto driver = livox::Driver::start(*options);
  if (!driver) return driver.error();
  LidarFindings findings;
  for (const Sensor& sensor : rig.sensors)
    if (sensor.is_livox()) findings.sensors.push_back(sensor.name);
  LidarIngest ingest(rig, {}, {});
  Datagram datagram;
  const auto start = SteadyClock::now();
  const auto passed = [&start] { return seconds_since(start); };
  while (passed() < seconds && !context.stop.stop_requested()) {
    context.reporter.progress("examine", passed() / seconds);
    for (int i = 0; i < 1000 && (*driver)->next(datagram, 50'000'000); ++i) ingest.add(datagram);
  }
  findings.devices = (*driver)->devices();
  findings.sightings = (*driver)->control().sightings();
  (*driver)->stop();
  findings.ingest = ingest.summary();
  std::vector<Check> checks = check_lidars(rig, findings);
  const FileNotes notes = LiveDatagrams(**driver, nullptr, {}).notes();
  // Each says its own mend.
  for (const std::string& note : notes.findings) checks.push_back({CheckLevel::warning, "network", note, {}});
  return checks;
}

bool has_livox(const Rig& rig) {
  return std::any_of(rig.sensors.begin(), rig.sensors.end(), [](const Sensor& sensor) { return sensor.is_livox(); });
}

/// What keeps this machine from its LiDARs is one finding among others; a rig file that is wrong is an error.
Expected<std::vector<Check>> look_at_lidars(const Rig* rig, const DoctorOptions& options, CommandContext& context) {
  if (rig != nullptr && !has_livox(*rig)) return std::vector<Check>{};
  auto checks =
      rig == nullptr ? listen(options.seconds, context) : examine(*rig, options.rig, options.seconds, context);
  if (checks || checks.error().kind == ErrorKind::input) return checks;
  const Error& error = checks.error();
  return std::vector<Check>{
      {CheckLevel::bad, "LiDARs", error.where.empty() ? error.what : error.where + ": " + error.what, error.mend}};
}

/// Takes the cameras of the rig, one after the other; without a rig they are only listed.
std::vector<Check> look_at_cameras(const Rig* rig, double seconds, const std::vector<net::Interface>& interfaces,
                                   CommandContext& context) {
  CameraDrivers drivers(camera_settings_folder());
  const std::vector<RigCamera> wanted = rig == nullptr ? std::vector<RigCamera>{} : rig_cameras(*rig);
  if (rig != nullptr && wanted.empty()) return {};
  const std::vector<camera::CameraIdentity> there = drivers.enumerate();
  return check_cameras(survey_cameras(wanted, drivers, seconds, context.stop), there, interfaces);
}

Expected<ExitCode> run_doctor(const DoctorOptions& options, CommandContext& context) {
  const auto interfaces = net::list_interfaces();
  if (!interfaces) return interfaces.error();
  std::vector<Check> checks = list_all(*interfaces);
  checks.push_back(check_receive_buffer(net::largest_receive_buffer(), livox::DriverOptions{}.receive_bytes));
  checks.push_back(check_discovery_port(net::port_holders(livox::kDiscoveryPort)));
  std::optional<Rig> rig;
  if (!options.rig.empty()) {
    Expected<Rig> loaded = load_rig(options.rig);
    if (!loaded) return loaded.error();
    rig = *std::move(loaded);
  }
  const Rig* const known = rig ? &*rig : nullptr;
  for (Check& check : check_machine(find_machine(known), known, shipped_file("udev/install")))
    checks.push_back(std::move(check));
  if (known != nullptr)
    for (Check& check : check_network(*known, *interfaces)) checks.push_back(std::move(check));
  const auto lidars = look_at_lidars(known, options, context);
  if (!lidars) return lidars.error();
  const std::vector<Check> cameras = look_at_cameras(known, options.seconds, *interfaces, context);
  const bool all_is_heard = std::none_of(lidars->begin(), lidars->end(), [](const Check& check) {
    return check.level == CheckLevel::bad || (check.about == nobody && check.level != CheckLevel::good);
  });
  for (Check& check : check_firewalls(net::active_firewalls(), all_is_heard)) checks.push_back(std::move(check));
  checks.insert(checks.end(), lidars->begin(), lidars->end());
  checks.insert(checks.end(), cameras.begin(), cameras.end());
  if (context.json) {
    CommandContext::print(checks_json(checks));
  } else if (!context.quiet) {
    CommandContext::print(checks_text(checks));
  }
  switch (worst_of(checks)) {
    case CheckLevel::good:
      return ExitCode::good;
    case CheckLevel::warning:
      return ExitCode::not_trustworthy;
    case CheckLevel::bad:
      break;
  }
  return ExitCode::system;
}

}  // namespace

void add_doctor_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<DoctorOptions>();
  CLI::App* command =
      app.add_subcommand("doctor", "Check this machine and the LiDARs, cameras and trigger lines of a rig");
  command
      ->add_option("--rig", options->rig,
                   "Rig file; its LiDARs and cameras are taken for some seconds. Without: only listen")
      ->option_text("RIG");
  command->add_option("--seconds", options->seconds, "How long to look at the LiDARs (default 5)")
      ->check(number_range(0.5, 3600.0))
      ->option_text("S");
  command->footer("Example:\n  rigcal doctor --rig turntable");
  command->callback([options, &context] { context.run = [=, &context] { return run_doctor(*options, context); }; });
}

}  // namespace rigcal
