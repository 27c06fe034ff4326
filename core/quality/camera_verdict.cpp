#include "core/quality/camera_verdict.h"

#include <algorithm>
#include <cmath>

#include "core/base/text.h"
#include "core/camera/end_solve.h"
#include "core/quality/verdict_text.h"

namespace rigcal {
namespace {

constexpr std::size_t most_files = 6;  // that a reason names

// Every fourth stop is held out.
constexpr int least_views_to_hold_out = 4;

std::string px(double value) { return number(value, 2) + " px"; }

double sigmas(const ScalarEstimate& e) { return e.sigma > 0.0 ? std::abs(e.value) / e.sigma : 0.0; }

void judge_bounds(const CameraEstimate& e, const Requirement& require, Verdict& verdict) {
  const double t = translation_bound(e.pose.covariance);
  const double r = rotation_bound(e.pose.covariance);
  if (t > require.translation_m) {
    weaken(verdict, "its translation is known to " + mm(t) + " only (95 %, asked for: " + mm(require.translation_m) +
                        "), worst along " + weak_translation_words(e.pose.covariance, e.pose.T_base_camera) +
                        "; add stops with corners of walls or furniture near to the camera");
  }
  if (r > require.rotation_rad) {
    weaken(verdict, "its rotation is known to " + deg(r) + " only (95 %, asked for: " + deg(require.rotation_rad) +
                        "); add stops in which edges of buildings or furniture lie all over the image");
  }
}

void judge_hold_out(const CameraEstimate& e, const CameraThresholds& limits, Verdict& verdict) {
  if (e.hold_out_start_px > 0.0 && e.hold_out_px > limits.worse_ratio * e.hold_out_start_px + limits.worse_px) {
    fail(verdict, "it fits held-out stops worse (" + px(e.hold_out_px) + ") than its start did (" +
                      px(e.hold_out_start_px) +
                      "); its images show no edges that the LiDARs see, or too few: add stops in which "
                      "edges of buildings or furniture are near");
  } else if (e.hold_out > limits.hold_out) {
    weaken(verdict,
           "held-out stops disagree: " + px(e.hold_out_px) + ", " + number(e.hold_out, 1) +
               " times what noise explains: perhaps the camera was moved or refocused during the recording, or they "
               "show other things than the rest; fasten it and its lens, and record again");
  }
  if (e.hold_out == 0.0) {
    weaken(verdict, e.views < least_views_to_hold_out
                        ? "no stop could be held out to check it, for its images come from too few stops (" +
                              counted(e.views, "image") + "); record four stops or more"
                        : "too few edges were seen in the stops that were held out to check it; add stops");
  }
}

bool opinions_disagree(const CameraEstimate& e, const CameraThresholds& limits) {
  return e.information && e.disagreement_chi2 > limits.disagreement_chi2;
}

std::string apart_words(const CameraEstimate& e) { return mm(e.halves_m) + " and " + deg(e.halves_rad); }

// Over the larger of what is asked for and what is known, whichever of place and turn is farther off.
double bounds_apart(double apart_m, double apart_rad, const CameraEstimate& e, const Requirement& require) {
  return std::max(apart_m / std::max(require.translation_m, translation_bound(e.pose.covariance)),
                  apart_rad / std::max(require.rotation_rad, rotation_bound(e.pose.covariance)));
}

// That halves of the stops are apart.
double halves_bounds(const CameraEstimate& e, const Requirement& require) {
  return bounds_apart(e.halves_m, e.halves_rad, e, require);
}

// Grey values lead to the same place, not only within what they do not know.
bool is_confirmed(const CameraEstimate& e, const Requirement& require, const CameraThresholds& limits) {
  if (!e.information || opinions_disagree(e, limits)) return false;
  const SE3 between = e.pose.T_base_camera.inverse() * e.information->T_base_camera;
  return bounds_apart(between.t.norm(), log_so3(between.R).norm(), e, require) <= limits.confirming_share;
}

bool has_other_centre(const CameraEstimate& e, const CameraThresholds& limits) {
  return is_off_px(e.cx_change_px, limits.centre_chance_px) || is_off_px(e.cy_change_px, limits.centre_chance_px);
}

bool asks_for_another_lens(const CameraEstimate& e, const CameraThresholds& limits) {
  return is_off(e.focal_scale) || is_off(e.k1_change) || has_other_centre(e, limits);
}

// At a false match other intrinsics may seem to fit better, too; then `is_doubtful`.
void judge_intrinsics(const CameraEstimate& e, const CameraThresholds& limits, bool is_doubtful, Verdict& verdict) {
  const std::string mend = std::string("; calibrate its intrinsics anew, or try --refine-intrinsics") +
                           (is_doubtful ? ", unless the overlays in report.html show a false match" : "");
  if (is_off(e.focal_scale)) {
    weaken(verdict, "the images fit better with a focal length " + number(100.0 * std::abs(e.focal_scale.value), 2) +
                        " % " + (e.focal_scale.value > 0.0 ? "longer" : "shorter") + " than the rig file's" + mend);
  }
  if (is_off(e.k1_change)) {
    weaken(verdict, "the images fit better with k1 " + std::string(e.k1_change.value > 0.0 ? "larger" : "smaller") +
                        " by " + number(std::abs(e.k1_change.value), 4) + " than the rig file's" + mend);
  }
  if (has_other_centre(e, limits)) {
    weaken(verdict, "the images fit better with a principal point that is " + px(std::abs(e.cx_change_px.value)) +
                        " farther " + (e.cx_change_px.value > 0.0 ? "right" : "left") + " and " +
                        px(std::abs(e.cy_change_px.value)) + " farther " +
                        (e.cy_change_px.value > 0.0 ? "down" : "up") + " than the rig file's" + mend);
  }
  // A wrong focal length or k1 leaves such a trend, too; then they are the reason.
  if (verdict.reasons.empty() && sigmas(e.radial_trend) > limits.radial_trend_sigmas &&
      std::abs(e.radial_trend.value) > limits.radial_trend_px) {
    weaken(verdict, "what is left over points along the radius, " + px(std::abs(e.radial_trend.value)) +
                        " at the corners: the distortion of the rig file is not this lens'" + mend);
  }
}

// Of a pose that is another one for either half of the stops, and that grey values do not confirm: what a false match
// shows beside. Empty: nothing.
std::string why_false(const CameraEstimate& e, const Requirement& require, bool refined,
                      const CameraThresholds& limits) {
  const double bounds = halves_bounds(e, require);
  const std::string far_apart = "far more than its sigma allows";
  // Here the smallest of differences count, so that no more can be asked of grey values than not to contradict.
  if (e.halves_chi2 > limits.halves_chi2 && (!e.information || opinions_disagree(e, limits))) return far_apart;
  if (is_confirmed(e, require, limits)) return {};
  if (bounds > limits.halves_share) {
    // With a lens that is another halves still agree, since it is estimated beside the pose: a false match bends it.
    if (!refined && asks_for_another_lens(e, limits)) return "and another lens than the rig file's seems to fit better";
    if (!e.information) return "and its grey values lead nowhere";
  }
  return bounds > limits.farthest_halves_share ? far_apart : std::string();
}

void judge_second_opinions(const CameraEstimate& e, const Requirement& require, const CameraThresholds& limits,
                           Verdict& verdict) {
  if (opinions_disagree(e, limits)) {
    const SE3 between = e.pose.T_base_camera.inverse() * e.information->T_base_camera;
    weaken(verdict,
           "its edges and its grey values disagree by " + mm(between.t.norm()) + " and " +
               deg(log_so3(between.R).norm()) +
               ", more than both allow; one of them found a false match; look at the overlays in report.html, and give "
               "a closer initial_extrinsics or add stops");
  }
  if (halves_bounds(e, require) > limits.halves_share) {
    weaken(verdict, "either half of its stops gives another pose, " + apart_words(e) +
                        " apart; add stops, or check that the camera sits firmly");
  }
  const bool is_unsure = (e.information || e.hold_out == 0.0) && !is_confirmed(e, require, limits);
  const bool is_as_good = e.runner_up_ratio > limits.runner_up_ratio;
  if (e.runner_up && (is_as_good || (is_unsure && e.runner_up_ratio > limits.doubtful_runner_up_ratio))) {
    const SE3 between = e.pose.T_base_camera.inverse() * *e.runner_up;
    const std::string how_well = is_as_good      ? "nearly as well"
                                 : e.information ? "well, too, and grey values do not lead to this one"
                                                 : "well, too, and nothing tells which is right";
    weaken(verdict, "another pose, " + mm(between.t.norm()) + " and " + deg(log_so3(between.R).norm()) +
                        " away, fits " + how_well + " (" + number(100.0 * e.runner_up_ratio, 0) +
                        " %); give a closer guess or add stops that face other things");
  }
}

// A third each, of those that have images.
bool has_short_times(const CameraEstimate& e, const CameraThresholds& limits) {
  return e.stops.size() / 3 < limits.enough_stops_of_third;
}

// That the first and the last stops are apart, where that says something; else 0.
double times_bounds(const CameraEstimate& e, const Requirement& require, const CameraThresholds& limits) {
  const FirstAndLast& times = e.first_and_last;
  if (times.gain <= limits.moved_gain || times.chi2 <= differing_chi2) return 0.0;
  return bounds_apart(times.apart_m, times.apart_rad, e, require);
}

std::string times_words(const CameraEstimate& e) {
  return "its first and its last stops give poses " + mm(e.first_and_last.apart_m) + " and " +
         deg(e.first_and_last.apart_rad) + " apart, each where its own images fit better";
}

bool are_many(const std::vector<std::string>& files, const CameraEstimate& e, const CameraThresholds& limits) {
  const auto least = static_cast<double>(limits.least_unlike);
  return static_cast<double>(files.size()) >=
         std::max(least, limits.unlike_stops * static_cast<double>(e.stops.size()));
}

// What the offsets of partners do not show: where there is nothing, none are found.
void judge_stops(const CameraEstimate& e, const Requirement& require, const CameraThresholds& limits,
                 Verdict& verdict) {
  // Few stops are apart by what they do not know, along a direction that they see badly: then not by themselves.
  const double apart = times_bounds(e, require, limits);
  if (apart > limits.halves_share) {
    const bool is_by_far = !has_short_times(e, limits) || apart > limits.short_times_share;
    if (is_by_far || halves_bounds(e, require) > limits.halves_share) {
      weaken(verdict, times_words(e) +
                          ": it may have been moved or bumped in between, or these stops alone tell too little; add "
                          "stops, and check that it sits firmly");
    }
  }
  const std::string mend =
      ": the camera or the rig was moved there, they were taken elsewhere, or are too dark or blurred; look at them, "
      "and leave them out or record anew";
  if (const std::vector<std::string> files = unlike_images(e, limits); are_many(files, e, limits)) {
    weaken(verdict, "its images " + joined_some(files, most_files) +
                        " show next to none of the edges that those of other stops show of the same place" + mend);
  } else if (e.hold_out_share && *e.hold_out_share < limits.hold_out_share) {
    weaken(verdict, "the images of the stops that were held out show " +
                        number(100.0 * std::max(0.0, *e.hold_out_share), 0) +
                        " % of the edges that those of other stops show of the same places" + mend);
  }
}

// A principal point that is some pixels off bends the pose of each stop another way, as a false match does.
constexpr const char* wrong_intrinsics_words = "; intrinsics of another lens, or of another image size, do that, too";

Verdict judge_end(const CameraEstimate& e, const std::string& name, const Requirement& require, bool refined,
                  const CameraThresholds& limits) {
  Verdict verdict;
  if (!e.found) {
    fail(verdict, e.why_not.empty()
                      ? "no pose was found for " + name + "; give a closer initial_extrinsics, or add stops"
                      : e.why_not);
    return verdict;
  }
  if (!e.converged) {
    fail(verdict, "its last iterations still moved it; add stops, or give a closer initial_extrinsics");
    return verdict;
  }
  if (!e.pose.covariance.allFinite() || !e.pose.T_base_camera.t.allFinite()) {
    fail(verdict, "its solution is no number: too little holds it; add stops, or give a closer initial_extrinsics");
    return verdict;
  }
  const bool halves_disagree = halves_bounds(e, require) > limits.halves_share;
  const bool is_doubtful = opinions_disagree(e, limits) || halves_disagree;
  if (const std::string why = why_false(e, require, refined, limits); !why.empty()) {
    fail(verdict, "either half of its stops gives another pose, " + apart_words(e) + " apart, " + why +
                      ": a false match, or it moved during the recording; give a closer initial_extrinsics, or add "
                      "stops, and check that it sits firmly" +
                      wrong_intrinsics_words);
    return verdict;
  }
  if (times_bounds(e, require, limits) > limits.farthest_halves_share && !is_confirmed(e, require, limits)) {
    fail(verdict, times_words(e) +
                      ", and grey values do not lead to its own: a false match, or it was moved during "
                      "the recording; give a closer initial_extrinsics, or fasten it and record anew" +
                      wrong_intrinsics_words);
    return verdict;
  }
  if (e.hold_out == 0.0 && e.views >= least_views_to_hold_out && !is_confirmed(e, require, limits)) {
    fail(verdict,
         "nothing confirms it: too few edges were seen in the stops that were held out, and grey values do not "
         "lead to it; add stops in which edges of buildings or furniture are near");
    return verdict;
  }
  // First what may be the cause of all else.
  if (!refined) judge_intrinsics(e, limits, is_doubtful, verdict);
  judge_stops(e, require, limits, verdict);
  judge_second_opinions(e, require, limits, verdict);
  judge_bounds(e, require, verdict);
  judge_hold_out(e, limits, verdict);
  return verdict;
}

std::string other_lens_words(DistortionModel given) {
  const bool is_wide = given == DistortionModel::equidistant;
  return std::string(is_wide ? "a radtan lens" : "an equidistant (fisheye) lens") +
         " of its focal length explains its images better than " + (is_wide ? "an equidistant one" : "a radtan one") +
         "; correct model in its intrinsics, unless it is right";
}

}  // namespace

std::vector<std::string> unlike_images(const CameraEstimate& e, const CameraThresholds& limits) {
  std::vector<std::string> files;
  for (const StopAgreement& stop : e.stops) {
    const bool says_something = stop.expected >= limits.least_expected;
    if (says_something && stop.more_than_chance() < limits.unlike_share * stop.expected) files.push_back(stop.file);
  }
  return files;
}

Verdict judge_camera(const CameraEstimate& e, const std::string& name, const Requirement& require, bool refined,
                     const CameraThresholds& limits) {
  Verdict verdict = judge_end(e, name, require, refined, limits);
  if (verdict.status != Status::good && e.other_lens_gain > limits.other_lens_gain) {
    verdict.reasons.insert(verdict.reasons.begin(), other_lens_words(e.intrinsics.model));
  }
  return verdict;
}

}  // namespace rigcal
