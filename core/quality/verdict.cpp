#include "core/quality/verdict.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/text.h"
#include "core/camera/camera_calibration.h"
#include "core/quality/verdict_text.h"
#include "core/voxel/cells.h"

namespace rigcal {
namespace {

// Rough poses are asked for to 10 degrees and 0.2 m.
constexpr double far_from_guess_rad = to_rad(30.0);
constexpr double far_from_guess_m = 0.5;
// As much on common planes as of the base: what has less may be a false match, and what has less than half of that is
// one where anything else speaks against it.
constexpr double sure_share = 0.4;
constexpr double mislaid_share = 0.2;
// A start may be a result: then both are the same but for noise.
constexpr double worse_ratio = 1.1;
constexpr double worse_m = 1e-3;
constexpr double disagreeing_hold_out = 2.0;
// With fewer stops, wider steps or a narrower sector LiDARs that look apart need not have seen the same.
constexpr int enough_stops = 4;
constexpr double wide_step_rad = to_rad(60.0);
constexpr double narrow_sector_rad = to_rad(180.0);
// What never turned saw other things by moving on, unless it stood.
constexpr double least_step_rad = to_rad(1.0);
constexpr double least_step_m = 0.1;
// Of what lies on planes in the better half.
constexpr double one_half_share = 0.4;
// Of what is asked for: stops and planes follow what slipped, and gates leave out what is far off.
constexpr double slipped_share = 0.2;

// Of how many stops, and how far apart, between `before` and `after`; empty where it is not known.
std::string stops_words(const LidarEvidence& e, const std::string& before, const std::string& after) {
  if (e.stops <= 0) return {};
  std::string words = before + counted(e.stops, "stop");
  if (e.stops > 1) words += ", found " + number(to_deg(e.step_rad), 0) + " degrees from one to the next";
  return words + after;
}

// Then the rig file need not be wrong where nothing fits.
bool saw_too_little(const LidarEvidence& e) {
  if (e.stops <= 0) return false;
  if (e.step_rad <= least_step_rad) return e.stops < enough_stops || e.step_m <= least_step_m;
  return e.stops < enough_stops || e.step_rad > wide_step_rad || (e.stops - 1) * e.step_rad < narrow_sector_rad;
}

void judge_observability(const LidarEvidence& e, Verdict& verdict) {
  const OpenDirections open = open_directions(e.covariance, e.T_base_sensor);
  if (open.what.empty()) return;
  fail(verdict, "not observable: the surfaces that " + e.name + " and the other LiDARs share leave " + open.what +
                    " open; add " + open.surface + " where it and the others look" + turn_words(e.helpful_turn));
}

// What else than more stops mends where `bound` is more than `required`; empty: stops agree, or noise alone explains
// it: along what no surface holds they differ by anything.
std::string wandering_words(double scatter, double bound, double required) {
  if (!(scatter > 1.0) || bound > std::sqrt(scatter) * required) return {};
  return "single stops differ in it by " + number(std::sqrt(scatter), 1) +
         " times what noise explains: a mount that does not sit firmly, or stops that were laid on each other wrongly; "
         "fasten it, let the rig rest in each stop, and record again";
}

void judge_bounds(const LidarEvidence& e, const Requirement& require, Verdict& verdict) {
  const double t = translation_bound(e.covariance);
  const double r = rotation_bound(e.covariance);
  if (!(t <= require.translation_m)) {
    const std::string wanders = wandering_words(e.scatter.place, t, require.translation_m);
    weaken(verdict, "its translation is known to " + mm(t) + " only (95 %, asked for: " + mm(require.translation_m) +
                        "), worst along " + weak_translation_words(e.covariance, e.T_base_sensor) + "; " +
                        (wanders.empty() ? "add stops that see a surface facing that way: " +
                                               surface_for_weak_translation(e.covariance, e.T_base_sensor) +
                                               turn_words(e.helpful_turn)
                                         : wanders));
  }
  if (!e.frozen.isZero()) {
    weaken(verdict, "no surface faces " + direction_words(e.T_base_sensor.R * e.frozen) +
                        ": along it the place is what shapes told at the start, nothing was fitted; add stops that see "
                        "one that does" +
                        turn_words(e.helpful_turn));
  }
  if (!(r <= require.rotation_rad)) {
    const std::string wanders = wandering_words(e.scatter.turn, r, require.rotation_rad);
    weaken(verdict, "its rotation is known to " + deg(r) + " only (95 %, asked for: " + deg(require.rotation_rad) +
                        "); " + (wanders.empty() ? "add stops with larger or farther surfaces" : wanders));
  }
  const double t_data = translation_bound(e.covariance_data_only);
  const double r_data = rotation_bound(e.covariance_data_only);
  if (!(t_data <= std::max(2.0 * t, require.translation_m) && r_data <= std::max(2.0 * r, require.rotation_rad))) {
    const bool is_open = t_data > open_translation_m || r_data > open_rotation_rad;
    weaken(verdict, "part of it comes from the given poses and guesses, not from the data (the data alone " +
                        (is_open ? "leave it open" : "tell it to " + mm(t_data) + " and " + deg(r_data)) +
                        "); record stops in which it and " + e.base_name + " see the same surfaces");
  }
}

// By more than chance, and by what matters.
bool slipped(const TimeHalves& halves, const Requirement& require) {
  return halves.compared && halves.chi2 > differing_chi2 &&
         (halves.translation_m > slipped_share * require.translation_m ||
          halves.rotation_rad > slipped_share * require.rotation_rad);
}

void judge_halves(const LidarEvidence& e, const Requirement& require, Verdict& verdict) {
  const bool is_base = !slipped(e.halves, require);
  const TimeHalves& halves = is_base ? e.base_halves : e.halves;
  if (!slipped(halves, require)) return;
  weaken(verdict,
         "stops before " + std::to_string(halves.first_later_stop) + " and from it on give " +
             (is_base ? e.base_name + ", the base," : std::string("it")) + " places that are " +
             mm(halves.translation_m) + " and " + deg(halves.rotation_rad) +
             " apart or more: a mount that slipped or was moved during the recording, or stops that were laid on each "
             "other wrongly; fasten it and record again");
}

// Gates have left most of one half out.
bool fits_one_half(const HalfShares& used) {
  return std::min(used.earlier, used.later) < one_half_share * std::max(used.earlier, used.later);
}

void judge_used_halves(const LidarEvidence& e, Verdict& verdict) {
  const bool own = fits_one_half(e.used_halves);
  const bool of_base = fits_one_half(e.base_used_halves);
  if (own == of_base) return;  // where both see little it is the place
  const HalfShares& used = own ? e.used_halves : e.base_used_halves;
  weaken(verdict, number(100.0 * used.earlier, 0) + " % of what " +
                      (own ? std::string("it") : e.base_name + ", the base,") + " saw before stop " +
                      std::to_string(used.first_later_stop) + " lies on common planes, from it on " +
                      number(100.0 * used.later, 0) +
                      " %: a mount that slipped or was moved during the recording, and the place is that of one half "
                      "only; fasten it and record again");
}

// A guess speaks against places far from it.
bool is_ambiguous(const LidarEvidence& e) {
  return e.runner_up_score > (e.has_guess ? 0.9 : ambiguous_share) * e.match_score;
}

bool is_worse_than_start(const LidarEvidence& e) {
  return e.hold_out_start_rms_m > 0.0 && !(e.hold_out_rms_m <= std::max(worse_ratio * e.hold_out_start_rms_m, worse_m));
}

bool is_far_from_guess(const LidarEvidence& e) {
  return e.from_guess_rad > far_from_guess_rad || e.from_guess_m > far_from_guess_m;
}

bool fits_here_only(const LidarEvidence& e) {
  return !is_ambiguous(e) && e.used_share >= sure_share && e.hold_out <= disagreeing_hold_out;
}

// What moves on with each map of one grid is a false match, mostly: nothing else may speak against its place.
bool came_to_rest(const LidarEvidence& e) {
  const bool is_expected = e.has_guess && !is_far_from_guess(e) && !e.has_assumed_steps;
  return e.converged && (!e.settled_late || (is_expected && fits_here_only(e)));
}

// So that the rig file is what is wrong where it says another.
bool is_place_sure(const LidarEvidence& e) { return came_to_rest(e) && fits_here_only(e) && !is_worse_than_start(e); }

std::string from_guess_words(const LidarEvidence& e) {
  return number(to_deg(e.from_guess_rad), 0) + " degrees and " + number(e.from_guess_m, 2) +
         " m from its own initial_extrinsics";
}

void judge_place(const LidarEvidence& e, Verdict& verdict) {
  if (!e.same_place_as.empty()) {
    weaken(verdict, "it stands just where " + e.same_place_as +
                        " does: both seem to have the same points; check their folders, topics and addresses");
  }
  const bool is_sure = is_place_sure(e);
  if (e.guess_is_inverse) {
    weaken(verdict,
           "it stands where the inverse of its initial_extrinsics has it; invert those of the rig file (they "
           "are T_base_sensor: p_base = R p_sensor + t)");
  } else if (!e.stands_at.empty() && is_sure) {
    weaken(verdict, "it stands where the rig file has " + e.stands_at + ", " + from_guess_words(e) +
                        ": the units are in the wrong order; swap their broadcast codes, addresses or folders");
  } else if (e.same_place_as.empty() && is_far_from_guess(e)) {
    weaken(verdict, "it ended " + from_guess_words(e) +
                        (is_sure ? ": these are wrong (axes, order of the quaternion, direction), or its points are "
                                   "(mirrored, or of other axes); mend them or leave initial_extrinsics out"
                                 : ", but too little is shared to say which of the two is right; record more stops, in "
                                   "smaller turns, in which it and the others see the same surfaces" +
                                       stops_words(e, " (there were ", ")")));
  }
}

void judge_share(const LidarEvidence& e, Verdict& verdict) {
  if (e.used_share >= sure_share) return;
  weaken(verdict, "only " + number(100.0 * e.used_share, 0) +
                      " % as much of what it saw as of the base's lies on common planes: its pose may be a false "
                      "match, or its packets are stamped by another clock than the others'; add stops in which it and "
                      "the others see the same surfaces, and see its clock by rigcal inspect");
}

// What lies on next to nothing that others saw, and has another sign of a false match; has all other signs of one; or
// rests on steps that nobody saw and is far from where it was expected.
std::string why_mislaid(const LidarEvidence& e) {
  if (e.has_guess && is_far_from_guess(e) && is_ambiguous(e) && !(e.hold_out <= disagreeing_hold_out)) {
    return "it ended " + from_guess_words(e) +
           ", another pose fits its surfaces nearly as well, and held-out stops "
           "disagree by " +
           number(e.hold_out, 1) +
           " times what noise explains: a false match; record stops, in smaller turns, in which it and the others see "
           "the same surfaces, and check initial_extrinsics";
  }
  const bool is_known_mixup = !e.stands_at.empty() || e.guess_is_inverse;
  if (e.has_guess && is_far_from_guess(e) && e.has_assumed_steps && !is_known_mixup) {
    return "it ended " + from_guess_words(e) +
           ", and the steps of the table that it rests on were assumed: a false match, or the rig turned otherwise; "
           "record more stops in smaller, equal turns, or with a gyro, and check initial_extrinsics";
  }
  if (!(e.used_share < mislaid_share)) return {};
  std::string sign;
  if (!e.has_guess) {
    sign = "it has no initial_extrinsics that would confirm it";
  } else if (is_far_from_guess(e)) {
    sign = "it ended " + from_guess_words(e);
  } else if (!(e.hold_out <= disagreeing_hold_out)) {
    sign = "held-out stops disagree by " + number(e.hold_out, 1) + " times what noise explains";
  } else {
    return {};
  }
  return "only " + number(100.0 * e.used_share, 0) +
         " % as much of what it saw as of the base's lies on common planes, and " + sign +
         ": a false match; give rough initial_extrinsics (10 degrees, 0.2 m) if they are missing or wrong, and record "
         "stops in which it and the others see the same surfaces";
}

// Why there is no place to be judged; empty: there is one.
std::string why_no_place(const LidarEvidence& e) {
  const std::string match = "(best match " + number(100.0 * e.match_score, 0) + " %)";
  const std::string another_base = e.name == e.base_name ? ", or name another base" : "";
  if (!e.has_points && e.saw_too_far) {
    return "all its points in range lie farther than " + number(CellOptions{}.max_range_m, 0) +
           " m, where none are used; let it see nearer surfaces, or check that what it sees is in metres" +
           another_base;
  }
  if (!e.has_points) {
    return std::string(
               "it has no points in any stop; check its cable, its address and its entry in the rig file (range "
               "in metres, as clouds in files are)") +
           another_base;
  }
  if (!e.base_has_points) return blind_base_words(e.base_name);
  if (!e.found && !e.has_guess) {
    const std::string of_one_stop =
        e.stops == 1 ? " of a single stop take --method planes, before a corner that both see, or" : "";
    return "without initial_extrinsics it could not be laid on what " + e.base_name + " saw " + match + ";" +
           of_one_stop +
           " give rough ones (10 degrees, 0.2 m), or record more stops in smaller turns, all the way round, so that it "
           "sees the same surfaces from neighbouring stops";
  }
  if (!e.found) {
    const std::string none =
        "no pose near its initial extrinsics lays its surfaces on those of " + e.base_name + " " + match;
    if (saw_too_little(e)) {
      return none + ": both need not have seen the same in so few stops, or so narrow a turn, or so wide steps" +
             stops_words(e, " (", ")") +
             "; record stops in smaller turns, all the way round, or add stops in which both see the same surfaces; "
             "only then check initial_extrinsics (direction p_base = R p_sensor + t)";
    }
    return none +
           "; check initial_extrinsics (direction p_base = R p_sensor + t), or add stops in which both see the same "
           "surfaces";
  }
  if (!e.took_part) {
    return "all stops in which it saw something were left out: the warnings say why; record more stops, in smaller "
           "turns, and let the rig rest in each";
  }
  // Numbers that are none hold nothing.
  if (!e.observable || !e.covariance.allFinite() || !e.covariance_data_only.allFinite() ||
      !e.T_base_sensor.matrix().allFinite()) {
    return "the planes do not fix it; add stops, or surfaces of other directions";
  }
  return {};
}

void judge_end(const LidarEvidence& e, const Requirement& require, Verdict& verdict) {
  if (came_to_rest(e)) {
    judge_bounds(e, require, verdict);
    return;
  }
  // Of its place the bounds say nothing.
  const bool is_told = e.last_move_m > 0.0 || e.last_move_rad > 0.0;
  fail(verdict, "it did not come to rest, the last iterations still moved it" +
                    (is_told ? " by " + mm(e.last_move_m) + " and " + deg(e.last_move_rad) : std::string()) +
                    ": a false match of it or of stops, a scene that changes between them, or one that is too poor; "
                    "turn by smaller steps, and give rough initial_extrinsics (10 degrees, 0.2 m)");
}

// Turned by one step of an even table a LiDAR sees what it would see there: all fits, a step of the table off.
void judge_numbers(const LidarEvidence& e, Verdict& verdict) {
  if (!e.shifted_stops) return;
  const auto span = [](const StopSpan& stops) {
    return std::to_string(stops.first) + " to " + std::to_string(stops.last);
  };
  weaken(verdict, "its clouds are of stops " + span(*e.shifted_stops) + ", those of " + e.base_name + " of stops " +
                      span(e.base_stops) +
                      ": if both were taken at the same stops, it stands off by a turn of the table; give clouds of "
                      "one stop the same number, or take out those of stops that only one of them has");
}

void judge_hold_out(const LidarEvidence& e, Verdict& verdict) {
  if (!e.is_checked) {
    weaken(verdict,
           "too little was seen in the stops that were held out to check it; record more stops in which it "
           "and the others see the same surfaces");
  }
  if (!(e.hold_out <= disagreeing_hold_out)) {
    weaken(verdict,
           "held-out stops disagree: " + mm(e.hold_out_rms_m) + " rms, " + number(e.hold_out, 1) +
               " times what noise explains: perhaps it was moved or bumped during the recording, or its packets are "
               "stamped by another clock than the others'; fasten it, see its clock by rigcal inspect, and "
               "record again");
  }
}

}  // namespace

Verdict judge_lidar(const LidarEvidence& e, const Requirement& require) {
  Verdict verdict;
  if (const std::string why = why_no_place(e); !why.empty()) {
    fail(verdict, why);
    return verdict;
  }
  judge_observability(e, verdict);
  if (verdict.status == Status::failed) return verdict;
  judge_end(e, require, verdict);
  if (e.has_assumed_steps) weaken(verdict, assumed_steps_words());
  if (is_ambiguous(e)) {
    weaken(verdict, "another pose fits its surfaces nearly as well (" + number(100.0 * e.runner_up_score, 0) +
                        " % against " + number(100.0 * e.match_score, 0) +
                        " %); the scene is symmetric: give a closer guess or add stops");
  }
  if (const std::string why = why_mislaid(e); !why.empty()) {
    fail(verdict, why);
  } else {
    judge_place(e, verdict);
    judge_share(e, verdict);
  }
  judge_numbers(e, verdict);
  judge_hold_out(e, verdict);
  judge_halves(e, require, verdict);
  judge_used_halves(e, verdict);
  if (is_worse_than_start(e)) {
    fail(verdict, "it fits held-out stops worse (" + mm(e.hold_out_rms_m) + ") than its start did (" +
                      mm(e.hold_out_start_rms_m) +
                      "); add stops in which it and the others see the same surfaces, and check initial_extrinsics");
  }
  return verdict;
}

}  // namespace rigcal
