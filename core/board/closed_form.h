#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/geometry/se3.h"

namespace rigcal {

/// One board as two sensors saw it: its plane n.p = d and the four geometric corners, in each sensor's frame. Corner k
/// of the one is corner k of the other, the normals point the same way.
struct BoardPair {
  struct Side {
    Vector3d normal = Vector3d::UnitZ();
    double distance = 0.0;
    std::array<Vector3d, 4> corners;
  };
  Side a;
  Side b;
};

/// The plane and the corners of a plate of which the pose is known.
[[nodiscard]] BoardPair::Side board_side(const SE3& T_sensor_board, const std::array<Vector3d, 4>& plate_corners);

/// The rotation that turns the normals of b onto those of a (Kabsch, by SVD). Nothing where all are parallel.
[[nodiscard]] std::optional<Matrix3d> rotation_by_normals(std::span<const BoardPair> pairs);
/// The translation that brings b's corners onto a's planes, least squares. Nothing where the normals leave a direction
/// free: fewer than three, or nearly in one plane.
[[nodiscard]] std::optional<Vector3d> translation_by_planes(std::span<const BoardPair> pairs, const Matrix3d& R_a_b);

/// The paper's three steps (ITSC 2022) in one call, and what each gave.
struct ClosedForm {
  SE3 T_a_b;                     ///< After the corners' refinement.
  std::optional<SE3> by_planes;  ///< Before it: rotation from normals, translation from planes.
};
/// With fewer than three boards that face different ways the planes cannot do it, and the corners alone give the
/// motion. Nothing without a board.
[[nodiscard]] std::optional<ClosedForm> closed_form(std::span<const BoardPair> pairs);

}  // namespace rigcal
