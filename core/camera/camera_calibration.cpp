#include "core/camera/camera_calibration.h"

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/camera/camera_checks.h"
#include "core/camera/edge_search.h"
#include "core/camera/joint_solve.h"

namespace rigcal {
namespace {

// Fewer segments in all images together would fit anything.
constexpr std::size_t least_segments = 12;

// Rotations of the guess move pixels so far beyond the image's border, at its sigma.
constexpr double start_margin_px = 80.0;

// Starts are compared by fewer samples.
constexpr double sparse_spacing_px = 8.0;

class CameraCalibration {
 public:
  CameraCalibration(const CameraScene& scene, const CameraTask& camera, const CameraCalibrationOptions& options,
                    const RunContext& context)
      : scene_(scene), camera_(camera), options_(options), context_(context), levels_(standard_levels()) {}

  Expected<CameraEstimate> run() {
    const auto start = std::chrono::steady_clock::now();
    estimate_.intrinsics = camera_.intrinsics;
    if (camera_.guess_T_base_camera) {
      find();
    } else {
      estimate_.why_not = "there is no guess of where it sits (initial_extrinsics in the rig file)";
    }
    if (context_.cancelled()) return Error{ErrorKind::cancelled, "stopped before the end, nothing was written", {}, {}};
    estimate_.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return std::move(estimate_);
  }

 private:
  void find() {
    set_priors();
    views_ = make_edge_views(scene_, camera_);
    estimate_.views = static_cast<int>(views_.size());
    if (views_.empty()) {
      estimate_.why_not = camera_.views.empty() ? "there is no image of it"
                                                : "none of its images shows an edge: they are black, blurred or of "
                                                  "another size than the rig file says, or their stops are not known";
      return;
    }
    choose_start();
    if (!estimate_.why_not.empty() || context_.cancelled()) return;
    solve();
    if (context_.cancelled()) return;
    check();
  }

  void set_priors() {
    priors_.T_base_camera = *camera_.guess_T_base_camera;
    priors_.rotation_rad = options_.guess_sigma_rad;
    priors_.translation_m = options_.guess_sigma_m;
    priors_.focal_scale = options_.focal_sigma;
    priors_.k1 = options_.k1_sigma;
    if (options_.refine_intrinsics) {
      priors_.focal_scale = std::max(priors_.focal_scale, 0.02);
      priors_.k1 = std::max(priors_.k1, 0.1);
    }
  }

  [[nodiscard]] std::size_t segments() const {
    std::size_t count = 0;
    for (const EdgeView& view : views_) count += view.segments.size();
    return count;
  }

  // Solves from every start that the search finds, with few samples; the best becomes the start of the end.
  void choose_start() {
    const CameraState guess{*camera_.guess_T_base_camera};
    find_visible(scene_, camera_.intrinsics, guess, {start_margin_px, sparse_spacing_px}, views_);
    if (segments() < least_segments) {
      estimate_.why_not =
          "its images show too few edges of the map: where walls, floors and corners meet, within view "
          "of the LiDARs too, there must be some in most images, and the guess within " +
          std::to_string(static_cast<int>(to_deg(options_.guess_sigma_rad))) + " degrees";
      return;
    }
    std::vector<SE3> starts =
        search_edges(scene_, camera_.intrinsics, guess.T_base_camera, priors_, views_, EdgeSearchOptions{});
    starts.push_back(guess.T_base_camera);
    std::vector<EdgeSolution> solutions;
    for (const SE3& start : starts) {
      const CameraState state{start};
      solutions.push_back(solve_edges(scene_, camera_.intrinsics, state, priors_, quick_levels(), views_, context_));
      estimate_.iterations += solutions.back().iterations;
    }
    std::stable_sort(solutions.begin(), solutions.end(),
                     [](const EdgeSolution& a, const EdgeSolution& b) { return a.score > b.score; });
    best_ = solutions.front();
    for (const EdgeSolution& other : solutions) {
      const Vector6d apart = (best_.state.T_base_camera.inverse() * other.state.T_base_camera).log();
      if (apart.head<3>().norm() < to_rad(0.2) && apart.tail<3>().norm() < 0.03) continue;
      estimate_.runner_up = other.state.T_base_camera;
      estimate_.runner_up_ratio = best_.score > 0.0 ? other.score / best_.score : 1.0;
      break;
    }
  }

