#include "core/frames/match_trial.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace rigcal {
namespace {

constexpr std::size_t most_anchors = 3;  // The first frame may be one of a lost pulse.
constexpr std::size_t no_pulse = std::numeric_limits<std::size_t>::max();

/// A runner-up is beaten where it has more contradictions than these: three times those of the best, which losses
/// explain in both, and ten.
constexpr std::size_t contradictions_factor = 3;
constexpr std::size_t contradictions_more = 10;

struct Trial {
  ReleaseLine line;
  std::vector<std::size_t> pulse_of;  ///< By frame.
  std::size_t first_matched = no_pulse;
  std::size_t matched = 0;
  std::size_t contradictions = 0;  ///< Frames without a pulse, and pulses without a frame in between.
  std::int64_t shortest_lag_ns = std::numeric_limits<std::int64_t>::max();
};

class TrialRun {
 public:
  TrialRun(const PulseBook& book, const FrameMatcherOptions& options, std::size_t frames, const ReleaseLine& line)
      : book_(book),
        options_(options),
        witness_(options.ids),
        trial_{line, std::vector<std::size_t>(frames, no_pulse)} {}

  void add(std::size_t index, const FrameSighting& frame) {
    const std::int64_t stamp = line_stamp(options_, frame);
    const PulseChoice choice = book_.choose(trial_.line.at(stamp));
    if (choice.verdict == PulseChoice::Verdict::several) return;
    const bool is_match = choice.verdict == PulseChoice::Verdict::clear &&
                          (last_ == no_pulse || choice.index > last_) &&
                          (options_.has_device_stamps || witness_.agrees(frame.id, book_.pulse(choice.index).pulse));
    if (!is_match) {
      ++trial_.contradictions;
      return;
    }
    count_passed_over(choice.index);
    const std::int64_t pulse_ns = book_.pulse(choice.index).stamp_ns;
    trial_.line.add(stamp, pulse_ns);
    trial_.shortest_lag_ns = std::min(trial_.shortest_lag_ns, frame.received_ns - pulse_ns);
    trial_.pulse_of[index] = choice.index;
    if (trial_.matched++ == 0) trial_.first_matched = index;
    last_ = choice.index;
  }
  [[nodiscard]] Trial&& take() { return std::move(trial_); }

 private:
  void count_passed_over(std::size_t next) {
    if (last_ == no_pulse) return;
    const std::int64_t ready_ns = book_.pulse(last_).stamp_ns + options_.least_interval_ns;
    for (std::size_t i = last_ + 1; i < next; ++i)
      if (book_.pulse(i).stamp_ns >= ready_ns) ++trial_.contradictions;
  }

  const PulseBook& book_;
  const FrameMatcherOptions& options_;
  IdWitness witness_;
  Trial trial_;
  std::size_t last_ = no_pulse;
};

// Whether most frames that both have matched go to the same pulses.
bool is_same(const Trial& a, const Trial& b) {
  std::size_t both = 0;
  std::size_t equal = 0;
  for (std::size_t i = 0; i < a.pulse_of.size(); ++i) {
    if (a.pulse_of[i] == no_pulse || b.pulse_of[i] == no_pulse) continue;
    ++both;
    equal += a.pulse_of[i] == b.pulse_of[i] ? 1 : 0;
  }
  return 2 * equal > both;
}

bool is_better(const Trial& a, const Trial& b) { return a.matched + b.contradictions > b.matched + a.contradictions; }

std::vector<Trial> run_trials(const PulseBook& book, std::span<const FrameSighting> frames,
                              const FrameMatcherOptions& options) {
  const StampNoise noise = options.has_device_stamps ? StampNoise{} : arrival_noise;
  std::vector<Trial> trials;
  for (std::size_t anchor = 0; anchor < std::min(frames.size(), most_anchors); ++anchor) {
    const PulseRange range = plausible_pulses(book, options, frames[anchor]);
    for (std::size_t i = range.first; i < range.end; ++i) {
      const ReleaseLine line(noise, line_stamp(options, frames[anchor]), book.pulse(i).stamp_ns);
      TrialRun run(book, options, frames.size(), line);
      for (std::size_t frame = 0; frame < frames.size(); ++frame) run.add(frame, frames[frame]);
      Trial trial = run.take();
      if (trial.shortest_lag_ns >= options.least_lag_ns && trial.shortest_lag_ns <= options.most_lag_ns)
        trials.push_back(std::move(trial));
    }
  }
  return trials;
}

}  // namespace

PulseRange plausible_pulses(const PulseBook& book, const FrameMatcherOptions& options, const FrameSighting& frame) {
  return {book.first_from(frame.received_ns - options.most_lag_ns - late_frame_ns),
          book.first_from(frame.received_ns - options.least_lag_ns + 1)};
}

std::optional<ReleaseLine> find_start(const PulseBook& book, std::span<const FrameSighting> frames,
                                      const FrameMatcherOptions& options) {
  const std::vector<Trial> trials = run_trials(book, frames, options);
  const Trial* best = nullptr;
  for (const Trial& trial : trials)
    if (best == nullptr || is_better(trial, *best)) best = &trial;
  if (best == nullptr || best->matched == 0 || 2 * best->matched < frames.size()) return std::nullopt;
  const std::size_t needed = contradictions_factor * best->contradictions + contradictions_more;
  for (const Trial& trial : trials)
    if (!is_same(trial, *best) && trial.contradictions < needed) return std::nullopt;
  const std::size_t first = best->first_matched;
  return best->line.through(line_stamp(options, frames[first]), book.pulse(best->pulse_of[first]).stamp_ns);
}

}  // namespace rigcal
