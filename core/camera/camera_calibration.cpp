#include "core/camera/camera_calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/seconds.h"
#include "core/camera/camera_checks.h"
#include "core/camera/camera_minima.h"
#include "core/camera/camera_start.h"
#include "core/camera/edge_search.h"
#include "core/camera/end_solve.h"
#include "core/camera/information.h"
#include "core/camera/other_lens.h"
#include "core/camera/second_opinion.h"
#include "core/camera/stop_checks.h"

namespace rigcal {
namespace {

// How far the intrinsics of the rig file may be off: a scale of the focal lengths and k1 are estimated with the pose
// under these sigmas. They are estimated freely as well, so that what is wrong with them is seen; where they are
// clearly others, the pose is that with the freely estimated ones.
constexpr double focal_sigma = 0.0007;
constexpr double k1_sigma = 0.002;

// Fewer segments in all images together would fit anything.
constexpr std::size_t least_segments = 12;

// Where few stops have images few edges hold a start while matches are still sought far away: it must be nearer then.
constexpr std::size_t least_stops_for_closeness = 4;
constexpr double closest_px = 2.0;

// Minima whose scores are so near to each other are looked at again.
constexpr double unclear_ratio = 0.7;
// Without a guess a place is not found where another one explains so much of what it explains.
constexpr double unfound_ratio = 0.85;

// So far from the edges' end grey values tell of another place even where they are not sure of it. What edges come to
// from there is taken where grey values then contradict clearly less and lead nearly to it, and halves of the stops
// agree about as well as before.
constexpr double elsewhere_m = 0.015;
constexpr double elsewhere_rad = to_rad(0.15);
constexpr double nearer_share = 0.5;
constexpr double end_share = 1.5;
constexpr double less_firm = 2.0;
constexpr double less_firm_m = 0.01;

// Sigma of what all edges of all images are off by together, along rows and columns. It stands in no residual, and
// weighs the more the fewer pixels an image has.
constexpr double images_shift_px = 0.1;

// Halves of the stops that are so far apart may be of a lens that is another one.
constexpr double unlike_halves_m = 0.01;
constexpr double unlike_halves_rad = to_rad(0.1);

// A place that the images alone tell is no other guess than was given up to here.
constexpr double farthest_sigmas = 4.0;

class CameraCalibration {
 public:
  CameraCalibration(const CameraScene& scene, const CameraTask& camera, const CameraCalibrationOptions& options,
                    const RunContext& context)
      : scene_(scene), camera_(camera), options_(options), context_(context), levels_(standard_levels()) {}

  Expected<CameraEstimate> run() {
    const auto start = SteadyClock::now();
    estimate_.intrinsics = camera_.intrinsics;
    find();
    if (context_.cancelled()) return cancelled_error();
    estimate_.wall_s = seconds_since(start);
    return std::move(estimate_);
  }

 private:
  void find() {
    views_ = make_edge_views(scene_, camera_);
    estimate_.views = static_cast<int>(views_.size());
    if (views_.empty()) {
      estimate_.why_not = camera_.views.empty()
                              ? "there is no image of it; record some at each stop"
                              : "none of its images shows an edge: they are black, blurred or of "
                                "another size than the rig file says, or their stops are not known; look at "
                                "them, and mend exposure, focus or the rig file's width and height";
      return;
    }
    choose_start();
    if (!estimate_.why_not.empty() || context_.cancelled()) return;
    estimate_.start_score = best_.score;
    if (estimate_.start_score <= options_.beaten_start_score) {
      estimate_.why_not = "what was found before explains as many of its edges";
      return;
    }
    find_end();
    if (estimate_.found && !found_centre_) widen_by_shift_of_images();
    if (!context_.cancelled() && is_of_another_lens_perhaps()) ask_other_lens();
  }

  void find_end() {
    finish();
    if (context_.cancelled() || follow_second_opinion()) return;
    for (const bool everywhere : {false, true}) {
      if (context_.cancelled() || !is_doubtful()) return;
      if (!start_anew(everywhere)) continue;
      finish();
      if (context_.cancelled() || follow_second_opinion()) return;
    }
  }

  void finish() {
    const CameraEnd end =
        solve_end(scene_, camera_, options_.refine_intrinsics, priors_, best_.state, views_, context_);
    take_end(end);
    if (context_.cancelled()) return;
    const MatchOptions& match = levels_.back().match;
    set_fit(fit_quality(scene_, camera_.intrinsics, best_.state, match, views_));
    check_by_stops({scene_, camera_, end.priors, levels_.back(), views_}, best_, context_, estimate_);
    ask_second_opinion(scene_, camera_, best_.state, context_, estimate_);
  }