  void solve() {
    find_visible(scene_, camera_.intrinsics, best_.state, VisibleOptions{}, views_);
    // The start is within the narrow gates already.
    const std::span<const SolveLevel> last = std::span(levels_).last(2);
    best_ = solve_edges(scene_, camera_.intrinsics, best_.state, priors_, last, views_, context_);
    const JointSolution joint =
        solve_jointly(scene_, camera_.intrinsics, best_.state, priors_, last.back().match, views_);
    estimate_.iterations += best_.iterations + joint.iterations;
    estimate_.converged = best_.converged && joint.converged;
    best_.state = joint.state;
    const CameraMatrix covariance = best_.information.inverse();
    estimate_.found = true;
    estimate_.pose = {joint.state.T_base_camera, covariance.topLeftCorner<6, 6>()};
    estimate_.focal_scale = {joint.state.focal_scale, std::sqrt(covariance(6, 6))};
    estimate_.k1_change = {joint.state.k1_change, std::sqrt(covariance(7, 7))};
    estimate_.radial_trend = corner_shift(covariance.bottomRightCorner<2, 2>());
    if (options_.refine_intrinsics) estimate_.intrinsics = changed(camera_.intrinsics, joint.state);
  }

  // What focal scale and k1 do to the pixels at the image's corner.
  [[nodiscard]] ScalarEstimate corner_shift(const Eigen::Matrix2d& covariance) const {
    const CameraIntrinsics& in = camera_.intrinsics;
    const CameraModel model(in);
    const Eigen::Vector2d corner(in.cx < 0.5 * in.width ? in.width - 1.0 : 0.0,
                                 in.cy < 0.5 * in.height ? in.height - 1.0 : 0.0);
    const auto ray = model.ray(corner);
    PixelDerivatives derivatives;
    if (!ray || !model.project(*ray, derivatives)) return {};
    const Eigen::Vector2d outwards = (corner - Eigen::Vector2d(in.cx, in.cy)).normalized();
    const Eigen::Vector2d by_focal =
        derivatives.by_intrinsics.col(0) * in.fx + derivatives.by_intrinsics.col(1) * in.fy;
    const Eigen::Vector2d row(outwards.dot(by_focal), outwards.dot(derivatives.by_intrinsics.col(4)));
    return {row.dot(Eigen::Vector2d(best_.state.focal_scale, best_.state.k1_change)),
            std::sqrt(row.dot(covariance * row))};
  }

  // The views whose stop is `remainder` of `modulus`, or the others.
  [[nodiscard]] std::vector<EdgeView> some_views(int modulus, int remainder, bool others) const {
    std::vector<EdgeView> some;
    for (const EdgeView& view : views_) {
      if ((view.stop % modulus == remainder) != others) some.push_back(view);
    }
    return some;
  }

  [[nodiscard]] EdgeSolution solve_again(const std::vector<EdgeView>& views) const {
    // From the end it is not far, and half of the stops need not be as exact as all.
    SolveLevel check = levels_.back();
    check.max_iterations = 12;
    return solve_edges(scene_, camera_.intrinsics, best_.state, priors_, std::span(&check, 1), views, context_);
  }

  void check() {
    const MatchOptions& match = levels_.back().match;
    const EdgeFitQuality quality = fit_quality(scene_, camera_.intrinsics, best_.state, match, views_);
    estimate_.edge_points = quality.edge_points;
    estimate_.segments = quality.segments;
    estimate_.views_with_edges = quality.views;
    estimate_.residual_px = quality.residual_px;
    const std::vector<EdgeView> held_out = some_views(4, 3, false);
    const std::vector<EdgeView> kept = some_views(4, 3, true);
    if (!held_out.empty() && !kept.empty()) {
      const CameraState state = solve_again(kept).state;
      const EdgeFitQuality unseen = fit_quality(scene_, camera_.intrinsics, state, match, held_out);
      estimate_.hold_out = unseen.normalised;
      estimate_.hold_out_px = unseen.residual_px;
      estimate_.hold_out_start_px = offset_from(scene_, camera_.intrinsics, best_.state,
                                                CameraState{*camera_.guess_T_base_camera}, match, held_out);
    }
    const std::vector<EdgeView> even = some_views(2, 0, false);
    const std::vector<EdgeView> odd = some_views(2, 0, true);
    if (!even.empty() && !odd.empty()) {
      const Vector6d apart =
          (solve_again(even).state.T_base_camera.inverse() * solve_again(odd).state.T_base_camera).log();
      estimate_.halves_rad = apart.head<3>().norm();
      estimate_.halves_m = apart.tail<3>().norm();
    }
  }

  const CameraScene& scene_;
  const CameraTask& camera_;
  const CameraCalibrationOptions& options_;
  const RunContext& context_;
  std::vector<SolveLevel> levels_;
  EdgePriors priors_;
  std::vector<EdgeView> views_;
  EdgeSolution best_;
  CameraEstimate estimate_;
};

}  // namespace

Expected<CameraEstimate> calibrate_camera(const CameraScene& scene, const CameraTask& camera,
                                          const CameraCalibrationOptions& options, const RunContext& context) {
  return CameraCalibration(scene, camera, options, context).run();
}

}  // namespace rigcal
