#include "core/stops/still_judge.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rigcal {
namespace {

constexpr std::array<int, 5> window_bins = {1, 2, 4, 10, 20};
constexpr int longest_window = window_bins.back();
constexpr std::int64_t history_bins = 80;  // two seconds before a stop: four time constants of the slowest swing
constexpr int patience_bins = 60;          // how long bins wait for the first bias
constexpr std::size_t votes = 4;           // steady stretches that are remembered
constexpr int stretch_end_bins = 10;       // shorter unsteadiness does not end a stretch
constexpr int vote_bins = 10;              // a stretch counts against the bias after three quarters of a second
constexpr double learn_bins = 400.0;       // ten seconds of rest: faster than a bias drifts, slower than creep

// Windows overlap, there are 200 a second and three axes: one false alarm in hours needs 5.5 sigma; the energy of a few
// dozen squares has a long tail, its 8 sigma are about as rare.
constexpr double level_sigmas = 5.5;
constexpr double energy_sigmas = 8.0;
// The first window: means of filtered noise scatter up to this much more than white noise would.
constexpr double first_energy_ratio = 4.0;
// Rate of a swing of the angle limit at 8 Hz, the fastest expected: less is never alarming; slower swings that this
// lets pass are found by their angle and by their decay.
constexpr double fastest_swing_hz = 8.0;

}  // namespace

struct StillJudge::Window {
  int bins = 0;
  int filled = 0;  ///< Bins with samples.
  double samples = 0.0;
  Vector3d mean = Vector3d::Zero();
  Vector3d between = Vector3d::Zero();      ///< Variance of a sample, from the scatter of the bins' means.
  Vector3d within = Vector3d::Zero();       ///< Variance of a sample, from the scatter inside the bins.
  double bump2 = 0.0;                       ///< Variance of the bins' mean acceleration, summed over the axes.
  Vector3d half_change = Vector3d::Zero();  ///< Mean of the later half minus the earlier.
};

StillJudge::Window StillJudge::window(std::int64_t first, std::int64_t last) const {
  Window w;
  w.bins = static_cast<int>(last - first + 1);
  Vector3d acceleration = Vector3d::Zero();
  std::array<Vector3d, 2> half = {Vector3d::Zero(), Vector3d::Zero()};
  std::array<double, 2> half_samples = {0.0, 0.0};
  double freedom = 0.0;
  for (std::int64_t i = first; i <= last; ++i) {
    const MotionBin& bin = at(i);
    if (bin.samples == 0) continue;
    ++w.filled;
    w.samples += bin.samples;
    w.mean += bin.samples * bin.gyro_mean;
    w.within += bin.gyro_scatter;
    freedom += bin.samples - 1;
    acceleration += bin.acceleration_mean;
    const std::size_t h = 2 * (i - first) < w.bins ? 0 : 1;
    half[h] += bin.samples * bin.gyro_mean;
    half_samples[h] += bin.samples;
  }
  if (w.filled == 0) return w;
  w.mean /= w.samples;
  w.within /= std::max(freedom, 1.0);
  acceleration /= w.filled;
  if (half_samples[0] > 0.0 && half_samples[1] > 0.0)
    w.half_change = half[1] / half_samples[1] - half[0] / half_samples[0];
  for (std::int64_t i = first; i <= last; ++i) {
    const MotionBin& bin = at(i);
    if (bin.samples == 0) continue;
    w.between += bin.samples * (bin.gyro_mean - w.mean).cwiseAbs2();
    w.bump2 += (bin.acceleration_mean - acceleration).squaredNorm();
  }
  const double between_freedom = std::max(w.filled - 1, 1);
  w.between /= between_freedom;
  w.bump2 /= between_freedom;
  return w;
}

// Turned further than matters, in one direction.
bool StillJudge::turns(const Window& w) const {
  if (w.filled == 0) return false;
  const double length_s = w.bins * MotionBin::length_s;
  const double harmless = std::max(options_.creep_limit_rad_s, 2.0 * options_.angle_limit_rad / length_s);
  const Vector3d off = (w.mean - bias_).cwiseAbs() - level_sigmas * (noise_ / w.samples).cwiseSqrt();
  return (off.array() > harmless).any();
}

