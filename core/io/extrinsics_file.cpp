#include "core/io/extrinsics_file.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/io/sensor_transforms.h"
#include "core/rig/rig.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

/// Sensors of a rig file have a type; those of a result or ground truth have not.
bool is_rig_file(const YamlNode& top) {
  if (top.find("initial_extrinsics") != nullptr) return true;
  const YamlNode* sensors = top.find("sensors");
  return sensors != nullptr && !sensors->items.empty() && sensors->items.front().find("type") != nullptr;
}

Expected<ExtrinsicsFile> from_rig(const std::string& text, const std::string& name) {
  const Expected<Rig> rig = parse_rig(text, name);
  if (!rig) return rig.error();
  ExtrinsicsFile file;
  file.is_rig = true;
  file.base = rig->base_sensor().name;
  for (const Sensor& sensor : rig->sensors) {
    if (!sensor.initial_T_base_sensor) continue;
    file.names.push_back(sensor.name);
    file.T_base_sensor[sensor.name] = *sensor.initial_T_base_sensor;
  }
  if (file.T_base_sensor.empty()) {
    return input_error("is a rig file without initial_extrinsics", name, "add them or give an extrinsics.yaml");
  }
  file.T_base_sensor[file.base] = SE3{};
  return file;
}

// Matrices and quaternions may be written with six digits; a contradiction is larger.
constexpr double most_rounding = 1e-5;
constexpr double largest = 1e300;

/// A square list of rows; nothing where the key is absent or (after adding an error) wrong.
template <int Size>
std::optional<Eigen::Matrix<double, Size, Size>> read_square(const YamlMap& entry, const char* key) {
  const YamlNode* rows = entry.get(key);
  if (rows == nullptr) return std::nullopt;
  if (rows->kind != YamlNode::Kind::sequence || rows->items.size() != Size) {
    entry.fail(key, std::string("is no list of ") + (Size == 6 ? "six" : "four") + " rows");
    return std::nullopt;
  }
  Eigen::Matrix<double, Size, Size> square;
  for (int i = 0; i < Size; ++i) {
    YamlNode row;  // a map of one key, so that a row is checked like any other list
    row.kind = YamlNode::Kind::map;
    row.keys = {{"row " + std::to_string(i + 1), rows->items[static_cast<std::size_t>(i)].line}};
    row.items = {rows->items[static_cast<std::size_t>(i)]};
    const YamlMap map(row, entry.name() + "." + key, entry.errors(), {});
    const std::optional<std::vector<double>> values = map.numbers(row.keys[0].name, Size, Size, -largest, largest);
    if (!values) return std::nullopt;
    for (int j = 0; j < Size; ++j) square(i, j) = (*values)[static_cast<std::size_t>(j)];
  }
  return square;
}

std::optional<Matrix6d> read_covariance(const YamlMap& entry) {
  const std::optional<Matrix6d> covariance = read_square<6>(entry, "covariance");
  if (!covariance) return std::nullopt;
  constexpr double most_below_zero = 1e-18;  // A nanometre or a nanoradian: what rounding makes of zero.
  if (covariance->diagonal().minCoeff() < -most_below_zero) {
    entry.fail("covariance", "has a variance below zero on its diagonal", "restore the file as calibrate wrote it");
  } else if ((*covariance - covariance->transpose()).cwiseAbs().maxCoeff() >
             most_rounding * covariance->cwiseAbs().maxCoeff()) {
    entry.fail("covariance", "is not symmetric", "restore the file as calibrate wrote it");
  }
  return covariance;
}

void fail_contradiction(const YamlMap& entry, const char* key) {
  entry.fail(key, "contradicts translation and rotation_xyzw", "keep the one that is right and remove the other");
}

