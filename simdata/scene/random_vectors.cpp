#include "simdata/scene/random_vectors.h"

#include <cmath>

namespace rigcal::sim {

Vector3d random_normal3(Random& random) {
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return {x, y, z};
}

Vector3d random_direction(Random& random) { return random_normal3(random).normalized(); }

Vector3d random_level_direction(Random& random) {
  const double angle = random.uniform(0.0, 2.0 * pi);
  return {std::cos(angle), std::sin(angle), 0.0};
}

}  // namespace rigcal::sim
