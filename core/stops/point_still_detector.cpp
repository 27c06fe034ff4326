#include "core/stops/point_still_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/seconds.h"
#include "core/stops/swing.h"

namespace rigcal {
namespace {

// Slots of 25 ms.
constexpr std::int64_t first_look = 8;     // a first reference, against which a rest is looked for
constexpr std::int64_t confirm = 20;       // a rest of half a second is believed,
constexpr std::int64_t confirm_long = 40;  // one that trembles more than usual after a second
constexpr std::int64_t reach_back = 24;    // a rest may have begun that much before it was noticed
constexpr std::int64_t hold_back = 16;     // a motion is noticed that much after it began, at most
constexpr std::int64_t edge = 1;           // slots at both ends in which a motion may hide
constexpr std::array<std::int64_t, 6> windows = {1, 2, 4, 10, 20, 40};
// What is left of a swing when it no longer stands out of the noise of the points has a third of this to fade.
constexpr std::int64_t arrival_slots = 8;
// Angles from points are noisier than a gyro's rates and not quite white: patterns come back.
constexpr SwingLimits swing_limits{8.0, 0.45, 40.0};
constexpr std::int64_t grow_every = 20;  // the reference takes in more of the rest,
constexpr int grow_times = 2;            // and is fixed then: creep shows against it
constexpr double settle_sigmas2 = 16.0;  // what counts as unsettled at the ends, less than what counts as motion
constexpr double quiet_offness = 16.0;   // of six degrees of freedom: a rest is above in one of a hundred windows
constexpr double most_half_ratio = 3.0;  // a rest scatters evenly; a swing fades
constexpr double unusual_noise = 2.5;
constexpr double least_noise = 0.05;
constexpr double most_noise = 400.0;
// A building or a vehicle trembles: as far as the range noise hides it at ten metres.
constexpr double most_tremble_rad = to_rad(0.05);
// Where no LiDAR tells a turn of this size about every axis, what looks like rest says nothing.
constexpr double most_resolution_rad = to_rad(0.15);
constexpr double most_bump_rad = to_rad(1.5);
// Points of a LiDAR that are looked at: what finds the stops looks well, what only watches over a gyro glances.
constexpr double points_per_s = 120'000.0;
constexpr double points_per_s_beside_gyro = 30'000.0;

}  // namespace

PointStillDetector::PointStillDetector(const StopOptions& options, StillListener& listener)
    : options_(options),
      listener_(listener),
      slots_(options.source == StopSource::points ? points_per_s : points_per_s_beside_gyro) {}

void PointStillDetector::add(const PointBatch& batch) {
  const int epoch_before = slots_.epoch();
  slots_.add(batch);
  if (slots_.epoch() != epoch_before) restart();
  while (slots_.complete_next(false)) step();
}

void PointStillDetector::flush() {
  while (slots_.complete_next(true)) step();
  if (state_ == State::still) end_rest(slots_.last() + 1, StopEnd::stream);
}

// The clock jumped: the slots have new numbers, the old ones are gone.
void PointStillDetector::restart() {
  if (state_ == State::still) {
    const std::int64_t last_ns = open_.stop.end_ns + 1;
    if (said_) {
      open_.end = StopEnd::silence;
      listener_.stop_ended(open_);
      for (PointTrack& track : tracks_) track.keep_reference();
    } else {
      not_still(last_ns, DropReason::short_stop);
    }
  }
  state_ = State::moving;
  has_reference_ = false;
  rest_ = 0;
  floor_ = 0;
}

void PointStillDetector::step() {
  while (tracks_.size() < slots_.lidars())
    tracks_.emplace_back(tracks_.size(), slots_.sensor(tracks_.size()), options_);
  const std::int64_t slot = slots_.last();
  if (state_ == State::moving) {
    look_for_rest(slot);
  } else {
    extend_rest(slot);
  }
}

void PointStillDetector::take_references(std::int64_t first, std::int64_t last) {
  for (PointTrack& track : tracks_) track.take_reference(slots_, first, last);
}

// One LiDAR that is off is enough, unless the others contradict: people who walk by may fill a small view.
bool PointStillDetector::moved(std::int64_t first, std::int64_t last) const {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (tracks_[i].moved(first, last) && !is_outvoted(i, first, last)) return true;
  }
  return false;
}

