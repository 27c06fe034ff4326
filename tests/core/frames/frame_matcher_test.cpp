#include "core/frames/frame_matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr std::int64_t microsecond = 1000;
constexpr std::int64_t ms = 1000 * microsecond;
constexpr std::int64_t second = 1000 * ms;
constexpr std::int64_t session_start = 1'700'000'000 * second;

/// What a camera on a trigger line does, and what goes wrong.
struct Course {
  int triggers = 10'000;
  std::function<std::int64_t(int)> due_ns = [](int i) { return i * 50 * ms; };
  double lost_frames = 0.02;
  double lost_pulses = 0.01;  ///< Their records: the camera sees them.
  double doubled = 0.0;       ///< Frames that the camera takes a second time, 2 to 10 ms later.
  double drift_ppm = 200.0;
  double stamp_jitter_ns = 200e3;
  std::int64_t lag_ns = 25 * ms;   ///< From the pulse to the quickest arrival.
  double arrival_jitter_ns = 2e6;  ///< Mean of the exponential part.
  double held_up = 0.0;            ///< Frames that come up to 120 ms late, and all behind them.
  double id_jumps = 0.0;
  std::int64_t busy_ns = 0;           ///< Pulses so soon after an exposure are ignored.
  int clock_set_at = -1;              ///< Trigger at which the camera starts anew.
  std::int64_t clock_set_by_ns = -1;  ///< Negative: the clock begins at 0 again, and the numbers too.
  FrameIdRule ids = gige_block_ids;
};

struct Recording {
  std::vector<TriggerPulse> pulses;
  std::vector<FrameSighting> frames;
  std::map<std::int64_t, std::int64_t> pulse_of;     ///< By arrival, which is unique; of frames that can be matched.
  std::map<std::int64_t, std::int64_t> released_at;  ///< By arrival, of all.
};

