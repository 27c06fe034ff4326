#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace rigcal::sim {

/// A pulse on a trigger line. Times are of any monotonic clock.
struct LinePulse {
  std::uint32_t line = 0;
  std::int64_t rise_ns = 0;
  std::int64_t fall_ns = 0;
  std::int64_t number = 0;  ///< For whoever makes the image.
};

/// How a camera's settings let it expose.
struct ExposureRules {
  bool is_triggered = false;
  std::uint32_t source = 0;  ///< A line, or kSoftwareTrigger.
  bool on_falling_edge = false;
  std::int64_t delay_ns = 0;  ///< From the trigger to the exposure.
  std::int64_t exposure_ns = 5'000'000;
  std::int64_t period_ns = 16'666'667;  ///< Without a trigger.
  std::int64_t shortest_period_ns = 0;  ///< Nothing is exposed sooner after the exposure before.
};

struct Exposure {
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
  std::optional<std::int64_t> pulse;  ///< Number of the line's pulse that released it.
};

/// When a camera exposes: by itself, or once for each trigger. A pure state machine.
class ExposureSchedule {
 public:
  /// `frames`: after so many it stops; 0: it goes on.
  void start(std::int64_t now_ns, const ExposureRules& rules, std::uint64_t frames);
  void stop();
  [[nodiscard]] bool is_running() const { return is_running_; }
  /// Other rules from now on.
  void set_rules(std::int64_t now_ns, const ExposureRules& rules);

  /// A pulse that has begun; its falling edge may lie ahead.
  void pulse(const LinePulse& pulse);
  void software_trigger(std::int64_t now_ns);

  /// The next exposure that has ended by now.
  [[nodiscard]] std::optional<Exposure> take(std::int64_t now_ns);
  /// When `take` has to be asked again.
  [[nodiscard]] std::int64_t deadline_ns() const;
  /// Triggers that came too soon after the one before, as real cameras ignore them.
  [[nodiscard]] std::uint64_t ignored() const { return ignored_; }

 private:
  struct Start {
    std::int64_t time_ns = 0;
    std::optional<std::int64_t> pulse;
  };
  void add(const Start& start);
  [[nodiscard]] std::optional<Start> next_start(std::int64_t now_ns);

  ExposureRules rules_;
  bool is_running_ = false;
  std::uint64_t frames_left_ = 0;
  bool has_end_ = false;
  std::int64_t free_start_ns_ = 0;  ///< Of the next exposure without a trigger.
  std::int64_t blocked_until_ns_ = INT64_MIN;
  std::deque<Start> triggers_;  ///< In order of time.
  std::optional<Exposure> exposing_;
  std::uint64_t ignored_ = 0;
};

}  // namespace rigcal::sim