/// What a file says twice must be the same, as nobody knows which of the two somebody changed.
void check_matrices(const YamlMap& entry, const SE3& T) {
  const double tolerance = most_rounding * std::max(1.0, T.t.norm());
  for (const char* key : {"matrix", "matrix_inverse"}) {
    const std::optional<Eigen::Matrix4d> matrix = read_square<4>(entry, key);
    if (!matrix) continue;
    const bool inverse = key == std::string_view("matrix_inverse");
    const Eigen::Matrix4d expected = (inverse ? T.inverse() : T).matrix();
    if ((*matrix - expected).cwiseAbs().maxCoeff() > tolerance) fail_contradiction(entry, key);
  }
  const std::optional<YamlMap> example = entry.map("example", {});
  if (!example) return;
  const auto from = example->numbers("p_sensor", 3, 3, -1e6, 1e6);
  const auto to = example->numbers("p_base", 3, 3, -1e7, 1e7);
  if (!from || !to) return;
  const Vector3d p(from->data());
  const Vector3d expected = T * p;
  if ((Vector3d(to->data()) - expected).norm() > most_rounding * std::max({1.0, p.norm(), expected.norm()}))
    fail_contradiction(entry, "example");
}

/// Other conventions turn every transform around or about.
void check_convention(const YamlMap& top) {
  const std::optional<std::string> text = top.text("convention");
  if (!text) return;
  std::string without_spaces = *text;
  std::erase(without_spaces, ' ');
  if (without_spaces != "p_base=Rp_sensor+t") {
    top.fail("convention", "is another than 'p_base = R p_sensor + t'", "convert the transforms, then correct it");
  }
}

/// A list of texts; other items are passed over, as nothing depends on them.
std::vector<std::string> read_reasons(const YamlMap& entry) {
  std::vector<std::string> reasons;
  const YamlNode* list = entry.get("reasons");
  if (list == nullptr || list->kind != YamlNode::Kind::sequence) return reasons;
  for (const YamlNode& item : list->items) {
    if (item.kind == YamlNode::Kind::scalar) reasons.push_back(item.text);
  }
  return reasons;
}

std::vector<ListedDirection> read_weak_directions(const YamlMap& entry) {
  std::vector<ListedDirection> directions;
  const YamlNode* list = entry.get("weak_directions");
  if (list == nullptr) return directions;
  if (list->kind != YamlNode::Kind::sequence) {
    entry.fail("weak_directions", "is not a list");
    return directions;
  }
  for (std::size_t i = 0; i < list->items.size() && entry.errors().ok(); ++i) {
    const YamlMap map(list->items[i], entry.name() + ".weak_directions[" + std::to_string(i) + "]", entry.errors(), {});
    ListedDirection direction;
    map.require("of");
    direction.is_turn = map.choice("of", {"place", "turn"}) == std::size_t{1};
    const char* bound = direction.is_turn ? "bound_deg" : "bound_m";
    for (const char* key : {"axis", bound}) map.require(key);
    const auto axis = map.numbers("axis", 3, 3, -1.0 - most_rounding, 1.0 + most_rounding);
    if (axis) direction.axis = Vector3d(axis->data());
    direction.bound = map.number(bound, 0.0, largest).value_or(0.0);
    if (direction.is_turn) direction.bound = to_rad(direction.bound);
    direction.is_open = map.flag("open").value_or(false);
    direction.is_frozen = map.flag("frozen").value_or(false);
    const YamlNode* missing = map.get("missing");
    if (missing != nullptr) direction.missing = missing->text;
    directions.push_back(std::move(direction));
  }
  return directions;
}

}  // namespace