  // Where all images show edges a little to one side, as shadows of one light do, pose, focal length and k1 take it in;
  // a principal point that is estimated would, and its sigma is in the pose's already.
  void widen_by_shift_of_images() {
    constexpr int estimated = camera_parameters - 2;  // all but the principal point
    const CameraMatrix& information = best_.information;
    const Eigen::Matrix<double, estimated, 2> moved_by_px =
        information.topLeftCorner<estimated, estimated>().ldlt().solve(information.topRightCorner<estimated, 2>());
    const Eigen::Matrix<double, pose_parameters, 2> shift = images_shift_px * moved_by_px.topRows<pose_parameters>();
    estimate_.pose.covariance += shift * shift.transpose();
  }

  // What a wrong minimum shows.
  [[nodiscard]] bool is_doubtful() const {
    return !estimate_.converged || estimate_.runner_up_ratio > unfound_ratio ||
           estimate_.disagreement_chi2 > differing_chi2 || estimate_.halves_chi2 > differing_chi2;
  }

  // What a wrong distortion model shows: no other intrinsics of the same model are right either.
  [[nodiscard]] bool is_of_another_lens_perhaps() const {
    if (stops_of(views_) < least_stops_for_intrinsics) return false;  // any lens explains a few images
    return is_doubtful() || is_off(estimate_.focal_scale) || is_off(estimate_.k1_change) ||
           is_off_px(estimate_.cx_change_px) || is_off_px(estimate_.cy_change_px) ||
           estimate_.halves_m > unlike_halves_m || estimate_.halves_rad > unlike_halves_rad;
  }

  void ask_other_lens() {
    EdgePriors free = with_free_intrinsics(priors_);
    free.T_base_camera = camera_.guess_T_base_camera.value_or(best_.state.T_base_camera);
    free.rotation_rad = options_.guess_sigma_rad;
    free.translation_m = options_.guess_sigma_m;
    estimate_.other_lens_gain = other_lens_gain(scene_, camera_.intrinsics, best_.state, free, views_, context_);
  }

  void set_priors(const SE3& guess_T_base_camera) {
    priors_.T_base_camera = guess_T_base_camera;
    priors_.rotation_rad = options_.guess_sigma_rad;
    priors_.translation_m = options_.guess_sigma_m;
    priors_.focal_scale = focal_sigma;
    priors_.k1 = k1_sigma;
  }

  // Of few edges a wrong place may explain more than the right one. Grey values are another witness: where they lead to
  // another place, and edges end there with them, two agree against one, and that is the end. What was found before is
  // then the runner-up. Says whether they were followed.
  bool follow_second_opinion() {
    if (!estimate_.information) return false;
    const bool is_sure = estimate_.disagreement_chi2 > differing_chi2;
    if (!is_sure && !is_elsewhere(*estimate_.information)) return false;
    const EdgeSolution before = best_;
    const CameraEstimate estimate_before = estimate_;
    const EdgePriors priors_before = priors_;
    best_.state.T_base_camera = estimate_.information->T_base_camera;
    widen_priors(best_.state.T_base_camera);
    finish();
    if (context_.cancelled()) return false;
    const bool agrees = estimate_.converged && estimate_.information && estimate_.disagreement_chi2 <= differing_chi2 &&
                        (is_sure || (estimate_.disagreement_chi2 < nearer_share * estimate_before.disagreement_chi2 &&
                                     !is_elsewhere(*estimate_.information, end_share)));
    const bool is_as_firm = estimate_.halves_m < less_firm * estimate_before.halves_m + less_firm_m;
    if (agrees && is_as_firm && best_.score > unclear_ratio * before.score) {
      if (is_same_minimum(before.state, best_.state, 1.0)) return true;
      estimate_.runner_up = before.state.T_base_camera;
      estimate_.runner_up_ratio = std::min(1.0, before.score / best_.score);
      return true;
    }
    best_ = before;
    estimate_ = estimate_before;
    priors_ = priors_before;
    return false;
  }

  // Than the edges, by more than a pose may be off, `share` times.
  [[nodiscard]] bool is_elsewhere(const PoseEstimate& opinion, double share = 1.0) const {
    return !is_within(best_.state.T_base_camera, opinion.T_base_camera, share * elsewhere_rad, share * elsewhere_m);
  }

