#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/base/heartbeat.h"
#include "drivers/net/session_clock.h"
#include "drivers/trigger/event_queue.h"
#include "drivers/trigger/gpio_line.h"
#include "drivers/trigger/jitter_histogram.h"
#include "drivers/trigger/pps.h"
#include "drivers/trigger/pulse_machine.h"

namespace rigcal::trigger {

struct TriggerOptions {
  /// Pulses are given here. A chip that may be unplugged is named by its label: it may come back with another number.
  std::optional<LineAddress> output;
  PulsePattern pattern;
  bool is_held = false;               ///< It begins without pulses, see `hold`.
  std::optional<LineAddress> strobe;  ///< A line that is read back: what a camera or the wire of the trigger shows.
  std::string pps;                    ///< A PPS device to listen to; empty: none.
  bool realtime = false;              ///< Ask for real-time priority for the pulses.
  std::size_t queue = 8192;           ///< Events that nobody has taken yet.
};

/// What was done and seen.
struct TriggerReport {
  std::uint64_t pulses = 0;
  std::uint64_t skipped = 0;  ///< Places of the pattern that were left out, as the machine was busy or the chip gone.
  std::uint64_t held = 0;     ///< Places at which no pulse was wanted.
  std::uint64_t strobe_pulses = 0;
  std::uint64_t strobe_lost = 0;    ///< Edges, where the library tells (libgpiod 2).
  std::uint64_t strobe_mended = 0;  ///< Edges that the kernel reported the wrong way round, see EdgeLevels.
  std::uint64_t pps_pulses = 0;
  std::uint64_t pps_lost = 0;
  std::uint64_t losses = 0;          ///< Times a chip or device was gone.
  std::uint64_t dropped_events = 0;  ///< That nobody took in time.
  std::size_t most_waiting = 0;      ///< Most events that have waited to be taken,
  std::size_t queue = 0;             ///< and for so many there is room.
  JitterHistogram lateness;          ///< From when a pulse was due until it was set.
  JitterHistogram strobe_delay;      ///< From when a pulse was set until it was seen on the strobe line.
  std::vector<std::string> notes;    ///< What is less good than it could be, each a sentence with its mend.
};

/// A trigger line at work: gives pulses, reads a strobe line and a PPS input, each in a thread of its own. The output
/// is low before, between and after pulses; also when this ends in any way but a kill of the whole program.
class Trigger {
 public:
  /// Takes the lines and starts at once; the first pulse comes 10 ms later. Errors: the pattern (kind input), a line or
  /// device that cannot be had (kind system).
  [[nodiscard]] static Expected<std::unique_ptr<Trigger>> start(const TriggerOptions& options,
                                                                const net::ClockReading& session_start);
  /// As `stop`.
  ~Trigger();
  Trigger(const Trigger&) = delete;
  Trigger& operator=(const Trigger&) = delete;

  /// The oldest event, for which it waits at most that long; false where there is none. One thread only.
  bool next(TriggerEvent& event, std::int64_t timeout_ns) { return queue_.take(event, timeout_ns); }
  /// While it is held it gives no pulses; the pattern goes on. From any thread; takes 0.1 s at most until it is so.
  void hold(bool is_held) { is_held_.store(is_held); }
  /// Ends the pulses (one that is under way is not cut) and gives the lines back; takes 0.2 s at most. What is queued
  /// can still be taken.
  void stop();
  [[nodiscard]] TriggerReport report() const;
  /// Of the threads of the lines that it has.
  [[nodiscard]] std::vector<const Heartbeat*> heartbeats() const;

 private:
  Trigger(const TriggerOptions& options, const net::ClockReading& session_start);
  Expected<void> take_lines();
  void start_threads();
  void run_output(std::optional<OutputLine> line);
  void run_strobe(std::optional<InputLine> line);
  void run_pps(std::optional<PpsDevice> device);
  void read_strobe(std::span<const Edge> edges);
  void tell(TriggerSource source, TriggerEventKind kind, std::int64_t number, std::int64_t stamp_ns);
  void tell_now(TriggerSource source, TriggerEventKind kind);
  void note_places(const PulseMachine& machine);
  void note_edge(const PulseAction& action, std::int64_t set_ns);
  Heartbeat& beat_of(TriggerSource source) { return beats_[static_cast<std::size_t>(source)]; }
  template <class Device>
  std::optional<Device> regain(TriggerSource source, const std::function<Expected<Device>()>& request);

  TriggerOptions options_;
  net::SessionClock clock_;
  EventQueue queue_;
  std::optional<OutputLine> output_;  ///< Until its thread has it.
  std::optional<InputLine> strobe_;
  std::optional<PpsDevice> pps_;
  std::array<Heartbeat, 3> beats_{Heartbeat("trigger line"), Heartbeat("strobe line"), Heartbeat("PPS input")};
  std::atomic<bool> is_running_{true};
  std::atomic<bool> is_held_{false};
  std::atomic<std::int64_t> last_pulse_ns_{0};  ///< Session time just before the output was set last; 0: never.
  mutable std::mutex mutex_;
  TriggerReport report_;
  std::vector<std::thread> threads_;
};

/// A stamp of an edge on CLOCK_MONOTONIC, whichever of the two clocks it is of (see Edge).
[[nodiscard]] std::int64_t monotonic_of_edge(std::int64_t kernel_ns, const net::ClockReading& now);

}  // namespace rigcal::trigger