ExtrinsicsFile read_sensor_transforms(const YamlMap& top) {
  ExtrinsicsFile file;
  top.require("base", "name the sensor whose frame the transforms map into");
  file.base = top.text("base").value_or("");
  check_convention(top);
  if (top.has("method")) file.method = top.text("method").value_or("");
  if (!top.require("sensors", "list the sensors and their transforms")) return file;
  const std::optional<YamlMap> list = top.map("sensors", {});
  if (!list) return file;
  const YamlNode& node = *top.get("sensors");
  const std::vector<std::string_view> words{"good", "weak", "failed"};
  for (std::size_t i = 0; i < node.items.size() && top.errors().ok(); ++i) {
    const YamlKey& key = node.keys[i];
    if (!is_plain_name(key.name))
      top.errors().add(key.line, "the name of sensor " + std::to_string(i + 1) + " is not usable");
    const YamlMap entry(node.items[i], "sensors." + key.name, top.errors(), {});
    file.names.push_back(key.name);
    if (entry.has("reasons")) file.reasons[key.name] = read_reasons(entry);
    if (entry.has("weak_directions")) file.weak_directions[key.name] = read_weak_directions(entry);
    const std::optional<std::size_t> status = entry.choice("status", words);
    if (status) file.status[key.name] = words[*status];
    const bool failed = status && file.status[key.name] == "failed";
    if (failed && !entry.has("translation") && !entry.has("rotation_xyzw")) continue;
    const std::optional<SE3> T = read_transform(entry);
    if (!T) return file;
    check_matrices(entry, *T);
    const bool is_identity = T->t.norm() <= 1e-9 && rotation_distance(T->R, Matrix3d::Identity()) <= 1e-9;
    if (key.name == file.base && !is_identity) {
      top.errors().add(key.line, "sensors." + key.name + " is not the identity, but it is the base");
    }
    if (failed) continue;
    file.T_base_sensor[key.name] = key.name == file.base ? SE3{} : *T;
    const std::optional<Matrix6d> covariance = read_covariance(entry);
    if (covariance) file.covariance[key.name] = *covariance;
    const std::optional<CameraIntrinsics> intrinsics = read_intrinsics(entry);
    if (intrinsics) file.intrinsics[key.name] = *intrinsics;
  }
  // The result of a base that saw nothing has none, and its reasons.
  const auto base_status = file.status.find(file.base);
  const bool all_failed = base_status != file.status.end() && base_status->second == "failed";
  if (file.T_base_sensor.empty() && !all_failed) top.fail("sensors", "has no transform", "give a result that has one");
  return file;
}

Expected<ExtrinsicsFile> parse_extrinsics(const std::string& text, const std::string& name) {
  const Expected<YamlNode> tree = parse_yaml(text, name, transforms_limits);
  if (!tree) return tree.error();
  if (is_rig_file(*tree)) return from_rig(text, name);
  YamlErrors errors(name);
  const YamlMap top(*tree, "", errors, {});
  check_format_version(top);
  if (!errors.ok()) return errors.first();
  ExtrinsicsFile file = read_sensor_transforms(top);
  if (!errors.ok()) return errors.first();
  file.has_stops = top.has("stops");
  return file;
}

Expected<std::string> extrinsics_path(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::is_directory(path, error)) return path;
  const fs::path file = fs::path(path) / "extrinsics.yaml";
  if (fs::exists(file, error)) return file.string();
  const bool has_truth = fs::exists(fs::path(path) / "ground_truth.yaml", error);
  return input_error(
      "is no result: it holds no extrinsics.yaml", path,
      has_truth ? "give what calibrate wrote, or the ground_truth.yaml in it" : "give what calibrate wrote");
}

Expected<ExtrinsicsFile> load_extrinsics(const std::string& path) {
  const Expected<std::string> file = extrinsics_path(path);
  if (!file) return file.error();
  const Expected<std::string> text = read_text_file(*file, transforms_limits.max_bytes);
  if (!text) return text.error();
  return parse_extrinsics(*text, *file);
}

Expected<void> change_base(ExtrinsicsFile& file, const std::string& base) {
  if (file.base == base) return {};
  const auto found = file.T_base_sensor.find(base);
  if (found == file.T_base_sensor.end()) {
    return input_error("its base is " + file.base + ", and it does not say where " + base + ", the rig's base, is", {},
                       "give extrinsics that have " + base);
  }
  const SE3 T_new_old = found->second.inverse();
  file.T_base_sensor[file.base] = SE3{};  // a rig file does not list its own
  for (auto& [name, T] : file.T_base_sensor) T = name == base ? SE3{} : T_new_old * T;
  file.base = base;
  return {};
}

}  // namespace rigcal
