#include "apps/capture/capture_record.h"

#include <algorithm>
#include <cstdlib>

#include "core/base/text.h"
#include "core/base/utc_text.h"

namespace rigcal {
namespace {

constexpr std::int64_t pair_period_ns = 10'000'000'000;
constexpr std::int64_t pair_step_ns = 1'000;
constexpr std::size_t most_pairs = 1U << 20U;

void list_gaps(const std::string& sensor, const char* what, const StreamBook& book, std::vector<std::string>& gaps) {
  std::uint64_t listed = 0;
  for (const StreamGap& gap : book.listed_gaps) {
    gaps.push_back(utc_text(gap.start_ns) + " " + sensor + ": " + std::to_string(gap.lost) + " " + what +
                   " are missing, " + fixed_text(1e-6 * static_cast<double>(gap.length_ns), 1) + " ms");
    listed += gap.lost;
  }
  if (book.lost > listed && !book.listed_gaps.empty())
    gaps.push_back(utc_text(book.listed_gaps.back().start_ns) + " " + sensor + ": and after that " +
                   std::to_string(book.lost - listed) + " more " + what);
}

std::uint64_t microseconds(double seconds) { return static_cast<std::uint64_t>(1e6 * seconds); }

}  // namespace

void ClockPairs::add(const net::ClockReading& reading) {
  if (!pairs_.empty() && reading.monotonic_ns - pairs_.back().monotonic_ns < pair_period_ns) {
    const std::int64_t step =
        (reading.realtime_ns - reading.monotonic_ns) - (pairs_.back().realtime_ns - pairs_.back().monotonic_ns);
    if (std::abs(step) < pair_step_ns) return;
  }
  if (pairs_.size() < most_pairs) pairs_.push_back({reading.realtime_ns, reading.monotonic_ns});
}

std::vector<std::string> stream_gaps(const Rig& rig, const IngestSummary& ingest) {
  std::vector<std::string> gaps;
  for (const DeviceIngest& device : ingest.devices) {
    if (device.sensor < 0) continue;
    const std::string& name = rig.sensors[static_cast<std::size_t>(device.sensor)].name;
    list_gaps(name, "packets of points", device.point_stream, gaps);
    list_gaps(name, "packets of the IMU", device.imu_stream, gaps);
  }
  return gaps;
}

NamedCounters link_counters(const livox::LinkCounters& counters) {
  return {{"handshakes", counters.handshakes},
          {"repeated_requests", counters.repeated},
          {"stray_acks", counters.stray_acks},
          {"unreadable_acks", counters.unreadable},
          {"refused_heartbeats", counters.refused_heartbeats},
          {"utc_taken", counters.utc_taken},
          {"utc_refused", counters.utc_refused}};
}

NamedCounters control_counters(const livox::ControlCounters& counters) {
  return {{"malformed", counters.protocol.malformed},  {"strangers", counters.protocol.strangers},
          {"receive_errors", counters.receive_errors}, {"dropped_by_kernel", counters.dropped_by_kernel},
          {"send_errors", counters.send_errors},       {"unsent", counters.unsent},
          {"lost_events", counters.lost_events}};
}

NamedCounters matching_counters(const MatchLedger& ledger) {
  return {{"matched", ledger.matched},
          {"doubled", ledger.doubled},
          {"without_pulse", ledger.without_pulse},
          {"doubtful", ledger.doubtful + ledger.strays},
          {"pulses_without_frame", ledger.pulses_without_frame},
          {"pulses_too_soon", ledger.pulses_too_soon},
          {"pulses_out_of_order", ledger.pulses_out_of_order},
          {"frames_lost", ledger.frames_lost},
          {"id_jumps", ledger.id_jumps}};
}

NamedCounters trigger_counters(const trigger::TriggerReport& report) {
  return {{"pulses", report.pulses},
          {"skipped", report.skipped},
          {"held", report.held},
          {"strobe_pulses", report.strobe_pulses},
          {"strobe_lost", report.strobe_lost},
          {"strobe_mended", report.strobe_mended},
          {"pps_pulses", report.pps_pulses},
          {"pps_lost", report.pps_lost},
          {"dropped_events", report.dropped_events},
          {"connection_losses", report.losses}};
}

SessionCounters capture_counters(const Rig& rig, const PacketTaker::Figures& figures, const CaptureStatus& status,
                                 const std::vector<livox::InterfaceReport>& interfaces) {
  SessionCounters all = session_counters(rig, figures.ingest);
  for (auto& [name, counters] : all) {
    counters.erase("points");  // Nobody has looked at them.
    counters.erase("imu_samples");
  }
  for (const CaptureDevice& device : status.devices) {
    all[device.sensor]["connection_losses"] = device.report.link.counters.losses;
    all[device.sensor]["interruptions"] = device.report.link.counters.interruptions;
    all[device.sensor]["missing_settings"] = device.report.link.missing_settings.size();
    all[device.sensor].merge(link_counters(device.report.link.counters));
  }
  for (const CaptureCamera& camera : status.cameras) {
    const camera::CameraCounters& counters = camera.counters;
    all[camera.sensor] = {{"frames", counters.whole()},
                          {"images", camera.written},
                          {"damaged", counters.damaged()},
                          {"missing", counters.missing},
                          {"no_buffer", counters.no_buffer},
                          {"dropped_by_queue", camera.dropped_by_queue},
                          {"most_waiting", camera.most_waiting},
                          {"queue", CameraRecorder::kMostWaiting},
                          {"worst_wait_us", static_cast<std::uint64_t>(camera.worst_wait_ns / 1000)},
                          {"resent_packets", counters.resent_packets},
                          {"connection_losses", counters.losses}};
    if (camera.matching) all[camera.sensor].merge(matching_counters(*camera.matching));
  }
  if (const auto& trigger = status.trigger) {
    NamedCounters& counters = all["trigger"] = trigger_counters(*trigger);
    counters["most_waiting"] = trigger->most_waiting;
    counters["queue"] = trigger->queue;
    counters["worst_late_us"] =
        static_cast<std::uint64_t>(std::max<std::int64_t>(0, trigger->lateness.most_ns()) / 1000);
  }
  for (const livox::InterfaceReport& report : interfaces) {
    all["interface " + name_of(report.interface)] = {{"received", report.counters.received},
                                                     {"dropped_by_kernel", report.counters.dropped_by_kernel},
                                                     {"dropped_by_queue", report.counters.dropped_by_queue},
                                                     {"strangers", report.counters.strangers},
                                                     {"errors", report.counters.errors},
                                                     {"most_waiting", report.queue_high_water},
                                                     {"queue", report.queue_capacity}};
  }
  all["recording"] = {{"worst_wait_us", microseconds(status.worst_wait_s)},
                      {"recent_wait_us", static_cast<std::uint64_t>(figures.recent_wait_ns / 1000)},
                      {"worst_write_us", microseconds(status.worst_write_s)},
                      {"stops", static_cast<std::uint64_t>(status.progress.stops)},
                      {"short_stops", static_cast<std::uint64_t>(status.progress.short_stops)}};
  return all;
}

}  // namespace rigcal
