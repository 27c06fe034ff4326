#pragma once

#include <vector>

#include "core/start/scored_pose.h"
#include "core/start/surfel_index.h"
#include "core/start/surfels.h"

namespace rigcal {

/// Surfels to be laid on an index by one unknown pose X: surfel k stands at place[group_k] * X * mean_k. For the
/// extrinsics of a LiDAR the places are the rig's poses at its stops; for a pose of the rig there is one, the identity.
struct MovingSurfels {
  std::vector<SE3> places;
  struct Item {
    int place = 0;
    Vector3d mean = Vector3d::Zero();
    Vector3d normal = Vector3d::UnitZ();
  };
  std::vector<Item> items;
};

/// `count` of the items, evenly over the list; all where there are no more.
[[nodiscard]] MovingSurfels thinned(const MovingSurfels& moving, std::size_t count);

/// All poses of the search around a guess: turned by up to 16 degrees about each axis, shifted by 0.4 m along each.
[[nodiscard]] std::vector<SE3> search_grid(const SE3& guess);

/// A pose X and how well it fits: the balanced share of the surfels that lie on a surface (`same_surface_m`).
struct RegistrationResult {
  SE3 X;
  double score = 0.0;
  double runner_up_score = 0.0;  ///< Best score of a distinctly other pose; 0: none.
  SE3 runner_up;
};

/// Share of the surfels that meet one of the index at pose X, with given tolerances; 0 where there are none.
[[nodiscard]] double match_score(const SurfelIndex& index, const MovingSurfels& moving, const SE3& X, double min_cosine,
                                 double max_plane_distance_m);

/// The same share in balanced weights (core/start/own_view.h): what faces each direction counts the same, or three
/// walls would outvote the floor that alone tells a height.
[[nodiscard]] double balanced_score(const SurfelIndex& index, const MovingSurfels& moving, const SE3& X,
                                    double min_cosine, double max_plane_distance_m);

/// Point-to-plane refinement from X with tolerances that shrink from `from_m` to `to_m`. `pull` holds the translation
/// near zero where surfaces leave it open: its square (m^2) counts as much as so many squared distances of surfels.
[[nodiscard]] SE3 refine_registration(const SurfelIndex& index, const MovingSurfels& moving, const SE3& X,
                                      double from_m, double to_m, double pull = 0.0);

/// Searches around a guess and refines the best. `coarse` has a reach of about a metre, `fine` of half a metre.
[[nodiscard]] RegistrationResult register_surfels(const SurfelIndex& coarse, const SurfelIndex& fine,
                                                  const MovingSurfels& moving, const SE3& guess);

/// Refines all of `starts`, each right to some decimetres and degrees: the best three distinct ones, the best first.
[[nodiscard]] std::vector<ScoredPose> refined_poses(const SurfelIndex& coarse, const SurfelIndex& fine,
                                                    const MovingSurfels& moving, const std::vector<SE3>& starts);

/// The first of these, and the next as its runner-up.
[[nodiscard]] RegistrationResult refine_candidates(const SurfelIndex& coarse, const SurfelIndex& fine,
                                                   const MovingSurfels& moving, const std::vector<SE3>& starts);

/// What was found near a guess, unless it fits clearly worse than what was found `far` from it; the other is at least
/// its runner-up.
[[nodiscard]] RegistrationResult nearer_to_guess(const RegistrationResult& near, const RegistrationResult& far);

}  // namespace rigcal
