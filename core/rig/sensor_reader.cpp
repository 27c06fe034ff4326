#include "core/rig/sensor_reader.h"

#include <algorithm>
#include <cmath>

#include "core/base/parse_number.h"
#include "core/base/text.h"
#include "core/records/pixel_format.h"

namespace rigcal {
namespace {

constexpr std::size_t broadcast_code_length = 15;

bool is_letter_or_digit(char c) { return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

std::string read_folder(const YamlMap& map) {
  const std::string folder = map.text("folder").value_or("");
  if (!folder.empty() && !is_plain_name(folder)) {
    map.fail("folder", "is not usable", "use up to 64 letters, digits, '_', '-' and '.', no '.' in front");
  }
  return folder;
}

void read_lidar_addresses(const YamlMap& map, LidarSettings& lidar) {
  if (!facts_of(lidar.model).is_livox() && map.has("broadcast_code")) {
    map.fail("broadcast_code", "is given, but only Livox sensors have one", "remove it or correct the type");
  }
  if (const auto code = map.text("broadcast_code")) {
    lidar.broadcast_code = *code;
    if (code->size() != broadcast_code_length || !std::all_of(code->begin(), code->end(), is_letter_or_digit)) {
      map.fail("broadcast_code", "is not 15 letters and digits", "copy all 15 characters from the sensor's label");
    }
  }
  if (const auto ip = map.text("ip")) {
    lidar.ip = parse_ip(*ip);
    // 224 and above are multicast and broadcast addresses.
    if (!lidar.ip || (*lidar.ip)[0] == 0 || (*lidar.ip)[0] >= 224) {
      map.fail("ip", "is no address of a device", "write it like 192.168.1.179");
    }
  }
}

LidarSettings read_lidar(const YamlMap& map, LidarModel model) {
  LidarSettings lidar;
  lidar.model = model;
  read_lidar_addresses(map, lidar);
  lidar.rings = map.flag("rings").value_or(false);
  if (const auto mode = map.choice("return_mode", {"first", "strongest", "dual", "triple"})) {
    lidar.return_mode = static_cast<ReturnMode>(*mode);
  }
  if (const auto system = map.choice("coordinates", {"cartesian", "spherical"})) {
    lidar.coordinates = static_cast<CoordinateSystem>(*system);
  }
  lidar.imu = map.flag("imu");
  if (const auto pattern = map.choice("scan_pattern", {"non_repetitive", "repetitive"})) {
    lidar.scan_pattern = *pattern == 0 ? "non_repetitive" : "repetitive";
  }
  if (const auto range = map.numbers("range", 2, 2, 0.0, 1e4)) {
    lidar.range_m = {(*range)[0], (*range)[1]};
    if (!((*range)[0] < (*range)[1]))
      map.fail("range", "has its minimum above its maximum", "write [min, max] in metres");
  }
  lidar.topic = map.text("topic").value_or("");
  lidar.imu_topic = map.text("imu_topic").value_or("");
  return lidar;
}

std::optional<TriggerSettings> read_camera_trigger(const YamlMap& camera) {
  const auto map = camera.map("trigger", {"source", "activation", "delay_us"});
  if (!map) return std::nullopt;
  TriggerSettings trigger;
  map->require("source", "name the camera's input, for example Line0");
  trigger.source = map->text("source").value_or("");
  if (const auto edge = map->choice("activation", {"rising", "falling"})) {
    trigger.activation = *edge == 0 ? "rising" : "falling";
  }
  trigger.delay_us = map->number("delay_us", 0.0, 1e7).value_or(0.0);
  return trigger;
}

std::vector<std::string> usable_pixel_formats() {
  std::vector<std::string> formats;
  for (const char* layout : {"Mono", "BayerRG", "BayerGR", "BayerGB", "BayerBG", "RGB", "BGR"}) {
    for (const char* bits : {"8", "10", "12", "14", "16"}) formats.push_back(std::string(layout) + bits);
  }
  return formats;
}

/// The usable format that was probably meant, or empty.
std::string meant_pixel_format(const std::string& name) {
  const std::string small = small_letters(name);
  // As V4L2 (RGGB) and ROS (bayer_rggb8) call the mosaics.
  for (const char* square : {"rggb", "grbg", "gbrg", "bggr"}) {
    const std::size_t at = small.find(square);
    if (at == std::string::npos) continue;
    const std::string bits = small.substr(at + 4);
    std::string meant =
        std::string("Bayer") + static_cast<char>(square[0] - 'a' + 'A') + static_cast<char>(square[1] - 'a' + 'A');
    return parse_pixel_format(meant + bits) ? meant + bits : meant + "8";
  }
  const std::vector<std::string> formats = usable_pixel_formats();
  std::vector<std::string> small_formats;
  for (const std::string& format : formats) small_formats.push_back(small_letters(format));
  const std::string nearest = nearest_word(small, small_formats);
  const auto found = std::find(small_formats.begin(), small_formats.end(), nearest);
  return found == small_formats.end() ? std::string()
                                      : formats[static_cast<std::size_t>(found - small_formats.begin())];
}

/// Names of the GenICam convention that rigcal does not read from a camera, but that say clearly that there is no
/// mosaic: Mono12Packed, Mono10p, RGBa8, YUV422_8 and so on. The images of a recording may well have come that way.
bool is_plainly_no_mosaic(std::string_view name) {
  for (const std::string_view family : {"Mono", "RGB", "BGR", "RGBa", "BGRa", "YUV", "YCbCr"}) {
    if (name.size() > family.size() && name.starts_with(family) && name[family.size()] >= '1' &&
        name[family.size()] <= '9')
      return true;
  }
  return false;
}

/// A misspelt mosaic would be taken for grey values, and its pattern for edges.
std::string read_pixel_format(const YamlMap& camera) {
  std::string name = camera.text("pixel_format").value_or("");
  if (parse_pixel_format(name) || is_plainly_no_mosaic(name)) return name;
  const std::string meant = meant_pixel_format(name);
  camera.fail("pixel_format", "is '" + name.substr(0, 40) + "', which is no format that can be read",
              meant.empty() ? "use a name like BayerRG8, Mono12 or RGB8" : "did you mean '" + meant + "'?");
  return name;
}

CameraSettings read_camera(const YamlMap& map) {
  CameraSettings camera;
  if (const auto driver = map.choice("driver", {"aravis", "v4l2", "images"})) {
    camera.driver = *driver == 0 ? "aravis" : (*driver == 1 ? "v4l2" : "images");
  }
  camera.device = map.text("device").value_or("");
  camera.pixel_format = read_pixel_format(map);
  camera.exposure_us = map.number("exposure_us", 0.1, 1e8);
  camera.gain = map.number("gain", -100.0, 1000.0);
  camera.frame_rate = map.number("frame_rate", 1e-3, 1e5);
  if (const auto size = map.integer("packet_size", 64, 65535)) camera.packet_size = static_cast<int>(*size);
  if (const auto delay = map.integer("packet_delay", 0, 1'000'000'000)) camera.packet_delay = static_cast<int>(*delay);
  camera.ptp = map.flag("ptp");
  camera.strobe = map.text("strobe");
  camera.trigger = read_camera_trigger(map);
  camera.intrinsics = read_intrinsics(map);
  camera.topic = map.text("topic").value_or("");
  return camera;
}

// The LiDAR models in their order, then cameras.
std::vector<std::string_view> sensor_types() {
  std::vector<std::string_view> types;
  for (const LidarFacts& model : lidar_models()) types.emplace_back(model.word);
  types.emplace_back("camera");
  return types;
}

// With a focal length of so few pixels the image's corner would be at the tangent of 85 degrees: no lens sees so far.
double read_focal_length(const YamlMap& map, const char* key, const CameraIntrinsics& size) {
  constexpr double shortest_share = 1.0 / 11.43;
  const std::optional<double> value_px = map.number(key, 1.0, 1e6);
  if (!value_px) return 1.0;
  if (*value_px < shortest_share * 0.5 * std::hypot(size.width, size.height)) {
    map.fail(key, "is too small for an image of " + std::to_string(size.width) + " x " + std::to_string(size.height),
             "it is in pixels: were these millimetres? Divide them by the size of a pixel");
  }
  return *value_px;
}

}  // namespace

std::optional<CameraIntrinsics> read_intrinsics(const YamlMap& camera) {
  const auto map = camera.map("intrinsics", {"model", "width", "height", "fx", "fy", "cx", "cy", "distortion"});
  if (!map) return std::nullopt;
  for (const char* key : {"model", "width", "height", "fx", "fy", "cx", "cy"}) map->require(key);
  CameraIntrinsics intrinsics;
  if (const auto model = map->choice("model", {"radtan", "equidistant"})) {
    intrinsics.model = static_cast<DistortionModel>(*model);
  }
  intrinsics.width = static_cast<int>(map->integer("width", 1, 65536).value_or(1));
  intrinsics.height = static_cast<int>(map->integer("height", 1, 65536).value_or(1));
  intrinsics.fx = read_focal_length(*map, "fx", intrinsics);
  intrinsics.fy = read_focal_length(*map, "fy", intrinsics);
  // The principal point of a shifted lens may lie outside the image, but not further than its size.
  intrinsics.cx = map->number("cx", -intrinsics.width, 2.0 * intrinsics.width).value_or(0.0);
  intrinsics.cy = map->number("cy", -intrinsics.height, 2.0 * intrinsics.height).value_or(0.0);
  const std::size_t count = distortion_count(intrinsics.model);
  intrinsics.distortion = map->numbers("distortion", 4, count, -1e3, 1e3).value_or(std::vector<double>{});
  intrinsics.distortion.resize(count, 0.0);  // radtan with four numbers: k3 = 0
  return intrinsics;
}

bool is_plain_name(std::string_view name) {
  const auto is_plain = [](char c) { return is_letter_or_digit(c) || c == '_' || c == '-' || c == '.'; };
  return !name.empty() && name.size() <= 64 && name.front() != '.' && std::all_of(name.begin(), name.end(), is_plain);
}

std::optional<std::array<std::uint8_t, 4>> parse_ip(std::string_view text) {
  std::array<std::uint8_t, 4> ip{};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string_view part = text.substr(0, i < 3 ? text.find('.') : text.npos);
    const auto number = parse_number<std::uint8_t>(part);
    if (!number || part.size() > 3) return std::nullopt;
    ip[i] = *number;
    text.remove_prefix(std::min(part.size() + 1, text.size()));
  }
  return ip;
}

Sensor read_sensor(const std::string& name, const YamlNode& node, YamlErrors& errors) {
  Sensor sensor;
  sensor.name = name;
  const std::string full_name = "sensors." + name;
  const YamlMap any(node, full_name, errors, {});
  if (!errors.ok()) return sensor;
  // Before asking for the type: a misspelt `type` should be named, not reported as missing.
  if (!any.has("type")) {
    const YamlMap misspelt(node, full_name, errors,
                           {"type",   "broadcast_code", "ip",           "rings",        "return_mode", "coordinates",
                            "imu",    "scan_pattern",   "range",        "topic",        "imu_topic",   "folder",
                            "driver", "device",         "pixel_format", "exposure_us",  "trigger",     "intrinsics",
                            "gain",   "frame_rate",     "packet_size",  "packet_delay", "ptp",         "strobe"});
    misspelt.require("type", "say what it is, for example livox_mid40 or camera");
    return sensor;
  }
  const auto type = any.choice("type", sensor_types());
  if (!type) return sensor;
  if (*type == lidar_models().size()) {
    const YamlMap map(node, full_name, errors,
                      {"type", "driver", "device", "pixel_format", "exposure_us", "trigger", "intrinsics", "gain",
                       "frame_rate", "packet_size", "packet_delay", "ptp", "strobe", "topic", "folder"});
    sensor.camera = read_camera(map);
    sensor.folder = read_folder(map);
  } else {
    const YamlMap map(node, full_name, errors,
                      {"type", "broadcast_code", "ip", "rings", "return_mode", "coordinates", "imu", "scan_pattern",
                       "range", "topic", "imu_topic", "folder"});
    sensor.lidar = read_lidar(map, static_cast<LidarModel>(*type));
    sensor.folder = read_folder(map);
  }
  return sensor;
}

}  // namespace rigcal
