#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/records/records.h"
#include "simdata/lidar/lidar_noise.h"
#include "simdata/scene/ray_caster.h"

namespace rigcal::sim {

/// One return of a shot; none where `range` is 0.
struct Echo {
  double range = 0.0;
  std::uint8_t reflectivity = 0;
  std::uint8_t tag = 0;  ///< Livox tag byte (return number; bits 0-1: likely a bleeding point).
};

/// What one shot measured. Surfaces in one footprint that are too far apart to share its pulse, and panes before them,
/// give echoes of their own.
struct Shot {
  Vector3d direction = Vector3d::Zero();  ///< As reported, sensor frame.
  std::array<Echo, 3> echoes{};           ///< The nearest first: return numbers 1, 2, 3, as on the wire.
  int count = 0;
  int strongest = 0;  ///< The echo of the beam's centre.

  /// What a sensor says that gives one echo of a shot: the nearest or the strongest, with return number 1. There must
  /// be one.
  [[nodiscard]] Echo single(bool nearest) const;
};

/// Measures a scene: ray, footprint, what surfaces do to it, losses and noise of one shot.
class ShotMeter {
 public:
  /// `extra_looks`: at how many further parts of the footprint the shots that look again do so (1 for up to two
  /// echoes, 2 for three). The references must outlive the meter.
  ShotMeter(const RayCaster& caster, const std::vector<Material>& materials, const LidarNoise& noise,
            int extra_looks = 1)
      : caster_(caster), materials_(materials), noise_(noise), extra_looks_(extra_looks) {}

  /// `direction` is the true unit direction in the sensor frame, T_scene_sensor the pose at the moment of the shot.
  [[nodiscard]] Shot measure(const SE3& T_scene_sensor, const Vector3d& direction, const RayCaster::People& people,
                             Random& random) const;

 private:
  /// Where a ray ends that may have gone through panes and over mirrors.
  struct Surface {
    double range = 0.0;  ///< Of the whole way.
    double cos_incidence = 1.0;
    double reflectivity = 0.0;
    double pattern = 1.0;     ///< What the texture makes of it, see surface_texture.h.
    double strength = 1.0;    ///< Left by what it met on the way, see Meeting.
    double pane_range = 0.0;  ///< Of a pane on the way that gives an echo too; 0: none.
  };
  /// Echoes as they are found, the beam's centre first.
  struct Found {
    std::array<Echo, 3> echoes{};
    int count = 0;
  };

  [[nodiscard]] std::optional<Surface> look(const Vector3d& origin, const Vector3d& ray,
                                            const RayCaster::People& people, Random& random) const;
  [[nodiscard]] std::optional<Surface> follow(const Vector3d& origin, const Vector3d& ray, Hit hit,
                                              const RayCaster::People& people, Random& random) const;
  /// What the texture of a hit does to its reflectivity; `way` from the sensor.
  [[nodiscard]] double pattern_at(const Material& material, const Hit& hit, const Vector3d& from, const Vector3d& ray,
                                  double way, const RayCaster::People& people) const;
  [[nodiscard]] bool is_lost(const Surface& surface, Random& random) const;
  /// Another part of the footprint: moves the nearest-by of the echoes found and marks it, or adds one.
  void look_again(const SE3& T_scene_sensor, const Vector3d& direction, const RayCaster::People& people, Random& random,
                  double& center_range, Found& found) const;
  void add_pane(double range, Random& random, Found& found) const;
  /// Range with its bias and noise and reflectivity with its own.
  void finish(Echo& echo, const Surface& surface, Random& random) const;

  const RayCaster& caster_;
  const std::vector<Material>& materials_;
  LidarNoise noise_;
  int extra_looks_;
};

/// The point of an echo as the wire carries it: whole millimetres.
[[nodiscard]] Point to_point(const Vector3d& direction, const Echo& echo);

}  // namespace rigcal::sim
