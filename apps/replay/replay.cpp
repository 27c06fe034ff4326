#include "apps/replay/replay.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "apps/replay/replay_outlet.h"
#include "apps/replay/replay_reading.h"
#include "core/base/seconds.h"
#include "core/io/session_folder.h"
#include "drivers/net/interfaces.h"

namespace rigcal {
namespace {

constexpr std::int64_t lead_ns = 20'000'000;
constexpr std::int64_t seam_ns = 10'000'000;  // From the end of a pass to the next.
constexpr double late_s = 0.1;

struct Recorded {
  std::string file;
  Rig rig;
};

Expected<Recorded> find_recording(const ReplayOptions& options) {
  Recorded found{options.input, {}};
  std::error_code error;
  if (std::filesystem::is_directory(options.input, error)) {
    Expected<SessionFolder> session = open_session(options.input);
    if (!session) return session.error();
    if (session->packets.empty())
      return input_error("holds patches and no packets", options.input,
                         "replay a session that was recorded as packets");
    found = {session->packets, std::move(session->rig)};
  }
  if (!options.rig.empty()) {
    Expected<Rig> rig = load_rig(options.rig);
    if (!rig) return rig.error();
    found.rig = *std::move(rig);
  }
  return found;
}

// Where each device appears. Plain packets to this machine itself come from its loopback network unless told otherwise.
Expected<ReplayPlaces> place(const RecordedDevices& devices, const ReplayOptions& options, const std::string& file) {
  ReplayPlaces places;
  std::optional<livox::Ipv4> network = options.network;
  if (!network && options.to && (*options.to)[0] == 127) network = livox::Ipv4{127, 0, 0, 0};
  for (const auto& [ip, device] : devices.devices()) {
    livox::Ipv4 at = ip;
    if (network && (options.network || ip[0] != 127)) {
      at = *network;
      at[3] = ip[3];
    }
    for (const auto& [other, taken] : places)
      if (taken == at)
        return input_error(to_string(other) + " and " + to_string(ip) + " would both appear at " + to_string(at), file,
                           "give the machine the addresses of the devices, and leave --network out");
    places[ip] = at;
  }
  return places;
}

Expected<livox::Ipv4> host_of(const RecordedDevices& devices) {
  const Expected<std::vector<net::Interface>> interfaces = net::list_interfaces();
  if (!interfaces) return interfaces.error();
  std::set<livox::Ipv4> own;
  for (const net::Interface& interface : *interfaces) own.insert(interface.ip);
  return recorded_host(devices.hosts(), own);
}

/// When recorded stamps are due on this machine's clock.
class Schedule {
 public:
  Schedule(double speed, std::int64_t first_ns, std::int64_t length_ns)
      : speed_(speed), first_ns_(first_ns), length_ns_(length_ns) {}

  void start(std::int64_t now) { start_ns_ = now; }
  [[nodiscard]] bool is_started() const { return start_ns_.has_value(); }
  void begin_next_pass() { earlier_ns_ += length_ns_; }
  [[nodiscard]] std::int64_t earlier_ns() const { return earlier_ns_; }
  // Files may hold stamps out of order: no datagram is due before the one ahead of it.
  [[nodiscard]] std::int64_t due_ns(std::int64_t stamp_ns) {
    const double since_start = (static_cast<double>(stamp_ns - first_ns_) + static_cast<double>(earlier_ns_)) / speed_;
    last_due_ns_ = std::max<std::int64_t>(last_due_ns_, *start_ns_ + std::llround(std::clamp(since_start, 0.0, 4e18)));
    return last_due_ns_;
  }
  [[nodiscard]] double seconds(std::int64_t now) const {
    return start_ns_ ? std::max(0.0, seconds_of_ns(now - *start_ns_) * speed_) : 0.0;
  }

 private:
  double speed_;
  std::int64_t first_ns_;
  std::int64_t length_ns_;
  std::optional<std::int64_t> start_ns_;
  std::int64_t earlier_ns_ = 0;
  std::int64_t last_due_ns_ = INT64_MIN;
};

/// A recording on its way out.
class Playing {
 public:
  Playing(ReplayReading& reading, ReplayOutlet& outlet, const ReplayOptions& options, std::int64_t first_ns,
          ReplaySummary& summary)
      : reading_(reading),
        outlet_(outlet),
        options_(options),
        first_ns_(first_ns),
        schedule_(options.speed, first_ns, std::max<std::int64_t>(0, reading.last_ns() - first_ns) + seam_ns),
        summary_(summary) {}

