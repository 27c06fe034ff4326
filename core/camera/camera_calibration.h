#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/run_context.h"
#include "core/camera/camera_scene.h"
#include "core/edges/image_edges.h"
#include "core/geometry/chi_square.h"
#include "core/rig/rig.h"

namespace rigcal {

/// One image of a camera, taken while the rig stood.
struct CameraView {
  int stop = 0;      ///< Index into CameraScene::T_G_base.
  std::string file;  ///< For messages.
  GreyImage grey;    ///< As it came: distorted, not resampled.
  /// Where they are known already; null: they are found.
  std::shared_ptr<const std::vector<ImageEdge>> edges = nullptr;
};

/// A camera to be found. `sensor` is its index in the rig.
struct CameraTask {
  int sensor = 0;
  std::string name;
  CameraIntrinsics intrinsics;
  std::optional<SE3> guess_T_base_camera;  ///< Nothing: it is found by its images alone (camera_start.h).
  std::vector<CameraView> views;
};

struct CameraCalibrationOptions {
  /// How far the guess may be off: the sigmas of the soft prior of the coarse stage.
  double guess_sigma_m = 0.12;
  double guess_sigma_rad = to_rad(6.0);
  bool refine_intrinsics = false;  ///< The estimated ones are the result, and need not agree with the rig file's.
  /// It is given up where the best place to begin from explains no more of its edges (`CameraEstimate::start_score`).
  double beaten_start_score = 0.0;
};

/// A pose and how sure it is; the covariance is that of xi = [rotation rad; translation m] in T exp(xi).
struct PoseEstimate {
  SE3 T_base_camera;
  Matrix6d covariance = Matrix6d::Zero();
};

/// Of poses that are the same, 0.1 % differ by more: with what does, an end is doubtful.
constexpr double differing_chi2 = chi2_999_6;

/// What edges leave the place of a principal point off by, beside its sigma, where the intrinsics are right (simulated
/// images): pixels of the images that are worked on.
constexpr double principal_chance_px = 0.2;

/// A departure from what the rig file says.
struct ScalarEstimate {
  double value = 0.0;
  double sigma = 0.0;
};

/// How well the images of one stop show the map's edges where a pose says. Offsets of partners do not tell: what shows
/// nothing there has few partners, and those are near by chance.
struct StopAgreement {
  int stop = 0;
  std::string file;        ///< Its first image.
  double segments = 0.0;   ///< That its images should show; all images of a stop together count once.
  double explained = 0.0;  ///< Of these, by image edges,
  double by_chance = 0.0;  ///< and on average from poses beside this one.
  /// What they would explain by more than chance if they showed of each line as much as the other stops do that see it,
  /// and of a line that no other stop sees as much as all do of all: lines that no image shows (bare walls in one grey)
  /// are expected of none.
  double expected = 0.0;

  /// About 0 where the images are of another place, or the camera is.
  [[nodiscard]] double more_than_chance() const { return explained - by_chance; }
};

/// Poses from the first and from the last stops with images, a third of all each, three at least.
struct FirstAndLast {
  double apart_m = 0.0;
  double apart_rad = 0.0;
  double chi2 = 0.0;  ///< Over what they may differ by, 6 degrees of freedom.
  /// How many times more of their own edges one of them explains than the result does, the larger; 0: fewer than six
  /// stops.
  double gain = 0.0;
};

/// All that the images tell of one camera; `core/quality` judges it.
struct CameraEstimate {
  bool found = false;  ///< A pose was found at all; if not, `why_not` says in words what stood in the way.
  std::string why_not;
  bool converged = false;
  PoseEstimate pose;            ///< The result: edges, and information where the edges are weak.
  CameraIntrinsics intrinsics;  ///< The rig file's, or with `refine_intrinsics` those found here.

  int views = 0;                ///< Images that took part,
  int views_with_edges = 0;     ///< and those with LiDAR edges in them that found a partner.
  std::size_t edge_points = 0;  ///< Samples of LiDAR edges that found a partner, and the segments they make.
  std::size_t segments = 0;
  double start_score = 0.0;  ///< Share of the segments that the best place to begin from explains, 0 .. 1.
  double residual_px = 0.0;  ///< Robust root mean square of the segments' offsets: a fit, no accuracy.

  /// Offsets in the held-out stops, with the pose from the others: over their expected sigma (1 is right), in pixels,
  /// and in pixels at the guess (0 without one). 0: nothing could be held out.
  double hold_out = 0.0;
  double hold_out_px = 0.0;
  double hold_out_start_px = 0.0;
  /// What the images of the held-out stops show of the map's edges by more than chance, over what is expected of them
  /// (1: as much), with the pose from the others; and what those of each stop do there, in the order of the stops. None
  /// where nothing could be held out.
  std::optional<double> hold_out_share;
  std::vector<StopAgreement> stops;
  FirstAndLast first_and_last;

  /// All five 0 where there are too few stops to tell (fewer than four).
  ScalarEstimate focal_scale;   ///< fx / (the rig file's fx) - 1, freely estimated.
  ScalarEstimate k1_change;     ///< k1 - (the rig file's k1), likewise.
  ScalarEstimate cx_change_px;  ///< cx - (the rig file's cx), likewise, and
  ScalarEstimate cy_change_px;  ///< cy.
  /// Of the residuals along the radius, pixels at the image's corner, intrinsics as given.
  ScalarEstimate radial_trend;

  /// How many times more of its edges a lens of the other distortion model explains; asked for only where the end is
  /// doubtful or the intrinsics seem to be others, else 0.
  double other_lens_gain = 0.0;

  /// The second opinion: the pose at which reflectivity and grey value tell most about each other.
  std::optional<PoseEstimate> information;
  double disagreement_chi2 = 0.0;  ///< Between the two, 6 degrees of freedom; 0 where there is no second opinion.

  /// Poses from either half of the stops: how far they lie apart, 0 of a single stop; and that over what the covariance
  /// lets halves differ by, 6 degrees of freedom, 0 where a half has fewer than six stops.
  double halves_m = 0.0;
  double halves_rad = 0.0;
  double halves_chi2 = 0.0;

  /// The best other minimum, and its score as a share of the winner's (1: as good); no pose: none was met.
  std::optional<SE3> runner_up;
  double runner_up_ratio = 0.0;

  double wall_s = 0.0;
  int iterations = 0;
};

/// Finds a camera against the map: the basin by normalised information distance, then LiDAR edges on
/// image edges, then the checks. Poses of the stops and the map stand, so cameras do not depend on each other.
/// Deterministic whatever the number of threads. A camera that cannot be found is no error but `found == false`.
/// Errors: cancelled.
[[nodiscard]] Expected<CameraEstimate> calibrate_camera(const CameraScene& scene, const CameraTask& camera,
                                                        const CameraCalibrationOptions& options,
                                                        const RunContext& context);

}  // namespace rigcal
