#include "drivers/trigger/trigger.h"

#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>

#include "core/base/seconds.h"
#include "drivers/net/privileges.h"
#include "drivers/net/waiter.h"
#include "drivers/trigger/edge_levels.h"

namespace rigcal::trigger {
namespace {

constexpr std::int64_t lead_ns = 10'000'000;           // So that the first pulse is not late.
constexpr std::int64_t longest_wait_ns = 100'000'000;  // After which a thread sees that it is to stop.
constexpr std::int64_t regain_ns = 500'000'000;
constexpr const char* consumer = "rigcal";

void sleep_until(std::int64_t monotonic_ns) {
  const timespec until{monotonic_ns / ns_per_second, monotonic_ns % ns_per_second};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);  // Woken early: the caller looks at the time.
}

}  // namespace

std::int64_t monotonic_of_edge(std::int64_t kernel_ns, const net::ClockReading& now) {
  const bool is_realtime = std::abs(kernel_ns - now.realtime_ns) < std::abs(kernel_ns - now.monotonic_ns);
  return is_realtime ? kernel_ns - now.realtime_ns + now.monotonic_ns : kernel_ns;
}

Trigger::Trigger(const TriggerOptions& options, const net::ClockReading& session_start)
    : options_(options), clock_(session_start), queue_(options.queue), is_held_(options.is_held) {}

Trigger::~Trigger() { stop(); }

Expected<std::unique_ptr<Trigger>> Trigger::start(const TriggerOptions& options,
                                                  const net::ClockReading& session_start) {
  if (options.output) {
    if (const auto checked = check_pattern(options.pattern); !checked) return checked.error();
  }
  std::unique_ptr<Trigger> trigger(new Trigger(options, session_start));
  if (const auto taken = trigger->take_lines(); !taken) return taken.error();
  trigger->start_threads();
  return trigger;
}

Expected<void> Trigger::take_lines() {
  if (options_.strobe) {
    auto line = InputLine::request(*options_.strobe, consumer);
    if (!line) return line.error();
    strobe_ = *std::move(line);
  }
  if (!options_.pps.empty()) {
    auto device = PpsDevice::open(options_.pps);
    if (!device) return device.error();
    pps_ = *std::move(device);
  }
  if (options_.output) {
    auto line = OutputLine::request(*options_.output, consumer);
    if (!line) return line.error();
    output_ = *std::move(line);
  }
  return {};
}

// Listeners first, so that they see the first pulse.
void Trigger::start_threads() {
  if (strobe_) threads_.emplace_back([this, line = std::move(*strobe_)]() mutable { run_strobe(std::move(line)); });
  if (pps_) threads_.emplace_back([this, device = std::move(*pps_)]() mutable { run_pps(std::move(device)); });
  if (output_) threads_.emplace_back([this, line = std::move(*output_)]() mutable { run_output(std::move(line)); });
  strobe_.reset();
  pps_.reset();
  output_.reset();
}

void Trigger::stop() {
  is_running_.store(false);
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  queue_.close();
}

TriggerReport Trigger::report() const {
  const std::lock_guard lock(mutex_);
  TriggerReport report = report_;
  report.dropped_events = queue_.dropped();
  report.most_waiting = queue_.high_water();
  report.queue = queue_.capacity();
  return report;
}

std::vector<const Heartbeat*> Trigger::heartbeats() const {
  std::vector<const Heartbeat*> beats;
  const auto add = [&](TriggerSource source) { beats.push_back(&beats_[static_cast<std::size_t>(source)]); };
  if (options_.output) add(TriggerSource::output);
  if (options_.strobe) add(TriggerSource::strobe);
  if (!options_.pps.empty()) add(TriggerSource::pps);
  return beats;
}

void Trigger::tell(TriggerSource source, TriggerEventKind kind, std::int64_t number, std::int64_t stamp_ns) {
  queue_.push({source, kind, number, stamp_ns});
}

void Trigger::tell_now(TriggerSource source, TriggerEventKind kind) {
  tell(source, kind, 0, clock_.from_monotonic(monotonic_now_ns()));
}

template <class Device>
std::optional<Device> Trigger::regain(TriggerSource source, const std::function<Expected<Device>()>& request) {
  tell_now(source, TriggerEventKind::lost);
  {
    const std::lock_guard lock(mutex_);
    ++report_.losses;
  }
  std::int64_t next_try = monotonic_now_ns() + regain_ns;
  while (is_running_.load()) {
    beat_of(source).beat();
    const std::int64_t now = monotonic_now_ns();
    if (now < next_try) {
      sleep_until(std::min(next_try, now + longest_wait_ns));
      continue;
    }
    next_try = now + regain_ns;
    auto device = request();
    if (!device) continue;
    tell_now(source, TriggerEventKind::returned);
    return *std::move(device);
  }
  return std::nullopt;
}

void Trigger::note_places(const PulseMachine& machine) {
  const std::lock_guard lock(mutex_);
  report_.skipped = machine.skipped();
  report_.held = machine.held();
}

void Trigger::note_edge(const PulseAction& action, std::int64_t set_ns) {
  const std::int64_t stamp = clock_.from_monotonic(set_ns);
  if (action.is_high) {
    const std::lock_guard lock(mutex_);
    ++report_.pulses;
    report_.lateness.add(set_ns - action.due_ns);
  }
  const auto kind = action.is_high ? TriggerEventKind::pulse : TriggerEventKind::end;
  tell(TriggerSource::output, kind, static_cast<std::int64_t>(action.pulse), stamp);
}