// By one that would have seen a turn of that size and saw none, or by two that see well and saw nothing at all; by one
// of these where most of the view is something else, which takes a large motion or somebody in front of the lens.
bool PointStillDetector::is_outvoted(std::size_t lidar, std::int64_t first, std::int64_t last) const {
  const double turn_rad = tracks_[lidar].turn(first, last).norm();
  int quiet = std::isinf(tracks_[lidar].offness(first, last)) ? 1 : 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const PointTrack& other = tracks_[i];
    if (i == lidar || other.empty(last)) continue;
    const double off = other.offness(first, last);
    if (off < PointTrack::most_offness && other.worst_resolution_rad(last - first + 1) < turn_rad) return true;
    if (off < quiet_offness && other.resolution_rad() <= most_resolution_rad) ++quiet;
  }
  return quiet >= 2;
}

bool PointStillDetector::moved_just_now(std::int64_t last) const {
  return std::any_of(windows.begin(), windows.end(),
                     [&](std::int64_t length) { return last - length + 1 >= rest_ && moved(last - length + 1, last); });
}

std::int64_t PointStillDetector::silent_slots(std::int64_t last) const {
  std::int64_t count = 0;
  const auto silent = [&](std::int64_t slot) {
    return std::all_of(tracks_.begin(), tracks_.end(), [&](const PointTrack& t) { return t.empty(slot); });
  };
  while (last - count >= rest_ && silent(last - count)) ++count;
  return count;
}

void PointStillDetector::look_for_rest(std::int64_t slot) {
  rest_ = std::max(rest_, slot - confirm_long - first_look);
  if (!has_reference_) {
    if (slot - rest_ + 1 >= first_look) {
      take_references(rest_, slot);
      has_reference_ = true;
    }
  } else {
    for (PointTrack& track : tracks_) track.measure(slots_, slot);
    if (moved(slot, slot) || moved(slot - 3, slot)) {
      rest_ = slot;
      has_reference_ = false;
    } else if (slot - rest_ + 1 >= confirm && confirms(slot)) {
      begin_rest(slot);
      return;
    }
  }
  // What a rest that is found later can not reach back to.
  not_still(slots_.start_ns(std::max(floor_, rest_ - reach_back)), DropReason::moving);
}

// Whether slots rest_ .. last are a rest; where not, rest_ moves on.
bool PointStillDetector::confirms(std::int64_t last) {
  take_references(rest_, last);
  std::size_t uneven = 0;
  bool unusual = false;
  std::vector<double> ratios;
  for (PointTrack& track : tracks_) {
    const PointTrack::Scatter scatter = track.scatter(rest_, last);
    if (scatter.half_ratio > most_half_ratio || scatter.tremble_rad > most_tremble_rad) ++uneven;
    const double ratio = std::clamp(scatter.noise_ratio, least_noise, most_noise);
    unusual = unusual || (knows_noise_ && ratio > unusual_noise * track.noise_ratio());
    ratios.push_back(ratio);
  }
  const bool even = uneven <= tracks_.size() / 3;  // of three LiDARs one may look at people
  if (even && unusual && last - rest_ + 1 < confirm_long) {
    return false;  // wait and see
  }
  std::vector<double> before;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    before.push_back(tracks_[i].noise_ratio());
    if (!knows_noise_ || unusual) tracks_[i].set_noise_ratio(ratios[i]);
  }
  bool still = even;
  for (std::int64_t slot = rest_; still && slot <= last; ++slot) still = !moved_just_now(slot);
  if (still) return true;
  for (std::size_t i = 0; i < tracks_.size(); ++i) tracks_[i].set_noise_ratio(before[i]);
  rest_ += 4;
  if (last - rest_ + 1 >= first_look) take_references(rest_, last);
  return false;
}