// Scatters more than the noise and a harmless swing would.
bool StillJudge::shakes(const Window& w) const {
  if (w.filled < 4) return false;
  const double rate = 2.0 * pi * fastest_swing_hz * options_.angle_limit_rad;
  const double spread = std::sqrt(2.0 / (w.filled - 1)) * noise_.norm();
  return w.between.sum() > noise_.sum() + energy_sigmas * spread + 0.5 * rate * rate * w.samples / w.filled;
}

bool StillJudge::bumps(const Window& w) const {
  return w.filled >= 4 && w.bump2 > std::max(options_.bump_limit_g * options_.bump_limit_g, 16.0 * bump_noise_);
}

// A window of half a second that shows noise about some constant rate, whatever that is.
bool StillJudge::is_steady(const Window& w) const {
  if (w.filled < longest_window - 2 || w.samples < 2 * longest_window) return false;
  if (w.mean.norm() > options_.max_bias_rad_s) return false;
  const double most = options_.max_gyro_noise_rad_s * options_.max_gyro_noise_rad_s;
  if ((w.within.array() > most).any()) return false;
  const Vector3d variance = knows_bias_ ? noise_ : w.within;
  const double half_samples = 0.5 * w.samples;
  const Vector3d trend = w.half_change.cwiseAbs() - level_sigmas * (2.0 * variance / half_samples).cwiseSqrt();
  if ((trend.array() > options_.creep_limit_rad_s).any()) return false;
  const double rate = 2.0 * pi * fastest_swing_hz * options_.angle_limit_rad;
  return w.between.sum() <= first_energy_ratio * variance.sum() + 0.5 * rate * rate * w.samples / w.filled;
}

void StillJudge::add(const MotionBin& bin) {
  const std::int64_t keep_from = final_ - history_bins;
  if (keep_from - begin_ > 4 * history_bins) {  // seldom, so that moving the rest down costs nothing
    bins_.erase(bins_.begin(), bins_.begin() + static_cast<std::ptrdiff_t>(keep_from - begin_));
    begin_ = keep_from;
  }
  bins_.push_back(bin);
  const std::int64_t last = end_++;
  mark_gap(last);
  watch_level(last);
  if (knows_bias_) judge(last);
}

// An empty bin is as the bins around it; a silence that is too long to be bridged counts as moving. Nor may the bin
// after a silence begin a stop: its rotation belongs to the turn.
void StillJudge::mark_gap(std::int64_t last) {
  MotionBin& bin = at(last);
  std::int64_t silent = last;  // the first empty bin of the silence that ends here
  while (silent > final_ && at(bin.samples == 0 ? silent : silent - 1).samples == 0) --silent;
  if (bin.samples == 0 && at(silent).samples > 0) ++silent;
  const double silence_s = std::max(bin.longest_interval_s,
                                    bin.samples == 0 ? static_cast<double>(last - silent) * MotionBin::length_s : 0.0);
  if (silence_s > options_.bridge_gap_s) {
    for (std::int64_t i = silent; i <= last; ++i) at(i).moving = at(i).silent = true;
  }
  const bool after_motion = last > begin_ && at(last - 1).moving;
  if (after_motion && (bin.samples == 0 || at(last - 1).samples == 0)) bin.moving = true;
}

void StillJudge::judge(std::int64_t last) {
  for (const int length : window_bins) {
    const std::int64_t first = last - length + 1;
    if (first < final_) return;
    // Longer windows hold this one: where it moves they say nothing new.
    for (std::int64_t i = first; i <= last; ++i) {
      if (at(i).moving) return;
    }
    const Window w = window(first, last);
    const bool pushed = bumps(w);
    if (!pushed && !turns(w) && !shakes(w)) continue;
    // What is left of a motion before lies in the older part: peel it off. Else it is an onset.
    if (length >= 4 && (first == 0 || at(first - 1).moving)) {
      mark_moving(first, first + length / 4 - 1);
    } else {
      mark_moving(pushed ? std::min(first, onset(last)) : onset(last), last);
    }
    return;
  }
}