  Expected<void> run(const RunContext& context) {
    if (const auto first = advance(); !first) return first.error();
    while (!context.cancelled()) {
      const std::int64_t now = monotonic_now_ns();
      const bool may_run = outlet_.serve(now);
      if (may_run && !schedule_.is_started()) schedule_.start(now + lead_ns);
      std::int64_t until = INT64_MAX;
      if (schedule_.is_started()) {
        const auto due = send_due(now);
        if (!due) return due.error();
        if (!*due) break;
        until = **due;
        report(now, context);
      } else {
        context.reporter.progress("wait for hosts", -1.0);
      }
      outlet_.wait(until);
    }
    return {};
  }

 private:
  using Due = std::optional<std::int64_t>;

  // When the next datagram is due; nothing: there is none.
  Expected<Due> send_due(std::int64_t now) {
    while (has_datagram_) {
      const std::int64_t due = schedule_.due_ns(datagram_.stamp_ns);
      if (due > now) return Due(due);
      const auto sent = outlet_.send(datagram_, due, {options_.speed, schedule_.earlier_ns()});
      if (!sent) return sent.error();
      summary_.latest_s = std::max(summary_.latest_s, seconds_of_ns(now - due));
      if (const auto next = advance(); !next) return next.error();
    }
    return Due();
  }

  // The next datagram from the recording's start on; of the next pass where this one is over.
  Expected<void> advance() {
    while (true) {
      const Expected<bool> more = reading_.next(datagram_);
      if (!more) return more.error();
      has_datagram_ = *more;
      if (!has_datagram_) {
        ++summary_.passes;
        summary_.left_out += reading_.left_out();
        if (!options_.loop) {
          summary_.is_complete = true;
          return {};
        }
        schedule_.begin_next_pass();
        if (const auto again = reading_.rewind(); !again) return again.error();
      } else if (datagram_.stamp_ns >= first_ns_) {
        return {};
      }
    }
  }

  void report(std::int64_t now, const RunContext& context) {
    const double length_s = seconds_of_ns(reading_.last_ns() - first_ns_);
    const double run_s = schedule_.seconds(now);
    summary_.seconds = options_.loop ? run_s : std::min(run_s, length_s);
    context.reporter.progress("replay", options_.loop || length_s <= 0.0 ? -1.0 : summary_.seconds / length_s);
    if (summary_.latest_s > late_s)
      context.reporter.warn(
          "packets leave more than 0.1 s late: this machine cannot read and send that fast; lower the speed");
  }

  ReplayReading& reading_;
  ReplayOutlet& outlet_;
  const ReplayOptions& options_;
  std::int64_t first_ns_;
  Schedule schedule_;
  ReplaySummary& summary_;
  Datagram datagram_;
  bool has_datagram_ = false;
};

}  // namespace

Expected<ReplaySummary> replay(const ReplayOptions& wanted, const RunContext& context) {
  ReplayOptions options = wanted;
  Expected<Recorded> recorded = find_recording(options);
  if (!recorded) return recorded.error();
  Expected<ReplayReading> reading = ReplayReading::open(recorded->file, context);
  if (context.cancelled()) return ReplaySummary{};
  if (!reading) return reading.error();
  if (!options.as_devices && !options.to) {
    Expected<livox::Ipv4> host = host_of(reading->devices());
    if (!host) return Error{host.error().kind, host.error().what, recorded->file, host.error().mend};
    options.to = *host;
    context.reporter.warn("no --to is given: to " + to_string(*host) + ", as recorded");
  }
  const auto places = place(reading->devices(), options, recorded->file);
  if (!places) return places.error();
  auto outlet = options.as_devices
                    ? open_device_outlet(reading->devices(), *places, recorded->rig, options, context.reporter)
                    : open_packet_outlet(reading->devices(), *places, recorded->rig, options);
  if (!outlet) return outlet.error();
  ReplaySummary summary;
  summary.truncation = reading->truncation();
  // Devices do not sample before the first sample; what they said before is their own business now.
  const std::int64_t first_ns = options.as_devices ? reading->first_sample_ns() : reading->first_ns();
  Playing playing(*reading, **outlet, options, first_ns, summary);
  if (const auto played = playing.run(context); !played) return played.error();
  (*outlet)->finish(summary);
  return summary;
}

}  // namespace rigcal