void PointStillDetector::begin_rest(std::int64_t last) {
  figures_.longest_still_s =
      std::max(figures_.longest_still_s, seconds_of_ns((last - rest_ + 1) * PointSlots::length_ns));
  double best = std::numeric_limits<double>::infinity();
  for (const PointTrack& track : tracks_) best = std::min(best, track.resolution_rad());
  if (!(best <= most_resolution_rad)) {
    figures_.blind_s += seconds_of_ns((last - rest_ + 1) * PointSlots::length_ns);
    rest_ = last + 1;
    has_reference_ = false;
    return;
  }
  if (figures_.resolution_rad == 0.0 || best < figures_.resolution_rad) figures_.resolution_rad = best;

  const std::int64_t reference_first = rest_;
  const std::int64_t earliest = std::max({floor_, slots_.first(), rest_ - reach_back});
  for (std::int64_t slot = rest_ - 1; slot >= earliest; --slot) {
    for (PointTrack& track : tracks_) track.measure(slots_, slot);
  }
  while (rest_ > earliest && !moved(rest_ - 1, rest_ - 1) && !moved(rest_ - 1, rest_ + 2)) --rest_;
  // A motion's end hides in the noise of a slot, but not in that of several.
  std::int64_t start = rest_;
  double most = settle_sigmas2;
  for (std::int64_t i = rest_; i < std::min(last, rest_ + hold_back); ++i) {
    const double off = offness(rest_, i);
    if (off <= most) continue;
    most = off;
    start = i + 1;
  }
  if (start > 0) start += edge + arrival_slots;
  std::int64_t settled = slots_.start_ns(start);
  if (rest_ > earliest) settled = std::max(settled, settled_ns(earliest, last));  // else no motion before it was seen
  state_ = State::still;
  knows_noise_ = true;
  said_ = false;
  reference_last_ = last;
  reference_grown_ = 0;
  open_ = StillStop{};
  open_.stop.index = figures_.stops;
  open_.stop.start_ns = settled + whole_ns_of_seconds(options_.margin_s);
  open_.stop.end_ns = open_.stop.start_ns - 1;
  open_.rotation_known = figures_.stops == 0;
  not_still(slots_.start_ns(rest_), DropReason::moving);
  not_still(open_.stop.start_ns, DropReason::swing);
  rest_ = std::max(rest_, start);
  compare_with_stop_before(reference_first, last);
}

std::int64_t PointStillDetector::settled_ns(std::int64_t first, std::int64_t last) const {
  std::int64_t settled = std::numeric_limits<std::int64_t>::min();
  for (const PointTrack& track : tracks_) {
    if (track.resolution_rad() > most_resolution_rad) continue;
    const Vector3d noise = track.slot_variance().cwiseSqrt();
    std::vector<SwingReading> readings;
    std::size_t still_from = 0;
    for (std::int64_t slot = first; slot <= last; ++slot) {
      if (slot == rest_) still_from = readings.size();
      if (track.empty(slot)) continue;
      readings.push_back({static_cast<std::size_t>(slot - first), 1.0, track.turn(slot, slot).cwiseQuotient(noise)});
    }
    const std::optional<SwingFit> swing = fit_swing(readings, still_from, swing_limits);
    if (!swing) continue;
    const double angle = (noise.asDiagonal() * swing->amplitudes.transpose()).norm();
    if (!(angle > options_.angle_limit_rad)) continue;
    const double wait_s = std::min(fading_s(*swing, angle, options_.angle_limit_rad), options_.max_settle_s);
    settled = std::max(
        settled, slots_.start_ns(first + static_cast<std::int64_t>(swing->start_bin)) + whole_ns_of_seconds(wait_s));
  }
  return std::min(settled, slots_.start_ns(last + 1));
}

// A rest that was bumped, or crept and went on: the LiDARs see the same view as in the stop before.
void PointStillDetector::compare_with_stop_before(std::int64_t first, std::int64_t last) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const PointTrack& track = tracks_[i];
    if (track.resolution_rad() > most_resolution_rad) continue;
    const std::optional<Vector3d> turn = track.turn_from_kept(slots_, first, last);
    const double resolution_rad = track.worst_resolution_rad(last - first + 1);
    if (!turn || turn->norm() > most_bump_rad + resolution_rad) {
      open_.rotation_known = figures_.stops == 0;
      return;
    }
    if (resolution_rad >= std::min(best, most_bump_rad)) continue;
    best = resolution_rad;
    open_.R_previous_this = exp_so3(*turn);
    open_.rotation_known = true;
    open_.rotation_sigma_rad = resolution_rad / 6.0;  // a resolution is some seven sigma
    open_.sensor = slots_.sensor(i);
  }
}