// The bin with which a motion that lasts to `last` most likely began; looks back as far as no verdict is final. For a
// constant rate that is where (sum of n d)^2 / sum of n is largest, d the rate over the bias; for a swing where the sum
// of squares over what noise gives is.
std::int64_t StillJudge::onset(std::int64_t last) const {
  std::int64_t constant = last;
  std::int64_t swinging = last;
  double most_constant = 0.0;
  double most_swinging = 0.0;
  Vector3d sum = Vector3d::Zero();
  double samples = 0.0;
  double excess = 0.0;
  for (std::int64_t i = last; i >= final_ && !at(i).moving; --i) {
    const MotionBin& bin = at(i);
    if (bin.samples == 0) continue;
    const Vector3d weighted = (bin.samples * (bin.gyro_mean - bias_)).cwiseQuotient(noise_.cwiseSqrt());
    sum += weighted;
    samples += bin.samples;
    excess += weighted.squaredNorm() / bin.samples - 6.0;  // noise gives 3
    if (sum.squaredNorm() / samples > most_constant) {
      most_constant = sum.squaredNorm() / samples;
      constant = i;
    }
    if (excess > most_swinging) {
      most_swinging = excess;
      swinging = i;
    }
  }
  return std::min(constant, swinging);
}

std::int64_t StillJudge::turn_faded_ns() const {
  const std::int64_t first = final_ - 1;  // the first still bin
  if (first == begin_ || !at(first - 1).moving) return at(first).start_ns;
  std::int64_t from = first - 1;
  while (from > begin_ && first - from < longest_window && at(from - 1).moving) --from;
  const Window before = window(from, first - 1);
  const Vector3d rate = before.mean - bias_;
  if (before.filled == 0 || before.samples * rate.squaredNorm() < level_sigmas * level_sigmas * noise_.maxCoeff()) {
    return at(first).start_ns;
  }
  // Log likelihood of "still turning at that rate" against "still" for the bins up to i.
  double sum = 0.0;
  double most = 0.0;
  std::int64_t faded_ns = at(first).start_ns;
  for (std::int64_t i = first; i < std::min(end_, first + longest_window); ++i) {
    sum += at(i).samples * (2.0 * (at(i).gyro_mean - bias_) - rate).dot(rate);
    if (at(i).samples > 0 && sum > most) {
      most = sum;
      faded_ns = at(i).end_ns();
    }
  }
  return faded_ns;
}

void StillJudge::mark_moving(std::int64_t first, std::int64_t last) {
  while (first > final_ && at(first - 1).samples == 0) --first;
  const bool silent_after = last + 1 < end_ && (at(last).samples == 0 || at(last + 1).samples == 0);
  if (silent_after) {
    while (last + 1 < end_ && at(last + 1).samples == 0) ++last;
    if (last + 1 < end_) ++last;
  }
  for (std::int64_t i = first; i <= last; ++i) at(i).moving = true;
}

void StillJudge::judge_all() {
  for (std::int64_t i = final_; i < end_; ++i) {
    at(i).moving = at(i).silent = false;
    mark_gap(i);
  }
  for (std::int64_t i = final_; i < end_; ++i) judge(i);
}

void StillJudge::watch_level(std::int64_t last) {
  const std::int64_t first = last - longest_window + 1;
  if (first < begin_) return;
  const Window w = window(first, last);
  const bool steady = is_steady(w);
  if (w.filled >= longest_window - 2) {
    const double noise2 = w.within.sum() / 3.0;
    if (lowest_noise2_ < 0.0 || noise2 < lowest_noise2_) lowest_noise2_ = noise2;
  }
  if (!steady) {
    if (++unsteady_bins_ >= stretch_end_bins) {
      steady_bins_ = 0;
      same_rest_ = false;
    }
    return;
  }
  unsteady_bins_ = 0;
  const Level level{w.mean, w.samples};
  if (!knows_bias_) adopt(level, w);
  if (steady_bins_ > 0 && !agree(stretch_, level)) steady_bins_ = 0;
  if (steady_bins_++ == 0) stretch_ = level;
  if (steady_bins_ == vote_bins) vote(level, w);
}