  // A guess that is off by more than it may be is no better known than that.
  void widen_priors(const SE3& T_base_camera) {
    const Vector6d off = (priors_.T_base_camera.inverse() * T_base_camera).log();
    const double off_rad = off.head<3>().norm();
    const double off_m = off.tail<3>().norm();
    if (off_rad > farthest_sigmas * priors_.rotation_rad) priors_.rotation_rad = off_rad;
    if (off_m > farthest_sigmas * priors_.translation_m) priors_.translation_m = off_m;
  }

  [[nodiscard]] std::size_t segments() const {
    std::size_t count = 0;
    for (const EdgeView& view : views_) count += view.segments.size();
    return count;
  }

  // The best of what is found around the guess, or around each place where a camera without one may be.
  void choose_start() {
    std::vector<Minimum> minima;
    if (camera_.guess_T_base_camera) {
      choose_around_guess(*camera_.guess_T_base_camera, minima);
      if (minima.empty()) {
        estimate_.why_not =
            "its images show too few edges of the map; record where walls, floors and corners meet in most images, "
            "within view of the LiDARs too, and give a guess within " +
            std::to_string(static_cast<int>(to_deg(options_.guess_sigma_rad))) + " degrees";
      }
      return;
    }
    const CameraStarts starts = find_camera_starts(scene_, camera_, context_);
    for (const SE3& start : starts.T_base_camera) solve_apart(start, minima);
    if (context_.cancelled()) return;
    if (!minima.empty()) take(compare_minima(minima));
    if (minima.empty()) {
      estimate_.why_not = "it cannot be found without a rough pose (" +
                          (starts.why_none.empty() ? "its images show too few edges of the map" : starts.why_none) +
                          "); give one under initial_extrinsics in the rig file, or by --initial (10 degrees, 0.2 m)";
      return;
    }
    if (estimate_.runner_up_ratio > unfound_ratio) {
      estimate_.why_not =
          "without a rough pose several places explain its images (another one by " +
          std::to_string(static_cast<int>(std::lround(100.0 * estimate_.runner_up_ratio))) +
          " % as well); give one under initial_extrinsics in the rig file, or by --initial (10 degrees, "
          "0.2 m), or record where more edges are near";
      return;
    }
    // What was found is from now on the guess: how far from it the start of the search was says nothing.
    set_priors(best_.state.T_base_camera);
  }

  // Where its guess led to a doubtful end: whether another place explains clearly more, which becomes the start of
  // another end. It is looked for around the end, or where the images alone lead to, not far from the guess. One that
  // explains as much as the end speaks against it, unless another one was known that speaks louder.
  bool start_anew(bool everywhere) {
    if (!camera_.guess_T_base_camera) return false;
    find_visible(scene_, camera_.intrinsics, best_.state, sparse_view, views_);
    const EdgeSums sums = sum_segments(scene_, camera_.intrinsics, best_.state, levels_.back().match, views_);
    const Minimum end{best_, sums.score() * root_of_segments()};
    std::vector<Minimum> found{end};
    if (everywhere) {
      for (const SE3& start : find_camera_starts(scene_, camera_, context_).T_base_camera) solve_apart(start, found);
    } else {
      solve_apart(end.end.state.T_base_camera, found);
    }
    set_priors(*camera_.guess_T_base_camera);
    if (context_.cancelled()) return false;
    std::erase_if(found, [&](const Minimum& minimum) {
      return !is_within(*camera_.guess_T_base_camera, minimum.end.state.T_base_camera,
                        farthest_sigmas * options_.guess_sigma_rad, farthest_sigmas * options_.guess_sigma_m);
    });
    if (estimate_.runner_up)
      found.push_back({{CameraState{*estimate_.runner_up}}, estimate_.runner_up_ratio * end.worth});
    const bool is_elsewhere = is_beaten(end, found);
    take(is_elsewhere ? compare_minima(found) : compare_with(end, found));
    return is_elsewhere;
  }

  // Around a start that competes with others elsewhere, where views show other things.
  void solve_apart(const SE3& start, std::vector<Minimum>& minima) {
    if (context_.cancelled()) return;
    std::vector<Minimum> own;
    look_around(start, own);
    for (Minimum& each : own) each.worth *= root_of_segments();
    minima.insert(minima.end(), own.begin(), own.end());
  }

