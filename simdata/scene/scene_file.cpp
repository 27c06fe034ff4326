#include "simdata/scene/scene_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "core/base/text.h"
#include "core/rig/text_file.h"
#include "core/rig/yaml_tree.h"
#include "simdata/scene/builtin_scenes.h"
#include "simdata/scene/scene_looks.h"
#include "simdata/scene/scene_shapes.h"

namespace rigcal::sim {
namespace {

constexpr double far = 1e4;  // metres; nothing of a scene is further away
constexpr std::size_t max_scene_bytes = std::size_t{1} << 20;
constexpr std::size_t max_primitives = 500'000;
constexpr std::int64_t max_count = 50'000;

std::optional<Vector3d> vector3(const YamlMap& map, std::string_view key) {
  const auto numbers = map.numbers(key, 3, 3, -far, far);
  if (!numbers) return std::nullopt;
  return Vector3d((*numbers)[0], (*numbers)[1], (*numbers)[2]);
}

Vector3d required3(const YamlMap& map, std::string_view key, const Vector3d& otherwise = Vector3d::Zero()) {
  return map.require(key) ? vector3(map, key).value_or(otherwise) : otherwise;
}

double required_number(const YamlMap& map, std::string_view key, double low, double high) {
  return map.require(key) ? map.number(key, low, high).value_or(low) : low;
}

int count_of(const YamlMap& map, std::string_view key) {
  return map.require(key) ? static_cast<int>(map.integer(key, 1, max_count).value_or(1)) : 1;
}

std::array<double, 2> size_range(const YamlMap& map, std::string_view key) {
  const auto numbers = map.require(key) ? map.numbers(key, 2, 2, 1e-4, far) : std::nullopt;
  if (!numbers) return {0.01, 0.01};
  if ((*numbers)[0] > (*numbers)[1])
    map.fail(key, "the smallest size is above the largest", "write [smallest, largest]");
  return {(*numbers)[0], (*numbers)[1]};
}

// Roll, pitch, yaw in degrees: R = Rz Ry Rx.
Matrix3d rotation_of(const YamlMap& map) {
  const auto rpy = map.numbers("rpy_deg", 3, 3, -360.0, 360.0);
  if (!rpy) return Matrix3d::Identity();
  return exp_so3(to_rad((*rpy)[2]) * Vector3d::UnitZ()) * exp_so3(to_rad((*rpy)[1]) * Vector3d::UnitY()) *
         exp_so3(to_rad((*rpy)[0]) * Vector3d::UnitX());
}

// Reads one scene; the first error stays in `errors`.
class SceneReader {
 public:
  SceneReader(Scene& scene, YamlErrors& errors) : scene_(scene), errors_(errors) {}

  void read(const YamlNode& root) {
    const YamlMap top(root, "the scene", errors_,
                      {"rigcal", "name", "materials", "light", "turntable", "ground", "objects", "people"});
    if (!errors_.ok()) return;
    check_format_version(top);
    scene_.name = top.text("name").value_or("");
    scene_.materials = read_materials(top);
    if (!errors_.ok()) return;
    scene_.light = read_light(top);
    if (top.require("turntable")) {
      if (const auto table = top.map("turntable", {"position", "yaw_deg"})) {
        scene_.T_scene_table.t = required3(*table, "position");
        scene_.T_scene_table.R =
            exp_so3(to_rad(table->number("yaw_deg", -360.0, 360.0).value_or(0.0)) * Vector3d::UnitZ());
      }
    }
    if (const auto ground = top.map("ground", {"height", "material"})) {
      scene_.has_ground = true;
      scene_.ground_height = required_number(*ground, "height", -far, far);
      scene_.ground_material = material(*ground);
    }
    each(top, "objects", [this](const YamlNode& node, const std::string& name) { read_object(node, name); });
    each(top, "people", [this](const YamlNode& node, const std::string& name) { read_person(node, name); });
  }

 private:
  template <class Body>
  void each(const YamlMap& top, std::string_view key, const Body& body) {
    const YamlNode* list = top.get(key);
    if (list == nullptr) return;
    if (list->kind != YamlNode::Kind::sequence) {
      top.fail(key, std::string(key) + " is no list", "begin each entry with a dash");
      return;
    }
    for (std::size_t i = 0; i < list->items.size() && errors_.ok(); ++i)
      body(list->items[i], std::string(key) + " entry " + std::to_string(i + 1));
  }

  int material(const YamlMap& map) {
    if (!map.require("material")) return 0;
    const auto name = map.text("material");
    if (!name) return 0;
    std::vector<std::string> known;
    for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
      if (scene_.materials[i].name == *name) return static_cast<int>(i);
      known.push_back(scene_.materials[i].name);
    }
    const std::string nearest = nearest_word(*name, known);
    map.fail("material", "there is no material '" + *name + "'",
             nearest.empty() ? "add it to materials" : "did you mean '" + nearest + "'?");
    return 0;
  }

