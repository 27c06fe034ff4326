#pragma once

#include <string>
#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/quality/verdict.h"

namespace rigcal {

/// From where on what the images tell makes a camera `weak`. Chosen by statistics over simulated rigs with and without
/// wrong minima and wrong intrinsics.
struct CameraThresholds {
  double hold_out = 2.0;                  ///< Offsets of held-out stops over their expected sigma.
  double worse_ratio = 1.5;               ///< They are worse than at the start where they are so many times larger
  double worse_px = 0.1;                  ///< and so much more: a start may be a result.
  double hold_out_share = 0.3;            ///< What they show by more than chance, over what is expected.
  double unlike_share = 0.35;             ///< Stops that show less than so much of what others do of the same lines,
  double least_expected = 1.0;            ///< where these are so many segments, are unlike them;
  std::size_t least_unlike = 2;           ///< one may have somebody before the camera, so many,
  double unlike_stops = 0.1;              ///< and such a share of all, are no accident.
  double moved_gain = 1.3;                ///< The first or the last stops explain so many times more at their own
                                          ///< pose than at that of all.
  std::size_t enough_stops_of_third = 5;  ///< Where these are fewer stops, and halves agree, they count
  double short_times_share = 2.0;         ///< from so far apart on, over the same as `halves_share`.
  double disagreement_chi2 = differing_chi2;  ///< Edges against information.
  double radial_trend_sigmas = 4.0;           ///< The trend of the residuals along the radius,
  double radial_trend_px = 0.3;               ///< if it is as large as this at the corner.
  double centre_chance_px = principal_chance_px;
  double halves_share = 1.0;            ///< Either half of the stops apart, over the larger of the requirement
                                        ///< and the bounds; so far apart other signs of a false match count,
  double farthest_halves_share = 3.0;   ///< and so far apart it takes no other sign.
  double halves_chi2 = differing_chi2;  ///< And over what they may differ by.
  double confirming_share = 1.5;        ///< Information that leads no farther off confirms, over the same.
  double other_lens_gain = 1.2;  ///< From where on the other distortion model is asked about, where something is wrong.
  double runner_up_ratio = 0.95;
  double doubtful_runner_up_ratio = 0.75;  ///< Where information leads elsewhere, sure of it or not,
                                           ///< or nothing was held out and none confirms.
};

/// Files of images that show next to none of the edges that other stops show of the same lines; a few of them do not
/// make a camera weak.
[[nodiscard]] std::vector<std::string> unlike_images(const CameraEstimate& estimate,
                                                     const CameraThresholds& thresholds = {});

/// What the status of a camera means (docs/judging.md): good needs the 95 % bounds inside the requirement, a hold-out
/// within twice the expected noise and not worse than the start, stops that show what the others do, first and last
/// stops that give the same pose or explain no more at their own (of few stops: about the same pose), the runner-up
/// minimum rejected, and checks that agree: the information between reflectivity and grey value, either half of the
/// stops, the intrinsics. Failed is what was not found, did not converge, fits held-out stops worse than its start, or
/// is another pose for either half of the stops without the word of the information: by far more than its sigma, or
/// where a lens that seems to be another one, or information that leads nowhere, speaks against it, too; or whose first
/// and last stops are three times the bounds apart, or of which nothing was seen in the held-out stops, both without
/// that word. Where a lens of the other distortion model explains clearly more, that is the first reason of what is not
/// good. Reasons are sentences a user can act on. `refined`: the intrinsics were to be found, too, and need not agree
/// with the rig file's.
[[nodiscard]] Verdict judge_camera(const CameraEstimate& estimate, const std::string& name, const Requirement& require,
                                   bool refined = false, const CameraThresholds& thresholds = {});

}  // namespace rigcal
