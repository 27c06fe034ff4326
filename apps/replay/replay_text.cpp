#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/common/json_text.h"
#include "apps/replay/replay.h"
#include "core/base/version.h"

namespace rigcal {

std::string replay_text(const ReplayOptions& options, const ReplaySummary& summary) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), "%s: %.1f s played: %llu packets, %.0f MB%s\n", options.input.c_str(),
                summary.seconds, static_cast<unsigned long long>(summary.datagrams),
                static_cast<double>(summary.bytes) * 1e-6, summary.is_complete ? "" : " (stopped)");
  std::string all = text.data();
  for (const ReplayedDevice& device : summary.devices) {
    all += "  " + livox::model_name(device.broadcast.type) + " " + device.broadcast.broadcast_code + " at " +
           to_string(device.ip) + ": " + std::to_string(device.sent) + " packets";
    if (device.not_wanted > 0)
      all += ", " + std::to_string(device.not_wanted) + " not sent, as no host had asked for them";
    all += "\n";
  }
  if (summary.unsent > 0) all += std::to_string(summary.unsent) + " packets could not be sent\n";
  return all;
}

std::string replay_json(const ReplayOptions& options, const ReplaySummary& summary) {
  nlohmann::ordered_json json{{"rigcal", format_version},       {"command", "replay"},
                              {"input", options.input},         {"as_devices", options.as_devices},
                              {"speed", options.speed},         {"seconds", summary.seconds},
                              {"passes", summary.passes},       {"complete", summary.is_complete},
                              {"datagrams", summary.datagrams}, {"bytes", summary.bytes},
                              {"unsent", summary.unsent},       {"left_out", summary.left_out},
                              {"latest_s", summary.latest_s},   {"truncation", summary.truncation}};
  json["devices"] = nlohmann::ordered_json::array();
  for (const ReplayedDevice& device : summary.devices)
    json["devices"].push_back({{"ip", to_string(device.ip)},
                               {"recorded_ip", to_string(device.recorded_ip)},
                               {"broadcast_code", device.broadcast.broadcast_code},
                               {"model", livox::model_name(device.broadcast.type)},
                               {"sent", device.sent},
                               {"not_wanted", device.not_wanted}});
  return json_text(json);
}

}  // namespace rigcal
