#include "simdata/lidar/prism_scanner.h"

#include <algorithm>
#include <cmath>

namespace rigcal::sim {
namespace {

// Refractive index of the wedges in the published fits.
constexpr double glass = 1.51;

// The prisms of a model as they stand this time.
std::vector<Prism> draw_prisms(const ScanPattern& pattern, Random& phases) {
  std::vector<Prism> prisms;
  for (const ScanPrism& part : pattern.prisms) {
    if (part.wedge_deg == 0.0) break;
    Prism prism{to_rad(part.wedge_deg), 0.0, 0.0};
    if (part.is_geared()) {
      for (std::size_t i = 0; i < std::min(prisms.size(), part.gear.size()); ++i) {
        prism.turns_per_s += part.gear[i] * prisms[i].turns_per_s;
        prism.phase_turns += part.gear[i] * prisms[i].phase_turns;
      }
    } else {
      prism.turns_per_s = part.turns_per_s;
      prism.phase_turns = phases.uniform();
    }
    prisms.push_back(prism);
  }
  return prisms;
}

}  // namespace

std::optional<PrismScanner> PrismScanner::of(LidarModel model, Random& phases) {
  const LidarFacts& facts = facts_of(model);
  if (facts.scan.beams_deg.empty()) return std::nullopt;
  return PrismScanner(draw_prisms(facts.scan, phases), facts.scan.beams_deg, facts.shots_per_s);
}

PrismScanner::PrismScanner(const std::vector<Prism>& prisms, std::span<const double> beams_deg, double shots_per_s)
    : shots_per_s_(shots_per_s) {
  for (const Prism& prism : prisms) {
    const double step = 2.0 * pi * prism.turns_per_s / shots_per_s;
    elements_.push_back(
        {prism, {std::cos(prism.wedge_rad), std::sin(prism.wedge_rad), 0.0}, {std::cos(step), std::sin(step)}});
  }
  for (const double beam_deg : beams_deg)
    beams_.emplace_back(std::cos(to_rad(beam_deg)), 0.0, std::sin(to_rad(beam_deg)));
}

PrismScanner::Angle PrismScanner::angle_at(const Element& element, std::int64_t shot) const {
  const double turns =
      element.prism.turns_per_s * (static_cast<double>(shot) / shots_per_s_) + element.prism.phase_turns;
  const double angle = 2.0 * pi * (turns - std::floor(turns));
  return {std::cos(angle), std::sin(angle)};
}

// Snell in vector form: the component along the surface changes by the ratio of the indices. Into the leaning surface,
// then out of the flat one, whose normal is x.
Vector3d PrismScanner::refract(const Element& element, const Angle& angle, const Vector3d& d) {
  const double lean = element.normal.y();
  const Vector3d n(element.normal.x(), lean * angle.c, lean * angle.s);
  constexpr double into = 1.0 / glass;
  const double c = n.dot(d);
  const Vector3d inside = into * d + (std::sqrt(1.0 - into * into * (1.0 - c * c)) - into * c) * n;
  const double y = glass * inside.y();
  const double z = glass * inside.z();
  return {std::sqrt(1.0 - y * y - z * z), y, z};
}

Vector3d PrismScanner::direction(std::int64_t shot) const {
  Vector3d d = beams_[static_cast<std::size_t>(shot % lines())];
  for (const Element& element : elements_) d = refract(element, angle_at(element, shot), d);
  return d;
}

void PrismScanner::directions(std::int64_t first, std::vector<Vector3d>& out) const {
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = beams_[static_cast<std::size_t>((first + static_cast<std::int64_t>(i)) % lines())];
  for (const Element& element : elements_) {
    Angle angle = angle_at(element, first);
    for (Vector3d& d : out) {
      d = refract(element, angle, d);
      angle = {angle.c * element.step.c - angle.s * element.step.s,
               angle.s * element.step.c + angle.c * element.step.s};
    }
  }
}

}  // namespace rigcal::sim