  void read_object(const YamlNode& node, const std::string& name) {
    const std::size_t flats = scene_.flats.size();
    const std::size_t cylinders = scene_.cylinders.size();
    const YamlMap any(node, name, errors_, {});
    if (!errors_.ok() || !any.require("shape")) return;
    const auto shape =
        any.choice("shape", {"box", "rectangle", "panel", "cylinder", "facade", "stairs", "foliage", "rocks"});
    if (!shape) return;
    using Read = void (SceneReader::*)(const YamlNode&, const std::string&);
    static constexpr std::array<Read, 8> readers = {&SceneReader::read_box,     &SceneReader::read_rectangle,
                                                    &SceneReader::read_panel,   &SceneReader::read_cylinder,
                                                    &SceneReader::read_facade,  &SceneReader::read_stairs,
                                                    &SceneReader::read_foliage, &SceneReader::read_rocks};
    (this->*readers[*shape])(node, name);
    if (!errors_.ok()) return;
    if (const auto copies = any.map("copies", {"count", "step"})) copy(*copies, flats, cylinders);
    if (scene_.flats.size() + scene_.cylinders.size() > max_primitives)
      any.fail("shape", "the scene has more than " + std::to_string(max_primitives) + " surfaces", "make it smaller");
  }

  // Sets the object down `count` times in all, each a step further.
  void copy(const YamlMap& copies, std::size_t first_flat, std::size_t first_cylinder) {
    const int count = count_of(copies, "count");
    const Vector3d step = required3(copies, "step");
    const std::size_t flats_end = scene_.flats.size();
    const std::size_t cylinders_end = scene_.cylinders.size();
    if (static_cast<std::size_t>(count) * (flats_end - first_flat + cylinders_end - first_cylinder) > max_primitives) {
      copies.fail("count", "too many copies", "a scene holds " + std::to_string(max_primitives) + " surfaces");
      return;
    }
    for (int i = 1; i < count; ++i) {
      for (std::size_t k = first_flat; k < flats_end; ++k) {
        Flat flat = scene_.flats[k];
        flat.center += i * step;
        scene_.flats.push_back(flat);
      }
      for (std::size_t k = first_cylinder; k < cylinders_end; ++k) {
        Cylinder cylinder = scene_.cylinders[k];
        cylinder.base += i * step;
        scene_.cylinders.push_back(cylinder);
      }
    }
  }

  void read_box(const YamlNode& node, const std::string& name) {
    const YamlMap map(node, name, errors_, {"shape", "copies", "center", "size", "rpy_deg", "material"});
    const Vector3d center = required3(map, "center");
    const Vector3d size = required3(map, "size", Vector3d::Ones());
    if (size.minCoeff() <= 0.0) map.fail("size", "a box has no size of zero or less", "use a panel for a flat thing");
    add_box(scene_, {rotation_of(map), center}, size, material(map));
  }

  void read_rectangle(const YamlNode& node, const std::string& name) {
    const YamlMap map(node, name, errors_, {"shape", "copies", "center", "size", "rpy_deg", "material"});
    const Vector3d center = required3(map, "center");
    const auto size = map.require("size") ? map.numbers("size", 2, 2, 1e-3, far) : std::nullopt;
    if (size) add_rectangle(scene_, {rotation_of(map), center}, (*size)[0], (*size)[1], material(map));
  }

  // A parallelogram: one corner and the two edges that leave it.
  void read_panel(const YamlNode& node, const std::string& name) {
    const YamlMap map(node, name, errors_, {"shape", "copies", "corner", "edge_a", "edge_b", "material"});
    const Vector3d corner = required3(map, "corner");
    const Vector3d a = required3(map, "edge_a", Vector3d::UnitX());
    const Vector3d b = required3(map, "edge_b", Vector3d::UnitY());
    if (a.cross(b).norm() < 1e-6) map.fail("edge_b", "the edges of the panel are parallel");
    scene_.flats.push_back({corner + 0.5 * (a + b), 0.5 * a, 0.5 * b, false, material(map)});
  }

  void read_cylinder(const YamlNode& node, const std::string& name) {
    const YamlMap map(node, name, errors_, {"shape", "copies", "base", "axis", "length", "radius", "material"});
    Cylinder cylinder;
    cylinder.base = required3(map, "base");
    cylinder.axis = vector3(map, "axis").value_or(Vector3d::UnitZ());
    if (cylinder.axis.norm() < 1e-6) map.fail("axis", "the axis has no length");
    cylinder.axis.normalize();
    cylinder.length = required_number(map, "length", 1e-3, far);
    cylinder.radius = required_number(map, "radius", 1e-3, far);
    cylinder.material = material(map);
    add_cylinder(scene_, cylinder);
  }

