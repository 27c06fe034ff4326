#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/se3.h"
#include "core/records/lidar_models.h"

namespace rigcal::sim {

/// One rotating wedge: its first surface leans by `wedge_rad`, its second is flat across the forward axis.
struct Prism {
  double wedge_rad = 0.0;
  double turns_per_s = 0.0;  ///< Signed.
  double phase_turns = 0.0;  ///< Place at time 0.
};

/// Where the shots of a Livox sensor with rotating prisms go: Snell's law at every surface of every prism in order, as
/// in the fits to recorded data that the vendor's scan patterns follow. Sensor frame: x forward, y left, z up; the
/// plane of the AVIA's six beams is upright. Directions are a pure function of the prisms' phases and the time.
class PrismScanner {
 public:
  /// Of a model; nothing for one whose pattern is not known. `phases` draws where the prisms stand at time 0.
  [[nodiscard]] static std::optional<PrismScanner> of(LidarModel model, Random& phases);

  /// Unit direction of shot `shot` since time 0 (line = shot mod lines()).
  [[nodiscard]] Vector3d direction(std::int64_t shot) const;
  /// Unit directions of `out.size()` shots from `first` on; as `direction` to 1e-12, but quicker.
  void directions(std::int64_t first, std::vector<Vector3d>& out) const;

  [[nodiscard]] double shots_per_s() const { return shots_per_s_; }
  [[nodiscard]] double first_prism_turns_per_s() const { return elements_.front().prism.turns_per_s; }
  [[nodiscard]] int lines() const { return static_cast<int>(beams_.size()); }

 private:
  /// cos and sin of a prism's angle.
  struct Angle {
    double c = 1.0;
    double s = 0.0;
  };
  struct Element {
    Prism prism;
    Vector3d normal;  ///< Of the leaning surface at angle 0.
    Angle step;       ///< Turn from one shot to the next.
  };

  PrismScanner(const std::vector<Prism>& prisms, std::span<const double> beams_deg, double shots_per_s);
  [[nodiscard]] Angle angle_at(const Element& element, std::int64_t shot) const;
  [[nodiscard]] static Vector3d refract(const Element& element, const Angle& angle, const Vector3d& direction);

  std::vector<Element> elements_;
  std::vector<Vector3d> beams_;
  double shots_per_s_ = 0.0;
};

}  // namespace rigcal::sim