bool StillJudge::agree(const Level& a, const Level& b) const {
  const Vector3d noise = (noise_ * (1.0 / a.samples + 1.0 / b.samples)).cwiseSqrt();
  return ((a.mean - b.mean).cwiseAbs() - level_sigmas * noise).maxCoeff() <= options_.creep_limit_rad_s;
}

void StillJudge::vote(const Level& level, const Window& w) {
  if (same_rest_) return;  // one vote until something moves, however often noise and creep change the level
  same_rest_ = true;
  levels_.push_back(level);
  if (levels_.size() > votes) levels_.pop_front();
  const Level bias{bias_, learned_bins_ * w.samples / w.filled};
  if (agree(level, bias)) return;
  const auto votes_for = [&](const Level& one) {
    return std::count_if(levels_.begin(), levels_.end(), [&](const Level& other) { return agree(one, other); });
  };
  const auto for_this = votes_for(level);
  const auto for_bias = votes_for(bias);
  // Of two levels with as many votes the much lower rate is the likelier bias.
  const bool lower = for_this == for_bias && w.mean.norm() < 0.5 * bias_.norm();
  if (for_this > for_bias || lower) {
    ++bias_changes_;
    adopt(level, w);
  }
}

void StillJudge::adopt(const Level& level, const Window& w) {
  bias_ = level.mean;
  if (!knows_bias_) {
    noise_ = w.within.cwiseMax(w.between).cwiseMax(1e-16);  // a unit that repeats itself exactly has none
    bump_noise_ = w.bump2;
  }
  knows_bias_ = true;
  learned_bins_ = longest_window;
  judge_all();
}

std::optional<MotionBin> StillJudge::take_final(bool at_end) {
  const auto bridge = static_cast<std::int64_t>(options_.bridge_gap_s / MotionBin::length_s);
  const std::int64_t delay = knows_bias_ ? longest_window - 1 + bridge : patience_bins;
  if (end_ - final_ <= (at_end ? 0 : delay)) return std::nullopt;
  if (!knows_bias_) at(final_).moving = true;
  return at(final_++);
}

void StillJudge::learn_from_last() {
  const std::int64_t last = final_ - 1;
  if (last - 1 < begin_) return;
  const MotionBin& bin = at(last);
  const MotionBin& before = at(last - 1);
  if (bin.samples == 0 || before.samples == 0 || before.moving) return;
  learned_bins_ = std::min(learned_bins_ + 1.0, learn_bins);
  const double share = 1.0 / learned_bins_;
  bias_ += share * (bin.gyro_mean - bias_);
  // From differences, which a drifting bias leaves alone: their variance is noise (1/n + 1/m).
  const double weight = 1.0 / (1.0 / bin.samples + 1.0 / before.samples);
  noise_ += share * (weight * (bin.gyro_mean - before.gyro_mean).cwiseAbs2() - noise_);
  noise_ = noise_.cwiseMax(1e-16);
  bump_noise_ += share * (0.5 * (bin.acceleration_mean - before.acceleration_mean).squaredNorm() - bump_noise_);
}

StillJudge::Surroundings StillJudge::around_last() const {
  const std::int64_t first = std::max(begin_, final_ - 1 - history_bins);
  std::int64_t end = final_;
  while (end < end_ && !at(end).moving) ++end;
  return {std::span<const MotionBin>(bins_).subspan(static_cast<std::size_t>(first - begin_),
                                                    static_cast<std::size_t>(end - first)),
          static_cast<std::size_t>(final_ - 1 - first)};
}

double StillJudge::lowest_noise_rad_s() const { return lowest_noise2_ > 0.0 ? std::sqrt(lowest_noise2_) : 0.0; }

}  // namespace rigcal
