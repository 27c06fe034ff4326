#include "core/io/ground_truth.h"

#include <limits>
#include <set>

#include "core/base/text.h"
#include "core/io/output_file.h"
#include "core/io/sensor_transforms.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

constexpr std::int64_t any_ns = std::numeric_limits<std::int64_t>::max();

template <class Values>
std::string list(const Values& values) {
  std::string text = "[";
  for (const double value : values) text.append(text.size() > 1 ? ", " : "").append(number_text(value));
  return text + "]";
}

std::string transform(const SE3& T) {
  return "{translation: " + list(T.t) + ", rotation_xyzw: " + list(xyzw_from_rotation(T.R)) + "}";
}

void read_stops(const YamlMap& top, GroundTruth& truth) {
  const YamlNode* node = top.get("stops");
  if (node == nullptr) return;
  if (node->kind != YamlNode::Kind::sequence) {
    top.fail("stops", "is not a list");
    return;
  }
  std::set<int> numbers;
  for (std::size_t i = 0; i < node->items.size() && top.errors().ok(); ++i) {
    const YamlMap entry(node->items[i], "stops[" + std::to_string(i) + "]", top.errors(), {});
    for (const char* key : {"stop", "start_ns", "end_ns", "T_G_base"}) entry.require(key);
    StopTruth stop;
    stop.stop.index = static_cast<int>(entry.integer("stop", 0, std::numeric_limits<int>::max()).value_or(0));
    if (!numbers.insert(stop.stop.index).second)
      entry.fail("stop", "is " + std::to_string(stop.stop.index) + ", as that of a stop before");
    stop.stop.start_ns = entry.integer("start_ns", -any_ns, any_ns).value_or(0);
    stop.stop.end_ns = entry.integer("end_ns", -any_ns, any_ns).value_or(0);
    if (stop.stop.end_ns < stop.stop.start_ns) entry.fail("end_ns", "lies before start_ns");
    const std::optional<YamlMap> pose = entry.map("T_G_base", {});
    const std::optional<SE3> T = pose ? read_transform(*pose) : std::nullopt;
    if (!T) return;
    stop.T_G_base = *T;
    truth.stops.push_back(stop);
  }
}

void read_axis(const YamlMap& top, GroundTruth& truth) {
  const std::optional<YamlMap> map = top.map("table_axis", {});
  if (!map) return;
  map->require("point");
  map->require("direction");
  const auto point = map->numbers("point", 3, 3, -1e6, 1e6);
  const auto direction = map->numbers("direction", 3, 3, -1e6, 1e6);
  if (!point || !direction) return;
  const Vector3d along((*direction)[0], (*direction)[1], (*direction)[2]);
  if (along.norm() < 1e-6) map->fail("direction", "has no direction");
  truth.table_axis = TableAxis{Vector3d((*point)[0], (*point)[1], (*point)[2]), along.normalized()};
}

std::map<std::string, std::map<std::string, double>> read_figures(const YamlMap& top, const char* key) {
  std::map<std::string, std::map<std::string, double>> figures;
  const std::optional<YamlMap> sensors = top.map(key, {});
  if (!sensors) return figures;
  for (const YamlKey& sensor : top.get(key)->keys) {
    const std::optional<YamlMap> values = sensors->map(sensor.name, {});
    if (!values) return figures;
    for (const YamlKey& name : sensors->get(sensor.name)->keys) {
      constexpr double any = std::numeric_limits<double>::max();
      figures[sensor.name][name.name] = values->number(name.name, -any, any).value_or(0.0);
    }
  }
  return figures;
}

void read_clocks(const YamlMap& top, GroundTruth& truth) {
  const std::optional<YamlMap> sensors = top.map("clocks", {});
  if (!sensors) return;
  for (const YamlKey& sensor : top.get("clocks")->keys) {
    const std::optional<YamlMap> values = sensors->map(sensor.name, {});
    if (!values) return;
    truth.clocks[sensor.name] = {values->integer("offset_ns", -any_ns, any_ns).value_or(0),
                                 values->number("drift_ppm", -1e6, 1e6).value_or(0.0)};
  }
}

std::string figures_text(const char* key, const std::map<std::string, std::map<std::string, double>>& figures) {
  std::string text;
  if (figures.empty()) return text;
  text.append(key).append(":\n");
  for (const auto& [sensor, values] : figures) {
    std::string line;
    for (const auto& [name, value] : values) {
      line.append(line.empty() ? "" : ", ").append(quoted_text(name)).append(": ").append(number_text(value));
    }
    text.append("  ").append(quoted_text(sensor)).append(": {").append(line).append("}\n");
  }
  return text;
}

std::string stops_text(const std::vector<StopTruth>& stops) {
  std::string text = "stops:\n";
  if (stops.empty()) text = "stops: []\n";
  for (const StopTruth& stop : stops) {
    text += "  - {stop: " + std::to_string(stop.stop.index) + ", start_ns: " + std::to_string(stop.stop.start_ns) +
            ", end_ns: " + std::to_string(stop.stop.end_ns) + ", T_G_base: " + transform(stop.T_G_base) + "}\n";
  }
  return text;
}

}  // namespace

Expected<GroundTruth> parse_ground_truth(const std::string& text, const std::string& name) {
  const Expected<YamlNode> tree = parse_yaml(text, name, transforms_limits);
  if (!tree) return tree.error();
  YamlErrors errors(name);
  const YamlMap top(*tree, "", errors, {});
  check_format_version(top);
  if (!errors.ok()) return errors.first();
  const ExtrinsicsFile transforms = read_sensor_transforms(top);
  GroundTruth truth;
  truth.base = transforms.base;
  if (!errors.ok()) return errors.first();
  for (const YamlKey& sensor : top.get("sensors")->keys) {
    const auto found = transforms.T_base_sensor.find(sensor.name);
    if (found != transforms.T_base_sensor.end()) truth.T_base_sensor.emplace_back(*found);
  }
  read_stops(top, truth);
  read_axis(top, truth);
  truth.noise = read_figures(top, "noise");
  truth.biases = read_figures(top, "biases");
  truth.packets = read_figures(top, "packets");
  read_clocks(top, truth);
  if (!errors.ok()) return errors.first();
  return truth;
}

Expected<GroundTruth> load_ground_truth(const std::string& path) {
  const Expected<std::string> text = read_text_file(path, transforms_limits.max_bytes);
  if (!text) return text.error();
  return parse_ground_truth(*text, path);
}

Expected<void> write_ground_truth(const std::string& path, const GroundTruth& truth) {
  std::string text =
      "rigcal: 1\nbase: " + quoted_text(truth.base) + "\nconvention: \"p_base = R p_sensor + t\"\nsensors:\n";
  for (const auto& [name, T] : truth.T_base_sensor) {
    text.append("  ").append(quoted_text(name)).append(": ").append(transform(T)).append("\n");
  }
  text += stops_text(truth.stops);
  if (truth.table_axis) {
    text += "table_axis: {point: " + list(truth.table_axis->point) +
            ", direction: " + list(truth.table_axis->direction) + "}\n";
  }
  text += figures_text("noise", truth.noise);
  text += figures_text("biases", truth.biases);
  text += figures_text("packets", truth.packets);
  if (!truth.clocks.empty()) text += "clocks:\n";
  for (const auto& [sensor, clock] : truth.clocks) {
    text.append("  ").append(quoted_text(sensor)).append(": {offset_ns: ").append(std::to_string(clock.offset_ns));
    text.append(", drift_ppm: ").append(number_text(clock.drift_ppm)).append("}\n");
  }
  return replace_file(path, text);
}

}  // namespace rigcal
