#pragma once

#include <cstdint>

#include "core/geometry/se3.h"

/// What procedural textures are made of. All of them are averages over a footprint (metres), so that patterns too fine
/// for a pixel or a beam fade into their mean instead of flickering.
namespace rigcal::sim {

/// A number in [0, 1) that goes with a cell of an integer grid; the same everywhere.
[[nodiscard]] double cell_number(std::int64_t a, std::int64_t b, std::int64_t c);

/// Smooth noise in [-1, 1] with bumps of about `size` metres: values at the corners of a grid, blended.
[[nodiscard]] double smooth_noise(const Vector3d& p, double size, double footprint);

/// Of the interval of length `footprint` about x, the share in which lines of `width` lie, centred at whole multiples
/// of `period`.
[[nodiscard]] double line_share(double x, double period, double width, double footprint);

/// How much of a difference between cells of `size` is left: 1 where the footprint is small, 0 where it is not.
[[nodiscard]] double contrast_left(double size, double footprint);

}  // namespace rigcal::sim