  void read_facade(const YamlNode& node, const std::string& name) {
    const YamlMap map(node, name, errors_, {"shape", "copies", "from", "to", "height", "windows", "material"});
    const Vector3d from = required3(map, "from");
    const Vector3d to = required3(map, "to", Vector3d::UnitX());
    if ((to - from).head<2>().norm() < 0.01 || to.z() != from.z())
      map.fail("to", "a facade goes along level ground", "give from and to the same z and different places");
    const double height = required_number(map, "height", 0.01, far);
    Windows windows;
    if (const auto w =
            map.map("windows", {"count", "rows", "width", "height", "sill", "row_pitch", "recess", "material"})) {
      windows.count = count_of(*w, "count");
      windows.rows = static_cast<int>(w->integer("rows", 1, 1000).value_or(windows.rows));
      windows.width = w->number("width", 0.01, far).value_or(windows.width);
      windows.height = w->number("height", 0.01, far).value_or(windows.height);
      windows.sill = w->number("sill", 0.0, far).value_or(windows.sill);
      windows.row_pitch = w->number("row_pitch", 0.01, far).value_or(windows.row_pitch);
      windows.recess = w->number("recess", 0.01, 10.0).value_or(windows.recess);
      windows.material = material(*w);
      if (windows.count * windows.width > (to - from).norm())
        w->fail("count", "the windows are wider than the wall", "make them fewer or narrower");
    }
    if (errors_.ok()) add_facade(scene_, from, to, height, windows, material(map));
  }

  void read_stairs(const YamlNode& node, const std::string& name) {
    const YamlMap map(node, name, errors_,
                      {"shape", "copies", "foot", "rpy_deg", "steps", "rise", "tread", "width", "material"});
    const SE3 T{rotation_of(map), required3(map, "foot")};
    const int steps = count_of(map, "steps");
    const double rise = required_number(map, "rise", 0.01, 10.0);
    const double tread = required_number(map, "tread", 0.01, 10.0);
    add_stairs(scene_, T, steps, rise, tread, required_number(map, "width", 0.01, far), material(map));
  }

  void read_foliage(const YamlNode& node, const std::string& name) {
    const YamlMap map(node, name, errors_,
                      {"shape", "copies", "center", "radii", "leaves", "leaf_size", "seed", "material"});
    const Vector3d center = required3(map, "center");
    const Vector3d radii = required3(map, "radii", Vector3d::Ones());
    if (radii.minCoeff() <= 0.0) map.fail("radii", "a radius is zero or less");
    const int leaves = count_of(map, "leaves");
    add_foliage(scene_, center, radii, leaves, size_range(map, "leaf_size"), seed(map), material(map));
  }

  void read_rocks(const YamlNode& node, const std::string& name) {
    const YamlMap map(node, name, errors_, {"shape", "copies", "area", "height", "count", "size", "seed", "material"});
    const auto area = map.require("area") ? map.numbers("area", 4, 4, -far, far) : std::nullopt;
    if (!area) return;
    const int count = count_of(map, "count");
    add_rocks(scene_, {(*area)[0], (*area)[1], (*area)[2], (*area)[3]}, map.number("height", -far, far).value_or(0.0),
              count, size_range(map, "size"), seed(map), material(map));
  }

  static std::uint64_t seed(const YamlMap& map) {
    return static_cast<std::uint64_t>(map.integer("seed", 0, 1'000'000'000).value_or(1));
  }

  void read_person(const YamlNode& node, const std::string& name) {
    const YamlMap map(node, name, errors_, {"path", "floor", "speed_m_s", "start_m", "height", "material"});
    const auto path = map.require("path") ? map.numbers("path", 4, 1000, -far, far) : std::nullopt;
    if (!path) return;
    Person person;
    const double floor = map.number("floor", -far, far).value_or(0.0);
    for (std::size_t i = 0; i + 1 < path->size(); i += 2) {
      const Vector3d place((*path)[i], (*path)[i + 1], floor);
      if (!person.path.empty() && (place - person.path.back()).norm() < 0.1)
        map.fail("path", "two places of the path are the same", "leave one out");
      person.path.push_back(place);
    }
    if (path->size() % 2 != 0) map.fail("path", "the path has an odd count of numbers", "write x, y, x, y, ...");
    person.speed_m_s = map.number("speed_m_s", 0.0, 10.0).value_or(person.speed_m_s);
    person.start_m = map.number("start_m", 0.0, far).value_or(person.start_m);
    person.height = map.number("height", 0.5, 2.5).value_or(person.height);
    person.material = material(map);
    scene_.people.push_back(person);
  }

  Scene& scene_;
  YamlErrors& errors_;
};

}  // namespace

std::vector<std::string> builtin_scenes() {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scene_texts()) names.emplace_back(scene.name);
  return names;
}

Expected<Scene> parse_scene(const std::string& text, const std::string& name) {
  const auto root = parse_yaml(text, name);
  if (!root) return root.error();
  Scene scene;
  YamlErrors errors(name);
  SceneReader(scene, errors).read(*root);
  if (!errors.ok()) return errors.first();
  return scene;
}

Expected<Scene> load_scene(const std::string& name_or_path) {
  for (const BuiltinScene& scene : builtin_scene_texts())
    if (scene.name == name_or_path)
      return parse_scene(std::string(scene.text), "config/scenes/" + name_or_path + ".yaml");
  const bool is_path = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".yaml");
  if (!is_path) {
    return input_error("there is no scene '" + name_or_path + "'", {},
                       "use one of " + joined(builtin_scenes(), ", ") + ", or the path of a file");
  }
  const auto text = read_text_file(name_or_path, max_scene_bytes);
  if (!text) return text.error();
  return parse_scene(*text, name_or_path);
}

}  // namespace rigcal::sim
