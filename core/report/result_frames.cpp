// Trees of frames with the base as root. The names of sensors are plain (`is_plain_name`), so nothing is escaped in
// XML.
#include <algorithm>
#include <set>

#include "core/base/text.h"
#include "core/report/result_writers.h"
#include "core/report/rpy.h"

namespace rigcal {
namespace {

std::string numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : " ") + number_text(value);
  return text;
}

/// ROS allows letters, digits and '_' in the name of a node.
std::string node_name(const std::string& base, const std::string& sensor) {
  std::string name = "tf_" + base + "_" + sensor;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '-' || c == '.'; }, '_');
  return name;
}

}  // namespace

std::string ros2_launch(const PlacedRig& rig) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<!-- Static transforms, unit quaternions. -->\n"
      "<launch>\n";
  std::set<std::string> taken;
  for (const PlacedSensor& sensor : rig.sensors) {
    if (sensor.name == rig.base) continue;
    const Vector3d& t = sensor.T_base_sensor.t;
    const Eigen::Vector4d q = xyzw_from_rotation(sensor.T_base_sensor.R);
    std::string node = node_name(rig.base, sensor.name);
    while (!taken.insert(node).second) node += "_2";  // "left-1" and "left.1" are two sensors
    text += "  <node pkg=\"tf2_ros\" exec=\"static_transform_publisher\" name=\"" + node + "\"\n        args=\"--x " +
            number_text(t.x()) + " --y " + number_text(t.y()) + " --z " + number_text(t.z()) + " --qx " +
            number_text(q[0]) + " --qy " + number_text(q[1]) + " --qz " + number_text(q[2]) + " --qw " +
            number_text(q[3]) + " --frame-id " + rig.base + " --child-frame-id " + sensor.name + "\"/>\n";
  }
  return text + "</launch>\n";
}

std::string urdf(const PlacedRig& rig) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<!-- Poses of the sensors in the base: metres; roll, pitch, yaw in rad with "
      "R = Rz(yaw) Ry(pitch) Rx(roll). -->\n<robot name=\"rig\">\n  <link name=\"" +
      rig.base + "\"/>\n";
  for (const PlacedSensor& sensor : rig.sensors) {
    if (sensor.name == rig.base) continue;
    text += "  <link name=\"" + sensor.name + "\"/>\n  <joint name=\"" + rig.base + "_to_" + sensor.name +
            "\" type=\"fixed\">\n    <parent link=\"" + rig.base + "\"/>\n    <child link=\"" + sensor.name +
            "\"/>\n    <origin xyz=\"" + numbers(sensor.T_base_sensor.t) + "\" rpy=\"" +
            numbers(rpy_from_rotation(sensor.T_base_sensor.R)) + "\"/>\n  </joint>\n";
  }
  return text + "</robot>\n";
}

std::string autoware_yaml(const PlacedRig& rig) {
  std::string text = key_text(rig.base) + ":\n";
  bool alone = true;
  for (const PlacedSensor& sensor : rig.sensors) {
    if (sensor.name == rig.base) continue;
    alone = false;
    const Vector3d& t = sensor.T_base_sensor.t;
    const Vector3d rpy = rpy_from_rotation(sensor.T_base_sensor.R);
    text += "  " + key_text(sensor.name) + ":\n    x: " + number_text(t.x()) + "\n    y: " + number_text(t.y()) +
            "\n    z: " + number_text(t.z()) + "\n    roll: " + number_text(rpy[0]) +
            "\n    pitch: " + number_text(rpy[1]) + "\n    yaw: " + number_text(rpy[2]) + "\n";
  }
  return alone ? key_text(rig.base) + ": {}\n" : text;
}

}  // namespace rigcal
