#include "core/base/text.h"
#include "core/records/records.h"
#include "core/rig/rig.h"

namespace rigcal {
namespace {

/// Appends "key: value" lines of one nesting level.
class Lines {
 public:
  Lines(std::string& out, int indent) : out_(out), indent_(static_cast<std::size_t>(indent), ' ') {}

  void line(const std::string& text) { out_ += indent_ + text + "\n"; }
  void text(const char* key, const std::string& value) {
    if (!value.empty()) line(std::string(key) + ": " + quoted_text(value));
  }
  void word(const char* key, const std::string& value) { line(std::string(key) + ": " + value); }
  void number(const char* key, const std::optional<double>& value) {
    if (value) word(key, number_text(*value));
  }
  void integer(const char* key, const std::optional<int>& value) {
    if (value) word(key, std::to_string(*value));
  }
  void flag(const char* key, const std::optional<bool>& value) {
    if (value) word(key, *value ? "true" : "false");
  }
  template <class Values>
  void list(const char* key, const Values& values) {
    std::string text_line;
    for (const auto value : values) text_line += (text_line.empty() ? "" : ", ") + text_of(value);
    line(std::string(key) + ": [" + text_line + "]");
  }

 private:
  static std::string text_of(double value) { return number_text(value); }
  static std::string text_of(int value) { return std::to_string(value); }

  std::string& out_;
  std::string indent_;
};

void write_lidar(Lines out, const LidarSettings& lidar) {
  out.word("type", facts_of(lidar.model).word);
  out.text("broadcast_code", lidar.broadcast_code);
  if (lidar.ip) out.word("ip", to_string(*lidar.ip));
  if (lidar.rings) out.word("rings", "true");
  constexpr const char* modes[] = {"first", "strongest", "dual", "triple"};
  if (lidar.return_mode) out.word("return_mode", modes[static_cast<int>(*lidar.return_mode)]);
  if (lidar.coordinates) {
    out.word("coordinates", *lidar.coordinates == CoordinateSystem::cartesian ? "cartesian" : "spherical");
  }
  out.flag("imu", lidar.imu);
  out.text("scan_pattern", lidar.scan_pattern);
  if (lidar.range_m) out.list("range", *lidar.range_m);
  out.text("topic", lidar.topic);
  out.text("imu_topic", lidar.imu_topic);
}

void write_camera(Lines out, const CameraSettings& camera) {
  out.word("type", "camera");
  out.text("driver", camera.driver);
  out.text("device", camera.device);
  out.text("pixel_format", camera.pixel_format);
  out.number("exposure_us", camera.exposure_us);
  out.number("gain", camera.gain);
  out.number("frame_rate", camera.frame_rate);
  out.integer("packet_size", camera.packet_size);
  out.integer("packet_delay", camera.packet_delay);
  out.flag("ptp", camera.ptp);
  if (camera.strobe) out.text("strobe", *camera.strobe);
  if (camera.trigger) {
    out.line("trigger: {source: " + quoted_text(camera.trigger->source) + ", activation: " +
             camera.trigger->activation + ", delay_us: " + number_text(camera.trigger->delay_us) + "}");
  }
  out.text("topic", camera.topic);
}

void write_intrinsics(std::string& text, const CameraIntrinsics& intrinsics) {
  Lines(text, 4).line("intrinsics:");
  Lines out(text, 6);
  out.word("model", intrinsics.model == DistortionModel::radtan ? "radtan" : "equidistant");
  out.integer("width", intrinsics.width);
  out.integer("height", intrinsics.height);
  out.number("fx", intrinsics.fx);
  out.number("fy", intrinsics.fy);
  out.number("cx", intrinsics.cx);
  out.number("cy", intrinsics.cy);
  out.list("distortion", intrinsics.distortion);
}

void write_initial_extrinsics(std::string& text, const Rig& rig) {
  bool headed = false;
  for (const Sensor& sensor : rig.sensors) {
    if (!sensor.initial_T_base_sensor) continue;
    if (!headed) text += "initial_extrinsics:\n";
    headed = true;
    text += "  " + quoted_text(sensor.name) + ":\n";
    Lines out(text, 4);
    out.list("translation", sensor.initial_T_base_sensor->t);
    out.list("rotation_xyzw", xyzw_from_rotation(sensor.initial_T_base_sensor->R));
  }
}

void write_table_and_trigger(std::string& text, const Rig& rig) {
  if (rig.turntable) {
    text += "turntable:\n";
    Lines out(text, 2);
    out.word("driver", rig.turntable->driver);
    if (rig.turntable->axis) out.list("axis", *rig.turntable->axis);
    out.text("port", rig.turntable->port);
    out.integer("baud", rig.turntable->baud);
    out.text("protocol", rig.turntable->protocol);
    if (rig.turntable->is_reversed) out.flag("reverse", true);
    out.text("letter", rig.turntable->letter);
    out.number("speed_deg_s", rig.turntable->speed_deg_s);
    out.text("move", rig.turntable->move);
    out.text("ask", rig.turntable->ask);
    out.text("answer", rig.turntable->answer);
    out.text("done", rig.turntable->done);
    out.text("fault", rig.turntable->fault);
  }
  if (rig.trigger) {
    text += "trigger:\n";
    Lines out(text, 2);
    out.text("gpiochip", rig.trigger->gpiochip);
    out.integer("line", rig.trigger->line);
    out.number("pulse_us", rig.trigger->pulse_us);
    out.integer("strobe_line", rig.trigger->strobe_line);
    out.text("pps", rig.trigger->pps);
  }
}

void write_board(std::string& text, const BoardSettings& board) {
  text += "board:\n";
  Lines out(text, 2);
  out.word("type", board.type);
  out.list("inner_corners", board.inner_corners);
  out.number("square", board.square);
  if (board.size[0] > 0.0) out.list("size", board.size);
  out.list("offset", board.offset);
  if (board.dictionary.empty()) return;
  out.text("dictionary", board.dictionary);
  out.number("marker", board.marker);
}

}  // namespace

std::string write_rig(const Rig& rig) {
  std::string text = "rigcal: 1\n";
  Lines top(text, 0);
  top.text("name", rig.name);
  top.word("base", quoted_text(rig.base_sensor().name));
  text += "sensors:\n";
  for (const Sensor& sensor : rig.sensors) {
    text += "  " + quoted_text(sensor.name) + ":\n";
    if (sensor.lidar) write_lidar(Lines(text, 4), *sensor.lidar);
    if (sensor.camera) write_camera(Lines(text, 4), *sensor.camera);
    if (sensor.camera && sensor.camera->intrinsics) write_intrinsics(text, *sensor.camera->intrinsics);
    Lines(text, 4).text("folder", sensor.folder);
  }
  write_initial_extrinsics(text, rig);
  write_table_and_trigger(text, rig);
  text += "lidar: {interface: " + quoted_text(rig.network.interface) +
          ", host_ip: " + quoted_text(rig.network.host_ip) + (rig.network.send_utc ? ", send_utc: true}\n" : "}\n");
  if (rig.board) write_board(text, *rig.board);
  return text;
}

}  // namespace rigcal
