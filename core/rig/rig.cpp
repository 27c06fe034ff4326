#include "core/rig/rig.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <utility>

#include "core/base/text.h"
#include "core/records/records.h"
#include "core/rig/marker_dictionaries.h"
#include "core/rig/rig_file.h"
#include "core/rig/sensor_reader.h"
#include "core/rig/yaml_tree.h"

namespace rigcal {
namespace {

/// Largest distance from the base that is believed.
constexpr double max_translation_m = 1000.0;
constexpr double plate_tolerance = 1.02;  // plates are cut and measured roughly
/// A quaternion typed with four digits is off by 1e-4; ten times that is a mistake.
constexpr double quaternion_tolerance = 1e-3;

void read_sensors(const YamlMap& top, Rig& rig) {
  if (!top.require("sensors", "list the sensors of the rig")) return;
  const std::optional<YamlMap> list = top.map("sensors", {});
  if (!list) return;
  const YamlNode& node = *top.get("sensors");
  if (node.items.empty()) top.fail("sensors", "is empty", "list the sensors of the rig");
  if (node.items.size() > 255) top.fail("sensors", "has more than 255 sensors");
  for (std::size_t i = 0; i < node.items.size() && top.errors().ok(); ++i) {
    const YamlKey& key = node.keys[i];
    if (!is_plain_name(key.name)) {
      top.errors().add(key.line, "the name of sensor " + std::to_string(i + 1) + " is not usable",
                       "use up to 64 letters, digits, '_', '-' and '.', no '.' in front");
      return;
    }
    rig.sensors.push_back(read_sensor(key.name, node.items[i], top.errors()));
  }
}

/// ROS takes them alike with and without.
std::string without_slash(const std::string& topic) { return topic.front() == '/' ? topic.substr(1) : topic; }

/// Two sensors with one address, broadcast code, folder, topic or device cannot be told apart. Points, images and
/// inertial readings need topics of their own, too: what comes on one is of one kind, and goes to one sensor.
void check_duplicates(const YamlMap& top, const Rig& rig) {
  const YamlNode& list = *top.get("sensors");
  std::set<std::string> seen;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const Sensor& sensor = rig.sensors[i];
    std::vector<std::pair<std::string, std::string>> own{
        {"folder", sensor.folder.empty() ? sensor.name : sensor.folder}};
    if (sensor.lidar && sensor.lidar->ip) own.emplace_back("ip", to_string(*sensor.lidar->ip));
    if (sensor.lidar && !sensor.lidar->broadcast_code.empty()) {
      own.emplace_back("broadcast_code", sensor.lidar->broadcast_code);
    }
    if (sensor.camera && !sensor.camera->device.empty()) own.emplace_back("device", sensor.camera->device);
    const std::string& topic = sensor.lidar ? sensor.lidar->topic : sensor.camera->topic;
    if (!topic.empty()) own.emplace_back("topic", topic);
    if (sensor.lidar && !sensor.lidar->imu_topic.empty()) own.emplace_back("imu_topic", sensor.lidar->imu_topic);
    for (const auto& [key, value] : own) {
      const bool is_topic = key.ends_with("topic");
      if (seen.insert(is_topic ? "topic " + without_slash(value) : key + " " + value).second) continue;
      const YamlMap map(list.items[i], "sensors." + sensor.name, top.errors(), {});
      map.fail(key, "is " + value + ", which another sensor has already", "every sensor needs its own");
    }
  }
}

/// The sensor that a key or value names, or -1 and an error at `line`.
int find_sensor(const Rig& rig, const std::string& name, const std::string& what, int line, YamlErrors& errors) {
  const int index = rig.find(name);
  if (index >= 0) return index;
  std::vector<std::string> names;
  for (const Sensor& sensor : rig.sensors) names.push_back(sensor.name);
  const std::string nearest = nearest_word(name, names);
  std::string mend = "the sensors are";
  for (const std::string& known : names) mend.append(" ").append(known);
  if (!nearest.empty()) mend = "did you mean '" + nearest + "'?";
  errors.add(line, what + " names a sensor that does not exist", mend);
  return -1;
}

bool has_lidar(const Rig& rig) {
  return std::any_of(rig.sensors.begin(), rig.sensors.end(), [](const Sensor& s) { return s.is_lidar(); });
}

void read_base(const YamlMap& top, Rig& rig) {
  if (!top.require("base", "name the sensor whose frame is the rig frame")) return;
  const std::optional<std::string> base = top.text("base");
  if (!base) return;
  rig.base = std::max(0, find_sensor(rig, *base, "base '" + *base + "'", top.line("base"), top.errors()));
  if (top.errors().ok() && has_lidar(rig) && !rig.base_sensor().is_lidar()) {
    top.fail("base", "'" + *base + "' is a camera", "a rig with LiDARs needs one of them as base");
  }
}

void read_initial_extrinsics(const YamlMap& top, Rig& rig) {
  const std::optional<YamlMap> list = top.map("initial_extrinsics", {});
  if (!list) return;
  const YamlNode& node = *top.get("initial_extrinsics");
  for (std::size_t i = 0; i < node.items.size() && top.errors().ok(); ++i) {
    const std::string name = "initial_extrinsics." + node.keys[i].name;
    const int index = find_sensor(rig, node.keys[i].name, name, node.keys[i].line, top.errors());
    if (index < 0) return;
    const YamlMap entry(node.items[i], name, top.errors(), {"translation", "rotation_xyzw"});
    const std::optional<SE3> T = read_transform(entry);
    if (!T) return;
    const bool is_identity = T->t.norm() <= 1e-9 && rotation_distance(T->R, Matrix3d::Identity()) <= 1e-9;
    if (index == rig.base && !is_identity) {
      top.errors().add(node.keys[i].line, name + " is not the identity, but it is the base",
                       "leave the base out or choose another base");
    }
    rig.sensors[static_cast<std::size_t>(index)].initial_T_base_sensor = index == rig.base ? SE3{} : *T;
  }
}

void read_turntable(const YamlMap& top, Rig& rig) {
  const std::optional<YamlMap> map =
      top.map("turntable", {"driver", "axis", "port", "baud", "protocol", "reverse", "letter", "speed_deg_s", "move",
                            "ask", "answer", "done", "fault"});
  if (!map) return;
  TurntableSettings turntable;
  if (const auto driver = map->choice("driver", {"manual", "serial"}))
    turntable.driver = *driver == 0 ? "manual" : "serial";
  if (const auto axis = map->numbers("axis", 3, 3, -1e6, 1e6)) {
    const Vector3d direction((*axis)[0], (*axis)[1], (*axis)[2]);
    if (direction.norm() < 1e-6) map->fail("axis", "has no direction", "for an upright axis write [0, 0, 1]");
    turntable.axis = direction.normalized();
  }
  turntable.port = map->text("port").value_or("");
  if (const auto baud = map->integer("baud", 50, 10'000'000)) turntable.baud = static_cast<int>(*baud);
  if (const auto protocol = map->choice("protocol", {"grbl", "ascii"}))
    turntable.protocol = *protocol == 0 ? "grbl" : "ascii";
  turntable.is_reversed = map->flag("reverse").value_or(false);
  if (const auto letter = map->choice("letter", {"X", "Y", "Z", "A", "B", "C"}))
    turntable.letter = std::string(1, "XYZABC"[*letter]);
  turntable.speed_deg_s = map->number("speed_deg_s", 0.01, 1000.0);
  turntable.move = map->text("move").value_or("");
  turntable.ask = map->text("ask").value_or("");
  turntable.answer = map->text("answer").value_or("");
  turntable.done = map->text("done").value_or("");
  turntable.fault = map->text("fault").value_or("");
  if (turntable.driver == "serial") map->require("port", "name the serial port, for example /dev/ttyUSB0");
  rig.turntable = turntable;
}

void read_trigger_lines(const YamlMap& top, Rig& rig) {
  const std::optional<YamlMap> map = top.map("trigger", {"gpiochip", "line", "pulse_us", "strobe_line", "pps"});
  if (!map) return;
  TriggerLineSettings trigger;
  trigger.gpiochip = map->text("gpiochip").value_or("");
  if (const auto line = map->integer("line", 0, 100'000)) trigger.line = static_cast<int>(*line);
  trigger.pulse_us = map->number("pulse_us", 1.0, 1e6).value_or(trigger.pulse_us);
  if (const auto line = map->integer("strobe_line", 0, 100'000)) trigger.strobe_line = static_cast<int>(*line);
  trigger.pps = map->text("pps").value_or("");
  if (trigger.line || trigger.strobe_line)
    map->require("gpiochip", "name the chip of the lines, for example gpiochip0");
  if (trigger.line && trigger.line == trigger.strobe_line) map->fail("strobe_line", "is the trigger's own line");
  rig.trigger = trigger;
}

void read_network(const YamlMap& top, Rig& rig) {
  const std::optional<YamlMap> map = top.map("lidar", {"interface", "host_ip", "send_utc"});
  if (!map) return;
  rig.network.interface = map->text("interface").value_or(rig.network.interface);
  rig.network.host_ip = map->text("host_ip").value_or(rig.network.host_ip);
  rig.network.send_utc = map->flag("send_utc").value_or(rig.network.send_utc);
  if (rig.network.host_ip != "auto" && !parse_ip(rig.network.host_ip)) {
    map->fail("host_ip", "is no IPv4 address", "write auto or an address like 192.168.1.50");
  }
}

void read_markers(const YamlMap& map, BoardSettings& board) {
  map.require("dictionary", "give the markers' dictionary, for example DICT_5X5_100");
  map.require("marker", "give the length of a marker's side");
  board.dictionary = map.text("dictionary").value_or("");
  board.marker = map.number("marker", 1e-6, 1e6).value_or(0.0);
  if (board.marker >= board.square && board.square > 0.0) {
    map.fail("marker", "is no smaller than a square", "measure the marker's dark rim from end to end");
  }
  const int number = marker_dictionary(board.dictionary);
  if (number < 0) {
    map.fail("dictionary", "is no dictionary of markers", "write one of OpenCV's names, from DICT_4X4_50 on");
    return;
  }
  const int needed = (board.inner_corners[0] + 1) * (board.inner_corners[1] + 1) / 2;
  if (marker_dictionaries[static_cast<std::size_t>(number)].markers < needed) {
    map.fail("dictionary", "has fewer markers than the board has bright squares", "look up what was printed");
  }
}

// What cannot be one board: lengths in two units, or width and height in another order than columns and rows.
void check_board_lengths(const YamlMap& map, const BoardSettings& board, bool has_lidar) {
  if (has_lidar && !can_be_metres(board.square)) {
    map.fail("square", "is " + number_text(board.square) + " m",
             "give lengths in metres where the rig has LiDARs: squares are of a millimetre to a metre");
    return;
  }
  const auto [width, height] = board.size;
  if (width <= 0.0 || height <= 0.0) return;
  const auto holds = [&](double across, double along, int beside_corners) {
    return (board.inner_corners[0] + beside_corners) * board.square <= across * plate_tolerance &&
           (board.inner_corners[1] + beside_corners) * board.square <= along * plate_tolerance;
  };
  if (!holds(width, height, 1) && holds(height, width, 1)) {
    map.fail("size", "has no room for the squares, but would have it turned by 90 degrees",
             "give width and height in the order of inner_corners, columns first");
  } else if (!holds(width, height, -1)) {
    map.fail("size", "has no room for the inner corners", "give it in the unit of square: the whole plate");
  }
}

void read_board(const YamlMap& top, Rig& rig) {
  const std::optional<YamlMap> map =
      top.map("board", {"type", "inner_corners", "square", "size", "offset", "dictionary", "marker"});
  if (!map) return;
  BoardSettings board;
  const bool is_charuco = map->choice("type", {"checkerboard", "charuco"}).value_or(0) == 1;
  map->require("inner_corners", "give columns and rows, for example [10, 8]");
  map->require("square", "give the length of a square's side");
  if (const auto corners = map->integers("inner_corners", 2, 2, 1000))
    board.inner_corners = {(*corners)[0], (*corners)[1]};
  board.square = map->number("square", 1e-6, 1e6).value_or(0.0);
  if (const auto size = map->numbers("size", 2, 2, 1e-6, 1e9)) board.size = {(*size)[0], (*size)[1]};
  if (const auto offset = map->numbers("offset", 2, 2, -1e9, 1e9)) board.offset = {(*offset)[0], (*offset)[1]};
  if (is_charuco) {
    board.type = "charuco";
    read_markers(*map, board);
  } else {
    for (const char* key : {"dictionary", "marker"}) {
      if (map->get(key) != nullptr)
        map->fail(key, "is of a board with markers", "write type: charuco, or leave it out");
    }
  }
  if (top.errors().ok()) check_board_lengths(*map, board, has_lidar(rig));
  rig.board = board;
}

}  // namespace

int Rig::find(const std::string& sensor_name) const {
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (sensors[i].name == sensor_name) return static_cast<int>(i);
  }
  return -1;
}

std::optional<SE3> read_transform(const YamlMap& map) {
  map.require("translation", "give [x, y, z] in metres");
  map.require("rotation_xyzw", "give the unit quaternion [x, y, z, w]");
  const auto t = map.numbers("translation", 3, 3, -max_translation_m, max_translation_m);
  const auto q = map.numbers("rotation_xyzw", 4, 4, -2.0, 2.0);
  if (!t || !q) return std::nullopt;
  const Eigen::Vector4d xyzw((*q)[0], (*q)[1], (*q)[2], (*q)[3]);
  if (std::abs(xyzw.norm() - 1.0) > quaternion_tolerance) {
    map.fail("rotation_xyzw", "has the length " + number_text(xyzw.norm()) + ", not 1",
             "give a unit quaternion in the order [x, y, z, w]");
    return std::nullopt;
  }
  return SE3{rotation_from_xyzw(xyzw), Vector3d((*t)[0], (*t)[1], (*t)[2])};
}

Expected<Rig> parse_rig(const std::string& text, const std::string& name) {
  const Expected<YamlNode> tree = parse_yaml(text, name);
  if (!tree) return tree.error();
  YamlErrors errors(name);
  const YamlMap version(*tree, "", errors, {});
  check_format_version(version);
  if (!errors.ok()) return errors.first();
  const YamlMap top(
      *tree, "", errors,
      {"rigcal", "name", "base", "sensors", "initial_extrinsics", "turntable", "trigger", "lidar", "board"});
  Rig rig;
  rig.name = top.text("name").value_or("");
  read_sensors(top, rig);
  if (!errors.ok()) return errors.first();
  check_duplicates(top, rig);
  read_base(top, rig);
  read_initial_extrinsics(top, rig);
  read_turntable(top, rig);
  read_trigger_lines(top, rig);
  read_network(top, rig);
  read_board(top, rig);
  if (!errors.ok()) return errors.first();
  return rig;
}

Expected<Rig> load_rig(const std::string& path) {
  Expected<RigFile> file = load_rig_file(path);
  if (!file) return file.error();
  return std::move(file->rig);
}

}  // namespace rigcal
