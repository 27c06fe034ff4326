#pragma once

#include <array>
#include <vector>

#include "simdata/scene/ray_caster.h"
#include "simdata/scene/scene.h"

/// How much light falls on surfaces, with the shadows that others cast on them.
namespace rigcal::sim {

using Color = Eigen::Array3f;  ///< Red, green, blue.

/// Where a scene's light comes from. The references must outlive it.
class SceneLight {
 public:
  SceneLight(const Light& light, const RayCaster& caster);

  /// The sun and the lamps: whatever can be shut out.
  [[nodiscard]] std::size_t source_count() const { return light_.lamps.size() + 1; }
  static constexpr std::size_t max_sources = 17;

  /// What stands between each source and points near to each other, gathered once for all of them.
  struct Occluders {
    struct Source {
      bool by_tree = false;  ///< Too many: ask the tree for each point.
      std::vector<RayCaster::Candidate> candidates;
    };
    std::array<Source, max_sources> sources;
  };
  void gather(const Eigen::AlignedBox3d& points, Occluders& occluders) const;

  /// Whether a source is seen from a point; where nothing was gathered, by single rays.
  [[nodiscard]] bool reaches(std::size_t source, const Vector3d& point, const Vector3d& normal,
                             const RayCaster::People& people, const Occluders* occluders = nullptr) const;
  /// Irradiance by a source that reaches a point with this normal; `thin`: leaves let some light through.
  [[nodiscard]] Color direct(std::size_t source, const Vector3d& point, const Vector3d& normal, bool thin) const;
  /// Irradiance from everywhere else.
  [[nodiscard]] Color ambient(const Vector3d& normal) const;
  /// What is seen where there is nothing: the sky with clouds, a haze below the horizon. Unit direction.
  [[nodiscard]] Color sky(const Vector3d& direction) const;

 private:
  [[nodiscard]] Vector3d way_to(std::size_t source, const Vector3d& point) const;

  const Light& light_;
  const RayCaster& caster_;
  Vector3d to_sun_;
};

}  // namespace rigcal::sim
