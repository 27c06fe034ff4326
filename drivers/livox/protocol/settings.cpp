#include "drivers/livox/protocol/settings.h"

namespace rigcal::livox {
namespace {

WriteParametersRequest write_switch(ParameterKey key, Switch value) {
  return {{{static_cast<std::uint16_t>(key), {static_cast<std::uint8_t>(value)}}}};
}

}  // namespace

std::vector<ControlPayload> setup_requests(const DeviceSettings& settings) {
  std::vector<ControlPayload> requests;
  if (settings.coordinates) requests.emplace_back(CoordinatesRequest{*settings.coordinates});
  if (settings.return_mode) requests.emplace_back(SetReturnModeRequest{*settings.return_mode});
  if (settings.imu_rate) requests.emplace_back(SetImuRateRequest{*settings.imu_rate});
  if (settings.high_sensitivity)
    requests.emplace_back(write_switch(ParameterKey::high_sensitivity, *settings.high_sensitivity));
  if (settings.repetitive_scan)
    requests.emplace_back(write_switch(ParameterKey::scan_pattern, *settings.repetitive_scan));
  if (settings.fan) requests.emplace_back(SetFanRequest{*settings.fan});
  if (settings.rain_suppression) requests.emplace_back(RainSuppressionRequest{*settings.rain_suppression});
  if (settings.extrinsics) requests.emplace_back(WriteExtrinsicsRequest{*settings.extrinsics});
  return requests;
}

}  // namespace rigcal::livox