Recording record(const Course& course, std::uint64_t seed) {
  Random random(seed);
  Recording recording;
  std::int64_t offset = 77 * second;
  std::uint64_t id = 65'000;
  std::int64_t last_arrival = 0;
  std::int64_t last_exposure = -course.busy_ns;
  const auto expose = [&](std::int64_t trigger, std::int64_t at, bool can_match) {
    ++id;
    if (course.ids.bits < 64) id %= std::uint64_t{1} << static_cast<unsigned>(course.ids.bits);
    if (id == 0 && course.ids.skips_zero) ++id;
    if (random.uniform() < course.id_jumps) id = random.below(60'000) + 1;
    if (random.uniform() < course.lost_frames) return;
    const double fast = 1.0 + course.drift_ppm * 1e-6;
    const std::int64_t stamp =
        offset + std::llround(static_cast<double>(at) * fast + random.normal() * course.stamp_jitter_ns);
    std::int64_t arrival =
        at + course.lag_ns + std::llround(-std::log(1.0 - random.uniform()) * course.arrival_jitter_ns);
    if (random.uniform() < course.held_up) arrival += random.below(120) * ms;
    arrival = std::max(arrival, last_arrival + 100 * microsecond);
    last_arrival = arrival;
    recording.frames.push_back({id, stamp, session_start + arrival});
    recording.released_at[session_start + arrival] = session_start + at;
    if (can_match) recording.pulse_of[session_start + arrival] = trigger;
  };
  for (int i = 0; i < course.triggers; ++i) {
    const std::int64_t at = course.due_ns(i);
    const bool is_recorded = random.uniform() >= course.lost_pulses;
    if (is_recorded) recording.pulses.push_back({i, session_start + at});
    if (i == course.clock_set_at) {
      if (course.clock_set_by_ns < 0) {
        offset = -at;
        id = 0;
      } else {
        offset += course.clock_set_by_ns;
      }
    }
    if (at < last_exposure + course.busy_ns) continue;
    last_exposure = at;
    expose(i, at, is_recorded);
    if (random.uniform() < course.doubled)
      expose(i, at + 2 * ms + static_cast<std::int64_t>(random.below(8)) * ms, false);
  }
  return recording;
}

struct Score {
  std::size_t matchable = 0;
  std::size_t right = 0;
  std::size_t wrong = 0;
};

// What became of the frames of a camera, and of the pulses of its line.
struct MatchedFrames {
  std::vector<FrameMatch> frames;  // as they came
  MatchLedger ledger;
  std::optional<CameraClockFigures> clock;
};

// A recording as it comes: pulses in the order of time, frames in that of arrival.
MatchedFrames match_frames(const Recording& recording, const FrameMatcherOptions& options) {
  FrameMatcher matcher(options);
  MatchedFrames matched;
  const auto take = [&] {
    while (const auto match = matcher.next()) matched.frames.push_back(*match);
  };
  auto pulse = recording.pulses.begin();
  for (const FrameSighting& frame : recording.frames) {
    for (; pulse != recording.pulses.end() && pulse->stamp_ns <= frame.received_ns; ++pulse) matcher.add_pulse(*pulse);
    matcher.add_frame(frame);
    take();
  }
  for (; pulse != recording.pulses.end(); ++pulse) matcher.add_pulse(*pulse);
  matcher.finish();
  take();
  matched.ledger = matcher.ledger();
  matched.clock = matcher.clock();
  return matched;
}

Score score(const Recording& recording, const MatchedFrames& matched) {
  Score score;
  score.matchable = recording.pulse_of.size();
  EXPECT_EQ(matched.frames.size(), recording.frames.size());
  for (const FrameMatch& match : matched.frames) {
    EXPECT_EQ(match.pulse.has_value(), match.fate == FrameFate::matched);
    if (!match.pulse) continue;
    const auto truth = recording.pulse_of.find(match.frame.received_ns);
    ++(truth != recording.pulse_of.end() && truth->second == *match.pulse ? score.right : score.wrong);
  }
  const MatchLedger& ledger = matched.ledger;
  EXPECT_EQ(ledger.frames, recording.frames.size());
  EXPECT_EQ(ledger.frames, ledger.matched + ledger.doubled + ledger.without_pulse + ledger.doubtful + ledger.strays);
  EXPECT_EQ(ledger.pulses, recording.pulses.size());
  EXPECT_EQ(ledger.pulses, ledger.matched + ledger.pulses_without_frame + ledger.pulses_too_soon);
  return score;
}

/// 99 of 100 and none wrong, over several seeds.
void expect_matched(const Course& course, const FrameMatcherOptions& options, double share = 0.99) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Recording recording = record(course, seed);
    const Score got = score(recording, match_frames(recording, options));
    EXPECT_EQ(got.wrong, 0U);
    EXPECT_GE(static_cast<double>(got.right), share * static_cast<double>(got.matchable)) << got.matchable;
  }
}

FrameMatcherOptions gige_camera() {
  FrameMatcherOptions options;
  options.ids = gige_block_ids;
  options.least_lag_ns = 5 * ms;
  return options;
}

FrameMatcherOptions without_stamps() {
  FrameMatcherOptions options = gige_camera();
  options.has_device_stamps = false;
  return options;
}

TEST(FrameMatcher, FindsThePulsesOfTenThousandTriggers) {
  Course course;
  course.id_jumps = 0.005;
  expect_matched(course, gige_camera());
}

TEST(FrameMatcher, FindsThemWhereNothingIsAmiss) {
  Course course;
  course.triggers = 2000;
  course.lost_frames = course.lost_pulses = course.drift_ppm = course.stamp_jitter_ns = 0.0;
  expect_matched(course, gige_camera(), 1.0);
}

TEST(FrameMatcher, KnowsHowTheClockRunsAndWhenFramesWithoutPulseWereReleased) {
  const Recording recording = record({}, 7);
  const MatchedFrames matched = match_frames(recording, gige_camera());
  ASSERT_TRUE(matched.clock.has_value());
  EXPECT_NEAR(matched.clock->drift_ppm, 200.0, 1.0);
  EXPECT_NEAR(matched.clock->jitter_ns, 200e3, 100e3);
  std::size_t without = 0;
  for (const FrameMatch& match : matched.frames) {
    if (match.fate != FrameFate::without_pulse) continue;
    ++without;
    const std::int64_t truth = recording.released_at.at(match.frame.received_ns);
    EXPECT_NEAR(static_cast<double>(match.released_ns - truth), 0.0, 5.0 * match.error_ns);
  }
  EXPECT_GT(without, 50U);
  EXPECT_GE(matched.ledger.frames_lost, 150U);
  EXPECT_EQ(matched.ledger.id_jumps, 0U);  // It wraps, and that is none.
  EXPECT_EQ(matched.ledger.restarts, 1U);
}

