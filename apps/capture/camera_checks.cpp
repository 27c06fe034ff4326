#include "apps/capture/camera_checks.h"

#include <algorithm>
#include <chrono>

#include "core/base/seconds.h"

namespace rigcal {
namespace {

constexpr int frames_to_see = 5;
constexpr std::int64_t look_ns = 100'000'000;

CameraFinding survey(const RigCamera& wanted, CameraDrivers& drivers, double seconds, const std::stop_token& stop) {
  CameraFinding finding;
  finding.sensor = wanted.sensor;
  const auto opened = drivers.make(wanted.driver);
  auto setup = prepare(*opened, wanted);
  finding.identity = opened->identity();
  finding.notes = opened->notes();
  if (!setup) {
    finding.trouble = setup.error();
    return finding;
  }
  finding.setup = *std::move(setup);
  if (wanted.config.trigger && !wanted.is_told) {
    finding.trigger = wanted.config.trigger->source;
    return finding;
  }
  if (const auto started = opened->start(); !started) {
    finding.trouble = started.error();
    return finding;
  }
  const auto end = SteadyClock::now() + std::chrono::duration<double>(seconds);
  for (int frames = 0; frames < frames_to_see && SteadyClock::now() < end && !stop.stop_requested();) {
    if (wanted.is_told) static_cast<void>(opened->trigger());
    const auto delivery = opened->next(look_ns);
    if (delivery && delivery->kind == camera::Delivery::Kind::frame) ++frames;
  }
  finding.counters = opened->counters();
  return finding;
}

/// A frame's packets have to fit the network.
void check_packets(const CameraFinding& finding, const std::vector<net::Interface>& interfaces,
                   std::vector<Check>& checks) {
  const auto ip = parse_ip(finding.identity.address);
  if (!ip || !finding.setup.packet_bytes) return;
  for (const net::Interface& interface : interfaces) {
    if (interface.mtu <= 0 || !net::is_in_subnet(interface, *ip)) continue;
    if (*finding.setup.packet_bytes <= interface.mtu) continue;
    checks.push_back({CheckLevel::bad, finding.sensor,
                      "its packets of " + std::to_string(*finding.setup.packet_bytes) + " bytes do not fit " +
                          interface.name + " with its MTU of " + std::to_string(interface.mtu),
                      "sudo ip link set " + interface.name + " mtu 9000, or leave packet_size out of the rig file"});
  }
}

void check_one(const CameraFinding& finding, const std::vector<net::Interface>& interfaces,
               std::vector<Check>& checks) {
  if (finding.trouble) {
    checks.push_back({CheckLevel::bad, finding.sensor, finding.trouble->what, finding.trouble->mend});
    return;
  }
  const camera::CameraSetup& setup = finding.setup;
  std::string who = finding.identity.model + " at " + finding.identity.address + ", " + finding.identity.link + ", " +
                    setup.pixel_format + " " + std::to_string(setup.width) + " x " + std::to_string(setup.height);
  if (setup.packet_bytes) who += ", packets of " + std::to_string(*setup.packet_bytes) + " bytes";
  if (!finding.trigger.empty()) who += ", waits for pulses on " + finding.trigger;
  checks.push_back({CheckLevel::good, finding.sensor, who, {}});
  for (const std::string& note : setup.notes)
    checks.push_back({CheckLevel::warning, finding.sensor, note, "if that matters, change what limits the camera"});
  for (const std::string& note : finding.notes) checks.push_back({CheckLevel::good, finding.sensor, note, {}});
  check_packets(finding, interfaces, checks);
  if (!finding.trigger.empty()) return;
  if (finding.counters.whole() == 0) {
    checks.push_back({CheckLevel::bad, finding.sensor, "sends no whole frame",
                      setup.packet_bytes ? "let UDP through the firewall; look at its cable and switch"
                                         : "plug it into another port"});
  } else if (finding.counters.damaged() + finding.counters.missing > 0) {
    checks.push_back(
        {CheckLevel::warning, finding.sensor,
         std::to_string(finding.counters.damaged()) + " frames were damaged and " +
             std::to_string(finding.counters.missing) + " missing",
         "raise the receive buffer, give its packets a delay (packet_delay), and look at cable and switch"});
  }
}

}  // namespace

std::vector<CameraFinding> survey_cameras(const std::vector<RigCamera>& cameras, CameraDrivers& drivers, double seconds,
                                          const std::stop_token& stop) {
  std::vector<CameraFinding> findings;
  for (const RigCamera& wanted : cameras) {
    if (!stop.stop_requested()) findings.push_back(survey(wanted, drivers, seconds, stop));
  }
  return findings;
}

std::vector<Check> check_cameras(const std::vector<CameraFinding>& findings,
                                 const std::vector<camera::CameraIdentity>& there,
                                 const std::vector<net::Interface>& interfaces) {
  std::vector<Check> checks;
  for (const CameraFinding& finding : findings) check_one(finding, interfaces, checks);
  for (const camera::CameraIdentity& camera : there) {
    const bool is_of_rig = std::any_of(findings.begin(), findings.end(), [&camera](const CameraFinding& finding) {
      return finding.identity.address == camera.address;
    });
    if (!is_of_rig) {
      checks.push_back(
          {CheckLevel::good, "camera", camera.id + " is there, " + camera.link + " at " + camera.address, {}});
    }
  }
  return checks;
}

}  // namespace rigcal
