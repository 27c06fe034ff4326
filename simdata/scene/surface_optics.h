#pragma once

#include "core/base/random.h"
#include "simdata/scene/scene.h"

/// What becomes of a laser shot where it meets a surface.
namespace rigcal::sim {

/// Reflectance of a film of water (Schlick's approximation, index 1.33): 2 % head on, all of it at grazing incidence.
[[nodiscard]] double water_reflectance(double cos_incidence);

/// Share of the shots that a pane throws straight back: exp(-(a / 3 deg)^2) for an incidence of a.
[[nodiscard]] double pane_glint(double cos_incidence);

enum class Fate {
  scattered,  ///< Comes back from here.
  glint,      ///< Comes back from here, thrown straight back by a pane.
  passed,     ///< Goes on through.
  reflected,  ///< Goes on as from a mirror.
  gone,
};

struct Meeting {
  Fate fate = Fate::scattered;
  double strength = 1.0;       ///< What is left of the echo, to and fro.
  bool glint_besides = false;  ///< A pane that let the shot through gives an echo of its own too.
};

/// Draws what happens. Glass: through with probability `glass` (strength `glass`, for the way back), else a glint or
/// gone. Mirror: reflected with probability `mirror`, else scattered by what lies on it. Wet: reflected with
/// probability `wet` F (strength F for the way back), F the water's reflectance; else scattered by the wet, darker
/// surface below: strength (1 - wet F)^2 (1 - wet / 2).
[[nodiscard]] Meeting meet(const Material& material, double cos_incidence, Random& random);

}  // namespace rigcal::sim
