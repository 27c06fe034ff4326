#include "simdata/scene/surface_optics.h"

#include <algorithm>
#include <cmath>

namespace rigcal::sim {
namespace {

constexpr double glint_width_rad = 3.0 * pi / 180.0;
// Of a ground whose pores are full of water: it is about half as bright as when it is dry.
constexpr double soaked = 0.5;

}  // namespace

double water_reflectance(double cos_incidence) {
  constexpr double head_on = 0.0201;  // ((1.33 - 1) / (1.33 + 1))^2
  const double rest = 1.0 - cos_incidence;
  return head_on + (1.0 - head_on) * rest * rest * rest * rest * rest;
}

double pane_glint(double cos_incidence) {
  const double angle = std::acos(std::min(cos_incidence, 1.0)) / glint_width_rad;
  return std::exp(-angle * angle);
}

Meeting meet(const Material& material, double cos_incidence, Random& random) {
  if (material.glass > 0.0) {
    const bool glint = random.uniform() < pane_glint(cos_incidence);
    if (random.uniform() < material.glass) return {Fate::passed, material.glass, glint};
    return {glint ? Fate::glint : Fate::gone, 1.0, false};
  }
  if (material.mirror > 0.0 && random.uniform() < material.mirror) return {Fate::reflected, material.mirror, false};
  if (material.wet > 0.0) {
    const double mirrored = material.wet * water_reflectance(cos_incidence);
    if (random.uniform() < mirrored) return {Fate::reflected, mirrored / material.wet, false};
    return {Fate::scattered, (1.0 - mirrored) * (1.0 - mirrored) * (1.0 - soaked * material.wet), false};
  }
  return {};
}

}  // namespace rigcal::sim
