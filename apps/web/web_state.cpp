#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "apps/calibration/estimate_text.h"
#include "apps/recording/rig_lidars.h"
#include "apps/web/web_view.h"
#include "core/base/text.h"
#include "core/quality/lidar_quality.h"
#include "core/turntable/coach.h"
#include "drivers/livox_codec/status.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_drawn = 100;  // Estimates; all of it is sent twice a second.

Json sensor_json(const CaptureDevice& device) {
  return {{"sensor", device.sensor},
          {"state", livox::to_string(device.report.link.state)},
          {"packets_per_s", device.packets_per_s},
          {"lost", device.lost},
          {"drift_ppm", device.drift_ppm},
          {"sync", livox::sync_text(livox::decode_status(device.report.link.status))}};
}

Json camera_json(const CaptureCamera& camera) {
  // A picture has a number, so that a browser asks again when there is a new one.
  return {{"sensor", camera.sensor},
          {"state", camera.state},
          {"frames_per_s", camera.frames_per_s},
          {"written", camera.written},
          {"lost", camera.counters.damaged() + camera.counters.missing + camera.dropped_by_queue},
          {"picture", camera.written},
          {"picture_name", camera.sensor}};
}

// A cell has a hexadecimal digit for every four LiDARs, those of the last ones first.
Json panorama_json(const Rig& rig, const Panorama& panorama) {
  Json lidars = Json::array();
  for (const int sensor : lidar_sensors(rig)) {
    if (lidars.size() < std::size_t{Panorama::most_lidars})
      lidars.push_back(rig.sensors[static_cast<std::size_t>(sensor)].name);
  }
  std::string cells;
  for (const std::uint32_t mask : panorama.seen_by) {
    for (std::size_t digit = (lidars.size() + 3) / 4; digit-- > 0;)
      cells += "0123456789abcdef"[(mask >> (4 * digit)) & 15U];
  }
  return {{"columns", Panorama::columns}, {"rows", Panorama::rows}, {"lidars", lidars}, {"cells", cells}};
}

std::string disk_text(const CaptureStatus& status) {
  if (!status.disk) return {};
  return fixed_text(1e-9 * static_cast<double>(status.disk->free_bytes), 1) + " GB free on the disk, " +
         fixed_text(1e-6 * status.disk->bytes_per_s, 1) + " MB/s; a packet waited " +
         fixed_text(1e3 * status.worst_wait_s, 0) + " ms at most";
}

Json result_json(const WebResult& result) {
  Json sensors = Json::array();
  for (const WebResult::Sensor& sensor : result.sensors)
    sensors.push_back({{"sensor", sensor.name},
                       {"status", to_string(sensor.status)},
                       {"translation_bound_mm", 1e3 * sensor.translation_bound_m},
                       {"rotation_bound_deg", to_deg(sensor.rotation_bound_rad)}});
  return {{"status", to_string(result.status)}, {"sensors", std::move(sensors)}};
}

}  // namespace

WebResult web_result(const CalibrationResult& result) {
  WebResult out{result.status, {}, {}};
  for (const SensorResult& sensor : result.sensors) {
    WebResult::Sensor& told = out.sensors.emplace_back(WebResult::Sensor{sensor.name, sensor.status, 0.0, 0.0});
    if (!sensor.T_base_sensor || sensor.covariance.isZero(0.0)) continue;
    told.translation_bound_m = translation_bound(sensor.covariance);
    told.rotation_bound_rad = rotation_bound(sensor.covariance);
  }
  for (const Overlay& overlay : result.overlays) {
    if (overlay.kind == OverlayKind::edges) out.pictures.emplace(overlay.sensor, overlay.jpeg);
  }
  return out;
}

std::string web_state(const Rig& rig, const CaptureStatus& status, const LiveEstimates* known, const LiveView* view,
                      const Requirement& goal, const WebResult* result) {
  std::string what = advice(status.progress);
  if (result != nullptr) {
    what = std::string("The extrinsics stand: ") + to_string(result->status);
  } else if (known != nullptr && !known->estimates.empty()) {
    const StopEstimate& last = known->estimates.back();
    what += last.reached ? ". The goal is reached" : (last.advice_text.empty() ? "" : ". " + last.advice_text);
    if (known->left_out > 0) what += std::string(". Note: ") + LiveCalibration::kLeftOutText;
  }
  Json json{{"state", to_string(status.progress.state)},
            {"stops", status.progress.stops},
            {"seconds", status.seconds},
            {"bytes", status.bytes},
            {"advice", what},
            {"goal_mm", 1e3 * goal.translation_m},
            {"disk", disk_text(status)},
            {"events", status.news},
            {"sensors", Json::array()},
            {"cameras", Json::array()},
            {"estimates", Json::array()},
            {"panorama", nullptr},
            {"result", nullptr}};
  for (const CaptureDevice& device : status.devices) json["sensors"].push_back(sensor_json(device));
  for (const CaptureCamera& camera : status.cameras) json["cameras"].push_back(camera_json(camera));
  if (known != nullptr) {
    const std::span all(known->estimates);
    json["estimates"] = estimates_json(all.last(std::min(all.size(), most_drawn)));
  }
  if (result != nullptr) json["result"] = result_json(*result);
  // A browser asks again for the pictures.
  for (Json& camera : json["cameras"]) {
    if (result != nullptr && result->pictures.contains(camera["sensor"].get<std::string>()))
      camera["picture"] = camera["picture"].get<std::uint64_t>() + 1;
  }
  if (view != nullptr) json["panorama"] = panorama_json(rig, view->panorama);
  // One line: that is what an event is.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace rigcal