  [[nodiscard]] double root_of_segments() const { return std::sqrt(static_cast<double>(segments())); }

  // Solves from every start that the search around a guess finds, with few samples. Adds nothing where too little is
  // seen from there.
  void look_around(const SE3& guess, std::vector<Minimum>& minima) {
    set_priors(guess);
    find_visible(scene_, camera_.intrinsics, CameraState{guess}, sparse_view, views_);
    if (segments() < least_segments) return;
    const bool look_closely = stops_of(views_) < least_stops_for_closeness;
    std::vector<SE3> starts = look_closely
                                  ? search_edges(scene_, camera_.intrinsics, guess, priors_, views_, closest_px)
                                  : search_edges(scene_, camera_.intrinsics, guess, priors_, views_);
    starts.push_back(guess);
    for (const SE3& start : starts) solve_quickly(start, minima);
  }

  // The best of those around the guess becomes the start of the end.
  void choose_around_guess(const SE3& guess, std::vector<Minimum>& minima) {
    look_around(guess, minima);
    if (minima.empty()) return;
    take(compare_minima(minima));
    if (estimate_.runner_up_ratio < unclear_ratio) return;
    // Edges alone do not tell the minima apart; reflectivity may know a better start.
    const auto search = search_information(scene_, camera_, guess, options_, context_);
    if (!search) return;
    solve_quickly(search->best.T_base_camera, minima);
    if (search->runner_up) solve_quickly(search->runner_up->T_base_camera, minima);
    take(compare_minima(minima));
  }

  // Once the first levels have drawn a start to where another one ended, nothing new comes of it.
  void solve_quickly(const SE3& start, std::vector<Minimum>& minima) {
    const std::vector<SolveLevel> levels = quick_levels();
    constexpr std::size_t first = 2;
    const auto solved = [&](const CameraState& from, std::span<const SolveLevel> some) {
      const EdgeSolution solution = solve_edges(scene_, camera_.intrinsics, from, priors_, some, views_, context_);
      estimate_.iterations += solution.iterations;
      return solution;
    };
    const EdgeSolution drawn = solved(CameraState{start}, std::span(levels).first(first));
    const bool known = std::any_of(minima.begin(), minima.end(), [&](const Minimum& other) {
      return is_same_minimum(drawn.state, other.end.state, 0.5);
    });
    if (known) return;
    const EdgeSolution end = solved(drawn.state, std::span(levels).subspan(first));
    minima.push_back({end, end.score});
  }

  // The best, and the best other one; no other one is left of those that were met before.
  void take(const Minima& minima) {
    best_ = minima.best.end;
    estimate_.runner_up = minima.runner_up;
    estimate_.runner_up_ratio = minima.runner_up_ratio;
  }

  void take_end(const CameraEnd& end) {
    best_ = end.solution;
    found_centre_ = end.priors.principal_px > 0.0;
    estimate_.iterations += end.iterations;
    estimate_.focal_scale = end.focal_scale;
    estimate_.k1_change = end.k1_change;
    estimate_.cx_change_px = end.cx_change_px;
    estimate_.cy_change_px = end.cy_change_px;
    estimate_.radial_trend = end.radial_trend;
    estimate_.converged = best_.converged;
    estimate_.found = true;
    const CameraMatrix covariance = best_.information.inverse();
    estimate_.pose = {best_.state.T_base_camera, covariance.topLeftCorner<6, 6>()};
    if (options_.refine_intrinsics) estimate_.intrinsics = changed(camera_.intrinsics, best_.state);
  }

  void set_fit(const EdgeFitQuality& quality) {
    estimate_.edge_points = quality.edge_points;
    estimate_.segments = quality.segments;
    estimate_.views_with_edges = quality.views;
    estimate_.residual_px = quality.residual_px;
  }

  const CameraScene& scene_;
  const CameraTask& camera_;
  const CameraCalibrationOptions& options_;
  const RunContext& context_;
  std::vector<SolveLevel> levels_;
  EdgePriors priors_;  // with the intrinsics as the rig file has them
  std::vector<EdgeView> views_;
  EdgeSolution best_;
  bool found_centre_ = false;  // the principal point was estimated there
  CameraEstimate estimate_;
};

}  // namespace

Expected<CameraEstimate> calibrate_camera(const CameraScene& scene, const CameraTask& camera,
                                          const CameraCalibrationOptions& options, const RunContext& context) {
  return CameraCalibration(scene, camera, options, context).run();
}

}  // namespace rigcal
