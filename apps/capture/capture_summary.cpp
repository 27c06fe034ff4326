#include "apps/capture/capture_summary.h"

#include <algorithm>

#include "core/base/seconds.h"
#include "core/base/text.h"
#include "core/base/utc_text.h"

namespace rigcal {
namespace {

using ShortfallKind = Shortfall::Kind;

const char* reason_of_nothing(const livox::LinkInfo& link) {
  if (link.firmware != livox::FirmwareVersion{})
    return ", though it answered: let UDP through the firewall of this machine (rigcal doctor tells how)";
  return link.counters.handshakes > 0 ? ", though its broadcasts were heard" : ": no broadcast of it was heard";
}

Shortfall never_sent(const std::string& sensor) {
  const std::string text = "it never sent anything";
  return {.kind = ShortfallKind::never_sent, .about = sensor, .text = text, .remark = ": " + text};
}

Shortfall connection_lost(const std::string& sensor, std::uint64_t losses) {
  return {.kind = ShortfallKind::connection_lost,
          .about = sensor,
          .text = "its connection was lost " + counted(losses, "time")};
}

void add_shortfalls(const CaptureSummary& summary, const CaptureDevice& device, std::vector<Shortfall>& all) {
  const std::string& sensor = device.sensor;
  const livox::LinkInfo& link = device.report.link;
  if (device.report.packets == 0) {
    Shortfall& nothing = all.emplace_back(never_sent(sensor));
    nothing.gap = utc_text(summary.start_ns) + " " + nothing.message() + reason_of_nothing(link);
    return;
  }
  const std::uint64_t losses = link.counters.losses;
  const std::uint64_t interruptions = link.counters.interruptions;  // Also those by losses.
  const std::string interrupted = "interrupted " + counted(interruptions, "time");
  if (losses > 0) all.push_back(connection_lost(sensor, losses));
  if (interruptions > losses)
    all.push_back({.kind = ShortfallKind::interrupted, .about = sensor, .text = "it was " + interrupted});
  if (interruptions > 0) all.back().remark = ", " + interrupted;  // Of one of these: there is one then.
  const std::int64_t last_ns = device.report.last_packet_ns;
  if (const std::int64_t silence_ns = summary.end_ns - last_ns; silence_ns > longest_silence_ns) {
    const std::string seconds = std::to_string(silence_ns / ns_per_second) + " s";
    all.push_back({.kind = ShortfallKind::fell_silent,
                   .about = sensor,
                   .text = "nothing came from it in the last " + seconds,
                   .remark = ", nothing in the last " + seconds,
                   .gap = utc_text(last_ns) + " " + sensor + ": nothing came any more until the end, " +
                          fixed_text(seconds_of_ns(silence_ns), 1) + " s"});
  }
  for (const livox::MissingSetting& missing : link.missing_settings)
    all.push_back({.kind = ShortfallKind::setting_missing,
                   .about = sensor,
                   .text = livox::missing_text(missing.setting, missing.outcome),
                   .mend = livox::mend_of_missing(missing.outcome),
                   .remark = ", `" + missing.setting + "` not in force"});
}

void add_shortfalls(const CaptureCamera& camera, std::vector<Shortfall>& all) {
  if (camera.failure) {
    const std::string text = "its images could not be written any more";
    all.push_back({.kind = ShortfallKind::images_unwritten,
                   .about = camera.sensor,
                   .text = text,
                   .remark = ": " + text,
                   .error = camera.failure});
  } else if (camera.written == 0) {
    all.push_back(never_sent(camera.sensor));
  }
  if (const std::uint64_t dropped = camera.dropped_by_queue + camera.counters.no_buffer; dropped > 0)
    all.push_back({.kind = ShortfallKind::lost_here,
                   .about = camera.sensor,
                   .text = std::to_string(dropped) + " frames were lost in this machine"});
  if (camera.counters.losses > 0) all.push_back(connection_lost(camera.sensor, camera.counters.losses));
}

void add_shortfalls(const livox::InterfaceReport& report, std::vector<Shortfall>& all) {
  const std::uint64_t dropped = report.counters.dropped_by_kernel + report.counters.dropped_by_queue;
  if (dropped == 0) return;
  all.push_back({.kind = ShortfallKind::lost_here,
                 .about = name_of(report.interface),
                 .text = std::to_string(dropped) + " packets were lost in this machine"});
}

void add_shortfalls(const CaptureProgress& progress, std::vector<Shortfall>& all) {
  if (progress.state == CaptureState::failed) all.push_back({.kind = ShortfallKind::failed, .text = progress.failure});
  if (progress.stops < progress.wanted_stops)
    all.push_back({.kind = ShortfallKind::stops_missing,
                   .text = "only " + std::to_string(progress.stops) + " of " + std::to_string(progress.wanted_stops) +
                           " stops are in"});
}

}  // namespace

std::string Shortfall::message() const {
  return (about.empty() ? "" : about + ": ") + text + (mend.empty() ? "" : ": " + mend);
}

std::vector<Shortfall> CaptureSummary::shortfalls() const {
  std::vector<Shortfall> all;
  if (std::none_of(status.devices.begin(), status.devices.end(),
                   [](const CaptureDevice& device) { return device.report.packets > 0; }))
    all.push_back({.kind = ShortfallKind::no_lidar,
                   .text = "no LiDAR of the rig has sent anything",
                   .mend = "rigcal doctor --rig RIG tells what keeps them from it"});
  for (const CaptureDevice& device : status.devices) add_shortfalls(*this, device, all);
  for (const livox::InterfaceReport& report : interfaces) add_shortfalls(report, all);
  if (dropped_control > 0)
    all.push_back({.kind = ShortfallKind::lost_here,
                   .text = std::to_string(dropped_control) + " control frames were not recorded"});
  for (const CaptureCamera& camera : status.cameras) add_shortfalls(camera, all);
  if (status.live.failure)
    all.push_back({.kind = ShortfallKind::stops_unread,
                   .text = "the stops could not be found while it was recorded: " + status.live.failure->message()});
  add_shortfalls(status.progress, all);
  return all;
}

}  // namespace rigcal