void PointStillDetector::extend_rest(std::int64_t slot) {
  for (PointTrack& track : tracks_) track.measure(slots_, slot);
  figures_.longest_still_s =
      std::max(figures_.longest_still_s, seconds_of_ns((slot - rest_ + 1) * PointSlots::length_ns));
  const std::int64_t silent = silent_slots(slot);
  if (static_cast<double>(silent) * 1e-9 * PointSlots::length_ns > options_.bridge_gap_s) {
    end_rest(slot - silent + 1, StopEnd::silence);
    return;
  }
  if (moved_just_now(slot)) {
    end_rest(onset(slot), StopEnd::motion);
    return;
  }
  if (reference_grown_ < grow_times && slot - hold_back >= reference_last_ + grow_every) {
    ++reference_grown_;
    reference_last_ = slot - hold_back;
    const std::int64_t first = std::max(rest_, slots_.first());
    for (PointTrack& track : tracks_) {
      track.take_reference(slots_, first, reference_last_);
      for (std::int64_t i = reference_last_ + 1; i <= slot; ++i) track.measure(slots_, i);
      const PointTrack::Scatter scatter = track.scatter(first, slot);
      // A trembling that comes and goes stays expected.
      track.set_noise_ratio(std::clamp(scatter.noise_ratio, 0.7 * track.noise_ratio(), most_noise));
      open_.tremble_rad = std::max(open_.tremble_rad, scatter.tremble_rad);
    }
  }
  say_still(slots_.start_ns(slot + 1 - hold_back) - whole_ns_of_seconds(options_.margin_s));
}

void PointStillDetector::say_still(std::int64_t until_ns) {
  if (until_ns - open_.stop.start_ns < whole_ns_of_seconds(options_.min_stop_s)) return;
  if (!said_) {
    said_ = true;
    ++figures_.stops;
  }
  open_.stop.end_ns = until_ns - 1;
  listener_.still_until(until_ns, open_.stop.index);
}

double PointStillDetector::offness(std::int64_t first, std::int64_t last) const {
  double most = 0.0;
  for (const PointTrack& track : tracks_) most = std::max(most, track.offness(first, last));
  return most;
}

// The slot from which on everything taken together is farthest off, and one before it.
std::int64_t PointStillDetector::onset(std::int64_t last) const {
  std::int64_t found = last;
  double most = 0.0;
  for (std::int64_t i = last; i >= std::max(rest_, last - hold_back + 1); --i) {
    const double off = offness(i, last);
    if (off <= most) continue;
    most = off;
    found = i;
  }
  found -= edge;
  // A motion after a silence may have begun in it.
  while (found > rest_ && found > last - hold_back && silent_slots(found - 1) > 0) --found;
  return std::max({found, rest_, last - hold_back + 1});
}

void PointStillDetector::end_rest(std::int64_t onset, StopEnd end) {
  const std::int64_t onset_ns = slots_.start_ns(onset);
  say_still(onset_ns - whole_ns_of_seconds(options_.margin_s));
  not_still(onset_ns, said_ ? DropReason::moving : DropReason::short_stop);
  if (said_) {
    open_.end = end;
    listener_.stop_ended(open_);
    for (PointTrack& track : tracks_) track.keep_reference();
  }
  state_ = State::moving;
  has_reference_ = false;
  floor_ = onset;
  rest_ = onset + 1;
}

void PointStillDetector::not_still(std::int64_t until_ns, DropReason reason) {
  const bool before = figures_.stops == 0 && reason == DropReason::moving;
  listener_.not_still_until(until_ns, before ? DropReason::before_first_stop : reason);
}

std::optional<RestNow> PointStillDetector::rest() const {
  if (state_ == State::moving) return std::nullopt;
  const std::int64_t since_ns = slots_.start_ns(rest_);
  return RestNow{since_ns, open_.stop.start_ns, std::max(since_ns, open_.stop.end_ns + 1),
                 said_ ? open_.stop.index : -1};
}

PointStillFigures PointStillDetector::figures() const {
  PointStillFigures figures = figures_;
  figures.points = slots_.used();
  return figures;
}

}  // namespace rigcal
