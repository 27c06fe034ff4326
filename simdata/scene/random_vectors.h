#pragma once

#include "core/base/random.h"
#include "core/geometry/se3.h"

/// Random vectors. Every draw has a statement of its own here and in this room: the order in which arguments are
/// evaluated is the compiler's choice, and the same seed shall give the same run everywhere.
namespace rigcal::sim {

/// Three independent normal numbers.
[[nodiscard]] Vector3d random_normal3(Random& random);
/// A unit vector, all directions alike.
[[nodiscard]] Vector3d random_direction(Random& random);
/// A unit vector across z.
[[nodiscard]] Vector3d random_level_direction(Random& random);

}  // namespace rigcal::sim