TEST(FrameMatcher, TellsTheSecondOfTwoExposures) {
  Course course;
  course.doubled = 0.01;
  expect_matched(course, gige_camera());
}

TEST(FrameMatcher, FollowsACameraThatStartsAnew) {
  Course course;
  course.clock_set_at = 4000;
  expect_matched(course, gige_camera());
  course.clock_set_by_ns = 17 * ms;  // Less than tells itself by the times of arrival.
  expect_matched(course, gige_camera());
  course.clock_set_by_ns = 3600 * second;
  expect_matched(course, gige_camera());
}

TEST(FrameMatcher, TellsThePulsesThatTheCameraIgnores) {
  Course course;
  course.due_ns = [](int i) { return i * 10 * ms; };
  course.busy_ns = 16 * ms;
  course.lag_ns = 22 * ms;
  FrameMatcherOptions options = gige_camera();
  options.least_lag_ns = 18 * ms;  // The range is narrower than the pulses are apart.
  options.most_lag_ns = 27 * ms;
  options.least_interval_ns = 16 * ms;
  expect_matched(course, options);
  const Recording recording = record(course, 9);
  const MatchLedger ledger = match_frames(recording, options).ledger;
  EXPECT_GT(ledger.pulses_too_soon, 4500U);
  EXPECT_LT(ledger.pulses_without_frame, 500U);
}

TEST(FrameMatcher, KnowsTheStartOfBurstsFasterThanTheWayOfAFrame) {
  // Bursts of 5 pulses at 100 Hz, half a second apart; a frame takes longer than from one pulse to the next.
  Course course;
  course.due_ns = [](int i) { return (i / 5) * 500 * ms + (i % 5) * 10 * ms; };
  expect_matched(course, gige_camera());
}

TEST(FrameMatcher, MatchesNothingWhereTheStartCannotBeKnown) {
  Course course;
  course.triggers = 1500;
  course.due_ns = [](int i) { return i * 10 * ms; };
  course.lost_frames = course.lost_pulses = 0.0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Recording recording = record(course, seed);
    const MatchedFrames matched = match_frames(recording, gige_camera());
    EXPECT_EQ(matched.ledger.matched, 0U);
    EXPECT_EQ(matched.ledger.doubtful, matched.ledger.frames);
    EXPECT_EQ(score(recording, matched).wrong, 0U);
  }
}

// A camera is asked beforehand whether it has a clock, and may be wrong.
TEST(FrameMatcher, GoesWithoutStampsWhereFramesHaveNone) {
  for (const bool has_first : {false, true}) {
    Recording recording = record({}, 3);
    for (FrameSighting& frame : recording.frames) frame.device_ns.reset();
    if (has_first) recording.frames.front().device_ns = 12 * second;  // It stands still.
    const MatchedFrames matched = match_frames(recording, gige_camera());
    const Score got = score(recording, matched);
    EXPECT_EQ(got.wrong, 0U);
    EXPECT_GE(static_cast<double>(got.right), 0.99 * static_cast<double>(got.matchable));
    EXPECT_EQ(matched.ledger.strays, 0U);
  }
}

TEST(FrameMatcher, OneFrameWithoutAStampIsAStray) {
  Recording recording = record({}, 3);
  recording.frames[1000].device_ns.reset();
  const MatchedFrames matched = match_frames(recording, gige_camera());
  const Score got = score(recording, matched);
  EXPECT_EQ(got.wrong, 0U);
  EXPECT_GE(static_cast<double>(got.right), 0.99 * static_cast<double>(got.matchable));
  EXPECT_EQ(matched.frames[1000].fate, FrameFate::stray);
  EXPECT_NEAR(matched.clock->jitter_ns, 200e3, 100e3) << "the others go by their stamps";
}

TEST(FrameMatcher, MatchesByArrivalAndNumberWhereThereAreNoStamps) {
  Course course;
  course.arrival_jitter_ns = 2e6;
  expect_matched(course, without_stamps());
  course.ids = v4l2_sequence_numbers;
  FrameMatcherOptions options = without_stamps();
  options.ids = v4l2_sequence_numbers;
  expect_matched(course, options);
}

