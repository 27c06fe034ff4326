#include "drivers/camera/aravis/device.h"

#include <arv.h>

#include <cmath>
#include <limits>

#include "core/base/parse_number.h"
#include "core/base/text.h"
#include "core/records/records.h"
#include "drivers/camera/aravis/problem.h"
#include "drivers/camera/camera.h"

namespace rigcal::camera {
namespace {

using Flag = std::shared_ptr<std::atomic<bool>>;

void on_control_lost(ArvDevice*, gpointer flag) { (*static_cast<Flag*>(flag))->store(true); }
void free_flag(gpointer flag, GClosure*) { delete static_cast<Flag*>(flag); }

ArvDevice* device_of(ArvCamera* camera) { return arv_camera_get_device(camera); }

/// Who holds a GigE camera, where it tells: the address is in a register of the standard.
std::string holder_of(ArvCamera* camera) {
  constexpr guint64 primary_ip = 0x0A14;
  guint32 ip = 0;
  Problem problem;
  if (!arv_device_read_register(device_of(camera), primary_ip, &ip, problem.put()) || ip == 0) return {};
  const auto byte = [ip](int shift) { return static_cast<std::uint8_t>(ip >> shift); };
  return rigcal::to_string(std::array<std::uint8_t, 4>{byte(24), byte(16), byte(8), byte(0)});
}

std::string address_of(ArvDevice* device) {
  if (!ARV_IS_GV_DEVICE(device)) return {};
  GSocketAddress* address = arv_gv_device_get_device_address(ARV_GV_DEVICE(device));
  gchar* text = g_inet_address_to_string(g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address)));
  std::string copy = text;
  g_free(text);
  return copy;
}

std::string copy_of(const char* text) { return text == nullptr ? std::string() : std::string(text); }

Error held(const std::string& name, const std::string& holder) {
  return system_error("the camera is held by another program" + (holder.empty() ? "" : " on " + holder), name,
                      "end that program; a camera whose program crashed is free some seconds later");
}

}  // namespace

Device::Device(ArvCamera* camera) : camera_(camera) {
  handler_ = g_signal_connect_data(device_of(camera_), "control-lost", G_CALLBACK(on_control_lost), new Flag(lost_),
                                   free_flag, GConnectFlags{});
}

Device::~Device() {
  g_signal_handler_disconnect(device_of(camera_), handler_);
  g_object_unref(camera_);
}

Expected<std::unique_ptr<Device>> Device::open(const std::string& name) {
  Problem problem;
  ArvCamera* camera = arv_camera_new(name.c_str(), problem.put());
  if (camera == nullptr) {
    if (problem.is_held()) return held(name, {});
    return problem.is_absent() || problem.is_none()
               ? system_error(no_such_camera, name, "look at its cable, its power and its address")
               : problem.result("the camera cannot be opened", name, "take its power away for a moment").error();
  }
  std::unique_ptr<Device> device(new Device(camera));
  // Without control Aravis would let us read, but not set.
  if (device->is_gige() && !arv_gv_device_is_controller(ARV_GV_DEVICE(device_of(camera))))
    return held(name, holder_of(camera));
  device->read_identity(name);
  return device;
}

void Device::read_identity(const std::string& name) {
  Problem problem;
  identity_.vendor = copy_of(arv_camera_get_vendor_name(camera_, problem.put()));
  identity_.model = copy_of(arv_camera_get_model_name(camera_, problem.put()));
  identity_.serial = copy_of(arv_camera_get_device_serial_number(camera_, problem.put()));
  identity_.id = identity_.vendor + "-" + identity_.model + "-" + identity_.serial;
  identity_.link = is_usb() ? "USB3 Vision" : "GigE Vision";
  identity_.address = is_gige() ? address_of(device_of(camera_)) : name;
}

bool Device::is_gige() const { return ARV_IS_GV_DEVICE(device_of(camera_)) != 0; }
bool Device::is_usb() const { return ARV_IS_UV_DEVICE(device_of(camera_)) != 0; }

bool Device::has(const std::string& feature) const {
  Problem problem;
  return !feature.empty() && arv_device_is_feature_available(device_of(camera_), feature.c_str(), problem.put()) != 0 &&
         problem.is_none();
}

std::string Device::name_of(Purpose purpose) const {
  for (const std::string_view name : names_of(purpose, vendor())) {
    if (has(std::string(name))) return std::string(name);
  }
  return {};
}

