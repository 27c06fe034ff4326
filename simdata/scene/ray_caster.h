#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <vector>

#include "simdata/scene/scene.h"

namespace rigcal::sim {

/// Where a ray meets the scene first.
struct Hit {
  double range = 0.0;                   ///< Along the ray's unit direction, metres.
  Vector3d normal = Vector3d::UnitZ();  ///< Unit, towards the ray's origin.
  int material = 0;
  int surface = 0;  ///< Which one it is, for `place_on`.
};

/// Rays that lie close together: all that start in one box and go in a direction of another, as far as `reach` times
/// the direction.
struct RayBundle {
  Eigen::AlignedBox3d origins;
  Eigen::AlignedBox3d directions;
  double reach = std::numeric_limits<double>::infinity();
};

/// Where a point lies on its surface: metres along two directions from the surface's middle, whose edges are
/// `half` away. Of a cylinder: round it and along it; of the ground: x and y, without an edge.
struct SurfacePlace {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  Eigen::Vector2d half = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
};

/// Finds first hits. Flats and cylinders stand in a bounding volume tree (binned surface area heuristic, Wald 2007);
/// walking people are few and are placed anew by `people_at`. Safe to use from many threads.
class RayCaster {
 public:
  explicit RayCaster(const Scene& scene);

  /// The people at a time; hand it to `cast`. One call serves all rays of a packet (people walk 1 mm in it).
  using People = std::vector<Body>;
  [[nodiscard]] People people_at(double time_s) const;

  /// The first hit nearer than `max_range` along the unit `direction`.
  [[nodiscard]] std::optional<Hit> cast(const Vector3d& origin, const Vector3d& direction, const People& people,
                                        double max_range) const;
  /// The same by trying every primitive: the judge of the tree.
  [[nodiscard]] std::optional<Hit> cast_by_brute_force(const Vector3d& origin, const Vector3d& direction,
                                                       const People& people, double max_range) const;

  /// A surface that some ray of a bundle may meet, and how soon, in units of the directions.
  struct Candidate {
    std::uint32_t primitive = 0;
    float entry = 0.0F;
  };
  /// The candidates of a bundle, the nearest first; people and the ground are always asked besides. False where there
  /// are more than `most`: then single rays through the tree are quicker.
  bool gather(const RayBundle& bundle, std::size_t most, std::vector<Candidate>& candidates) const;
  /// As `cast`, for a ray of the bundle with directions of length 1 that the candidates were gathered for.
  [[nodiscard]] std::optional<Hit> cast_among(const std::vector<Candidate>& candidates, const Vector3d& origin,
                                              const Vector3d& direction, const People& people, double max_range) const;
  /// Whether anything that lets no light through stands on the way from `origin` to origin + direction, which need not
  /// be of length 1. The ground does not count: it casts no shadow on what stands on it.
  [[nodiscard]] bool is_blocked_among(const std::vector<Candidate>& candidates, const Vector3d& origin,
                                      const Vector3d& direction, const People& people) const;
  [[nodiscard]] bool is_blocked(const Vector3d& origin, const Vector3d& direction, const People& people) const;

  /// `point` is where the hit is.
  [[nodiscard]] SurfacePlace place_on(const Hit& hit, const Vector3d& point, const People& people) const;

 private:
  /// A Flat or Cylinder in the form that is quick to hit. Flat: axis is the normal, f1 and f2 the dual of (u, v).
  struct Primitive {
    enum class Kind : std::uint8_t { rectangle, ellipse, cylinder };
    Kind kind = Kind::rectangle;
    int material = 0;
    Vector3d center;
    Vector3d axis;
    Vector3d f1;
    Vector3d f2;
    double radius = 0.0;
    double length = 0.0;
  };
  /// Leaf where count > 0: primitives first .. first + count - 1; else children at first and first + 1.
  struct Node {
    Eigen::Array3f low;
    Eigen::Array3f high;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  struct BuildItem;
  /// Numbers of surfaces that are no primitives: the ground, and from people_surface on the limbs of people.
  static constexpr int ground_surface = -1;
  static constexpr int people_surface = 1 << 24;

  [[nodiscard]] static Primitive make_primitive(const Flat& flat);
  [[nodiscard]] static Primitive make_primitive(const Cylinder& cylinder);
  static bool intersect(const Primitive& primitive, const Vector3d& origin, const Vector3d& direction, double& range);
  [[nodiscard]] static Vector3d normal_at(const Primitive& primitive, const Vector3d& point);
  void build(std::vector<BuildItem>& items);
  void split(std::uint32_t node, std::vector<BuildItem>& items, std::size_t begin, std::size_t end, int depth);
  [[nodiscard]] int closest_in_tree(const Vector3d& origin, const Vector3d& direction, double& range) const;
  [[nodiscard]] std::optional<Hit> finish(const Vector3d& origin, const Vector3d& direction, const People& people,
                                          int primitive, double range, double max_range) const;

  [[nodiscard]] bool blocks(const Primitive& primitive, const Vector3d& origin, const Vector3d& direction) const;
  [[nodiscard]] static bool people_block(const Vector3d& origin, const Vector3d& direction, const People& people);

  std::vector<Primitive> primitives_;
  std::vector<Node> nodes_;
  std::vector<bool> see_through_;  ///< By material.
  std::vector<Person> people_;
  bool has_ground_ = false;
  double ground_height_ = 0.0;
  int ground_material_ = 0;
};

}  // namespace rigcal::sim