TEST(FrameMatcher, IsNotMisledByFramesThatAreHeldUp) {
  Course course;
  course.held_up = 0.01;
  expect_matched(course, gige_camera());
  expect_matched(course, without_stamps(), 0.95);  // Those that are held up are left out.
}

TEST(FrameMatcher, MatchesAFewFramesWhenNothingMoreComes) {
  Course course;
  course.triggers = 3;
  course.lost_frames = course.lost_pulses = 0.0;
  expect_matched(course, gige_camera(), 1.0);
  course.triggers = 1;
  expect_matched(course, gige_camera(), 1.0);
}

TEST(FrameMatcher, HandsOutFramesWithinItsPatience) {
  FrameMatcher matcher(gige_camera());
  Course course;
  course.triggers = 100;
  course.lost_frames = course.lost_pulses = 0.0;
  const Recording recording = record(course, 3);
  std::size_t decided = 0;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    if (i != 60) matcher.add_pulse(recording.pulses[i]);
    matcher.add_frame(recording.frames[i]);
    while (matcher.next()) ++decided;
    if (i == 30) {
      EXPECT_EQ(decided, 31U) << "a clear frame waits";
    }
  }
  EXPECT_EQ(decided, recording.frames.size());
  EXPECT_EQ(matcher.ledger().without_pulse, 1U);
}

TEST(FrameMatcher, WaitsForAPulseThatIsReportedLate) {
  FrameMatcher matcher(gige_camera());
  Course course;
  course.triggers = 40;
  course.lost_frames = course.lost_pulses = 0.0;
  const Recording recording = record(course, 3);
  for (std::size_t i = 0; i + 1 < recording.frames.size(); ++i) {
    matcher.add_pulse(recording.pulses[i]);
    matcher.add_frame(recording.frames[i]);
    while (matcher.next()) {
    }
  }
  matcher.add_frame(recording.frames.back());
  EXPECT_FALSE(matcher.next().has_value());
  matcher.advance(recording.frames.back().received_ns + 100 * ms);
  EXPECT_FALSE(matcher.next().has_value());
  matcher.add_pulse(recording.pulses.back());
  const auto match = matcher.next();
  ASSERT_TRUE(match.has_value());
  EXPECT_EQ(match->pulse, recording.pulses.back().pulse);
}

TEST(FrameMatcher, LetsFramesGoWhereThereAreNoPulses) {
  Course course;
  course.triggers = 500;
  course.lost_pulses = 1.0;
  const Recording recording = record(course, 1);
  FrameMatcher matcher(gige_camera());
  std::size_t decided = 0;
  for (const FrameSighting& frame : recording.frames) {
    matcher.add_frame(frame);
    while (const auto match = matcher.next()) {
      ++decided;
      EXPECT_EQ(match->fate, FrameFate::without_pulse);
      const std::int64_t truth = recording.released_at.at(match->frame.received_ns);
      EXPECT_NEAR(static_cast<double>(match->released_ns - truth), 0.0, 3.0 * match->error_ns);
    }
  }
  EXPECT_GT(decided + 20, recording.frames.size());
}

TEST(FrameMatcher, RefusesPulsesThatGoBack) {
  FrameMatcher matcher(gige_camera());
  matcher.add_pulse({1, session_start});
  matcher.add_pulse({2, session_start});
  matcher.add_pulse({3, session_start - second});
  EXPECT_EQ(matcher.ledger().pulses, 1U);
  EXPECT_EQ(matcher.ledger().pulses_out_of_order, 2U);
}

TEST(FrameMatcher, TakesAnyStampsAndNumbers) {
  Random random(11);
  FrameMatcher matcher(gige_camera());
  std::size_t decided = 0;
  for (int i = 0; i < 20'000; ++i) {
    matcher.add_pulse(
        {static_cast<std::int64_t>(random.next_u64()), static_cast<std::int64_t>(random.next_u64() >> 3U)});
    matcher.add_frame({random.next_u64(), static_cast<std::int64_t>(random.next_u64()),
                       static_cast<std::int64_t>(random.next_u64() >> (random.below(40)))});
    while (matcher.next()) ++decided;
  }
  matcher.finish();
  while (matcher.next()) ++decided;
  EXPECT_EQ(decided, 20'000U);
}

}  // namespace
}  // namespace rigcal