Expected<std::string> Device::get(const std::string& feature) const {
  ArvDevice* device = device_of(camera_);
  ArvGcNode* node = arv_device_get_feature(device, feature.c_str());
  Problem problem;
  std::string value;
  if (node == nullptr) return system_error("the camera has no " + feature, identity_.id);
  if (ARV_IS_GC_ENUMERATION(node) || ARV_IS_GC_STRING(node)) {
    value = copy_of(arv_device_get_string_feature_value(device, feature.c_str(), problem.put()));
  } else if (ARV_IS_GC_BOOLEAN(node)) {
    value = arv_device_get_boolean_feature_value(device, feature.c_str(), problem.put()) != 0 ? "true" : "false";
  } else if (ARV_IS_GC_FLOAT(node)) {
    value = number_text(arv_device_get_float_feature_value(device, feature.c_str(), problem.put()));
  } else {
    value = std::to_string(arv_device_get_integer_feature_value(device, feature.c_str(), problem.put()));
  }
  heard(problem);
  if (auto done = problem.result(feature + " cannot be read", identity_.id); !done) return done.error();
  return value;
}

Expected<double> Device::number(const std::string& feature) const {
  const Expected<std::string> text = get(feature);
  if (!text) return text.error();
  const std::optional<double> value = parse_number<double>(*text);
  if (!value) return system_error(feature + " is no number but '" + *text + "'", identity_.id);
  return *value;
}

Expected<void> Device::set(const std::string& feature, const std::string& value) {
  ArvDevice* device = device_of(camera_);
  ArvGcNode* node = arv_device_get_feature(device, feature.c_str());
  if (node == nullptr) return system_error("the camera has no " + feature, identity_.id);
  Problem problem;
  if (ARV_IS_GC_ENUMERATION(node) || ARV_IS_GC_STRING(node)) {
    arv_device_set_string_feature_value(device, feature.c_str(), value.c_str(), problem.put());
  } else if (ARV_IS_GC_BOOLEAN(node)) {
    arv_device_set_boolean_feature_value(device, feature.c_str(), value == "true" ? 1 : 0, problem.put());
  } else {
    const std::optional<double> number = parse_number<double>(value);
    if (!number) return system_error(feature + " takes a number, not '" + value + "'", identity_.id);
    if (ARV_IS_GC_FLOAT(node)) {
      arv_device_set_float_feature_value(device, feature.c_str(), *number, problem.put());
    } else {
      arv_device_set_integer_feature_value(device, feature.c_str(), std::llround(*number), problem.put());
    }
  }
  heard(problem);
  if (problem.is_none()) return {};
  return problem.result(feature + " cannot be set to " + value, identity_.id, answers() ? what_it_takes(feature) : "");
}

Expected<void> Device::execute(const std::string& command) {
  Problem problem;
  arv_device_execute_command(device_of(camera_), command.c_str(), problem.put());
  heard(problem);
  return problem.result("the camera does not do " + command, identity_.id);
}

std::pair<double, double> Device::range(const std::string& feature) const {
  constexpr double any = std::numeric_limits<double>::max();
  ArvDevice* device = device_of(camera_);
  ArvGcNode* node = arv_device_get_feature(device, feature.c_str());
  Problem problem;
  std::pair<double, double> range{-any, any};
  if (ARV_IS_GC_FLOAT(node)) {
    arv_device_get_float_feature_bounds(device, feature.c_str(), &range.first, &range.second, problem.put());
  } else if (ARV_IS_GC_INTEGER(node)) {
    gint64 least = 0;
    gint64 most = 0;
    arv_device_get_integer_feature_bounds(device, feature.c_str(), &least, &most, problem.put());
    range = {static_cast<double>(least), static_cast<double>(most)};
  }
  return problem.is_none() ? range : std::pair{-any, any};
}

std::int64_t Device::step(const std::string& feature) const {
  Problem problem;
  const gint64 step = arv_device_get_integer_feature_increment(device_of(camera_), feature.c_str(), problem.put());
  return problem.is_none() && step > 0 ? step : 1;
}

std::vector<std::string> Device::entries(const std::string& feature) const {
  Problem problem;
  guint count = 0;
  if (!has(feature)) return {};
  const char** names = arv_device_dup_available_enumeration_feature_values_as_strings(
      device_of(camera_), feature.c_str(), &count, problem.put());
  std::vector<std::string> entries;
  for (guint i = 0; names != nullptr && i < count; ++i) entries.emplace_back(names[i]);
  g_free(names);
  return entries;
}

bool Device::has_entry(const std::string& feature, const std::string& entry) const {
  for (const std::string& there : entries(feature)) {
    if (there == entry) return true;
  }
  return false;
}

std::string Device::what_it_takes(const std::string& feature) const {
  const std::vector<std::string> words = entries(feature);
  if (!words.empty()) return "it can be " + list_text(words);
  const auto [least, most] = range(feature);
  if (most >= std::numeric_limits<double>::max()) return "leave it as it is";
  return "it takes " + fixed_text(least, 3) + " to " + fixed_text(most, 3);
}

}  // namespace rigcal::camera
