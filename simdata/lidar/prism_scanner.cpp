#include "simdata/lidar/prism_scanner.h"

#include <cmath>

namespace rigcal::sim {
namespace {

// Refractive index of the wedges in the published fits.
constexpr double glass = 1.51;

std::vector<double> avia_beams() {
  return {to_rad(-2.99), to_rad(-1.86), to_rad(-0.62), to_rad(0.62), to_rad(1.86), to_rad(3.04)};
}

}  // namespace

// The published speeds are -131.5463, 40.8032 and 213.1611 Hz: the third is twice the second less the first but for
// 0.008 Hz. Only where its phase follows that rule too do all prisms ever lean the same way, which gives the published
// field of view; otherwise it is up to 5 degrees smaller. So the third is geared to the others here: with the fitted
// speed the field would breathe with a period of two minutes.
PrismScanner PrismScanner::avia(Random& phases) {
  const Prism first{to_rad(30.8856), -131.5463, phases.uniform()};
  const Prism second{to_rad(29.7735), 40.8032, phases.uniform()};
  const Prism third{to_rad(3.1351), 2.0 * second.turns_per_s - first.turns_per_s,
                    2.0 * second.phase_turns - first.phase_turns};
  return {{first, second, third}, avia_beams(), 240000.0};
}

PrismScanner PrismScanner::mid40(Random& phases) {
  return {
      {{to_rad(18.7481), -121.5657, phases.uniform()}, {to_rad(17.9634), 77.7430, phases.uniform()}}, {0.0}, 100000.0};
}

PrismScanner PrismScanner::mid70(Random& phases) {
  return {
      {{to_rad(32.65), -121.5657, phases.uniform()}, {to_rad(31.2834), 77.7430, phases.uniform()}}, {0.0}, 100000.0};
}

PrismScanner PrismScanner::tele15(Random& phases) {
  return {{{to_rad(7.235), -121.5657, phases.uniform()}, {to_rad(6.9322), 77.7430, phases.uniform()}},
          {to_rad(0.80), to_rad(0.48), to_rad(0.16), to_rad(-0.16), to_rad(-0.48), to_rad(-0.80)},
          240000.0};
}

// Two equal wedges that turn against each other draw a line, and it lies level where their phases are opposite too; a
// third one makes a band of it.
PrismScanner PrismScanner::horizon(Random& phases) {
  const Prism first{to_rad(28.2), -121.5657, phases.uniform()};
  const Prism second{to_rad(28.2), -first.turns_per_s, -first.phase_turns};
  return {{first, second, {to_rad(16.3), 77.7430, phases.uniform()}}, avia_beams(), 240000.0};
}

std::optional<PrismScanner> PrismScanner::of(LidarModel model, Random& phases) {
  switch (model) {
    case LidarModel::livox_avia:
      return avia(phases);
    case LidarModel::livox_mid40:
      return mid40(phases);
    case LidarModel::livox_mid70:
      return mid70(phases);
    case LidarModel::livox_horizon:
      return horizon(phases);
    case LidarModel::livox_tele15:
      return tele15(phases);
    case LidarModel::other:
      break;
  }
  return std::nullopt;
}

PrismScanner::PrismScanner(std::vector<Prism> prisms, std::vector<double> beams_rad, double shots_per_s)
    : shots_per_s_(shots_per_s) {
  for (const Prism& prism : prisms) {
    const double step = 2.0 * pi * prism.turns_per_s / shots_per_s;
    elements_.push_back(
        {prism, {std::cos(prism.wedge_rad), std::sin(prism.wedge_rad), 0.0}, {std::cos(step), std::sin(step)}});
  }
  for (const double beam : beams_rad) beams_.emplace_back(std::cos(beam), 0.0, std::sin(beam));
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