void Trigger::run_output(std::optional<OutputLine> line) {
  net::name_thread("trigger-output");
  prctl(PR_SET_TIMERSLACK, 1UL);  // Otherwise the kernel wakes threads up to 50 us late, to save energy.
  if (options_.realtime) {
    if (std::string refusal = net::become_realtime(); !refusal.empty()) {
      const std::lock_guard lock(mutex_);
      report_.notes.push_back("the trigger has " + refusal);
    }
  }
  PulseMachine machine(options_.pattern, monotonic_now_ns() + lead_ns);
  bool is_whole = true;  // The pulse that is under way; one in which the chip was gone ended nobody knows when.
  while (true) {
    beat_of(TriggerSource::output).beat();
    if (!is_running_.load()) machine.end();
    machine.hold(is_held_.load());
    const std::optional<std::int64_t> wake = machine.wake_ns();
    if (!wake) break;
    const std::int64_t before = monotonic_now_ns();
    const std::optional<PulseAction> action = machine.step(before);
    if (!action) {
      note_places(machine);
      sleep_until(std::min(*wake, before + longest_wait_ns));
      continue;
    }
    // Before it is set: the edge may be read back before the call returns.
    if (action->is_high) last_pulse_ns_.store(clock_.from_monotonic(before));
    if (line->set(action->is_high)) {
      // Half of the time that the call took: where in it the line changed is not known.
      const std::int64_t set_ns = before + (monotonic_now_ns() - before) / 2;
      is_whole = is_whole || action->is_high;
      if (is_whole) note_edge(*action, set_ns);
      continue;
    }
    is_whole = false;
    line.reset();  // While it is held, the chip comes back under another name.
    line =
        regain<OutputLine>(TriggerSource::output, [this] { return OutputLine::request(*options_.output, consumer); });
    if (!line) break;
  }
  note_places(machine);
  beat_of(TriggerSource::output).rest();
  if (is_running_.load()) tell_now(TriggerSource::output, TriggerEventKind::finished);
}

void Trigger::read_strobe(std::span<const Edge> edges) {
  const net::ClockReading now = net::read_clocks();
  const std::lock_guard lock(mutex_);
  for (const Edge& edge : edges) {
    const std::int64_t stamp = clock_.from_monotonic(monotonic_of_edge(edge.kernel_ns, now));
    if (!edge.is_rising) {
      tell(TriggerSource::strobe, TriggerEventKind::end, static_cast<std::int64_t>(report_.strobe_pulses) - 1, stamp);
      continue;
    }
    if (const std::int64_t pulse = last_pulse_ns_.load(); pulse != 0) report_.strobe_delay.add(stamp - pulse);
    tell(TriggerSource::strobe, TriggerEventKind::pulse, static_cast<std::int64_t>(report_.strobe_pulses++), stamp);
  }
}

void Trigger::run_strobe(std::optional<InputLine> line) {
  net::name_thread("trigger-strobe");
  std::array<Edge, 64> edges;
  auto waiter = net::Waiter::create({line->descriptor()});
  std::uint64_t last_sequence = 0;
  EdgeLevels levels;
  while (is_running_.load() && waiter) {
    beat_of(TriggerSource::strobe).beat();
    if (!waiter->wait(longest_wait_ns) || !waiter->is_ready(0)) continue;
    const auto count = line->read(edges);
    if (!count) {
      line.reset();
      line =
          regain<InputLine>(TriggerSource::strobe, [this] { return InputLine::request(*options_.strobe, consumer); });
      if (!line) break;
      waiter = net::Waiter::create({line->descriptor()});
      last_sequence = 0;
      levels.forget();
      continue;
    }
    for (std::size_t i = 0; i < *count; ++i) {
      const std::uint64_t sequence = edges[i].sequence;
      if (last_sequence > 0 && sequence > last_sequence + 1) {
        const std::lock_guard lock(mutex_);
        report_.strobe_lost += sequence - last_sequence - 1;
      }
      last_sequence = sequence;
    }
    const std::span<Edge> read(edges.data(), *count);
    levels.mend(read);
    read_strobe(read);
    const std::lock_guard lock(mutex_);
    report_.strobe_mended = levels.mended();
  }
  beat_of(TriggerSource::strobe).rest();
  if (waiter) return;
  const std::lock_guard lock(mutex_);
  report_.notes.push_back("the strobe line is not read any more: " + waiter.error().message());
}

void Trigger::run_pps(std::optional<PpsDevice> device) {
  net::name_thread("trigger-pps");
  while (is_running_.load()) {
    beat_of(TriggerSource::pps).beat();
    const auto pulse = device->next(longest_wait_ns);
    if (!pulse) {
      device.reset();  // While it is held, the input comes back under another name.
      device = regain<PpsDevice>(TriggerSource::pps, [this] { return PpsDevice::open(options_.pps); });
      if (!device) break;
      continue;
    }
    if (!*pulse) continue;
    net::SessionClock clock = clock_;
    clock.update(net::read_clocks());
    {
      const std::lock_guard lock(mutex_);
      ++report_.pps_pulses;
      report_.pps_lost += (*pulse)->missed;
    }
    tell(TriggerSource::pps, TriggerEventKind::pulse, (*pulse)->sequence, clock.from_realtime((*pulse)->realtime_ns));
  }
  beat_of(TriggerSource::pps).rest();
}

}  // namespace rigcal::trigger
