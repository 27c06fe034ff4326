#include "drivers/livox/protocol/settings.h"

#include <algorithm>
#include <string>

namespace rigcal::livox {
namespace {

WriteParametersRequest write_switch(ParameterKey key, Switch value) {
  return {{{static_cast<std::uint16_t>(key), {static_cast<std::uint8_t>(value)}}}};
}

const char* on_off(Switch value) { return value == Switch::on ? "on" : "off"; }

std::string echoes_text(Echoes echoes) {
  switch (echoes) {
    case Echoes::first:
      return "first";
    case Echoes::strongest:
      return "strongest";
    case Echoes::dual:
      return "dual";
    case Echoes::triple:
      return "triple";
  }
  return "?";
}

bool is_off(const WriteParametersRequest& request) {
  constexpr auto off = static_cast<std::uint8_t>(Switch::off);
  return std::all_of(request.parameters.begin(), request.parameters.end(), [](const Parameter& parameter) {
    return parameter.value.size() == 1 && parameter.value.front() == off;
  });
}

std::string parameter_text(const WriteParametersRequest& request) {
  const bool is_on = !is_off(request);
  const std::uint16_t key = request.parameters.empty() ? 0 : request.parameters.front().key;
  if (key == static_cast<std::uint16_t>(ParameterKey::scan_pattern))
    return std::string("scan_pattern: ") + (is_on ? "repetitive" : "non_repetitive");
  if (key == static_cast<std::uint16_t>(ParameterKey::high_sensitivity))
    return std::string("high_sensitivity: ") + on_off(is_on ? Switch::on : Switch::off);
  return "parameter " + std::to_string(key);
}

struct SettingText {
  std::string operator()(const CoordinatesRequest& request) const {
    return request.value == Coordinates::spherical ? "coordinates: spherical" : "coordinates: cartesian";
  }
  std::string operator()(const SetReturnModeRequest& request) const {
    return "return_mode: " + echoes_text(request.value);
  }
  std::string operator()(const SetImuRateRequest& request) const {
    return request.value == ImuRate::off ? "imu: false" : "imu: true";
  }
  std::string operator()(const WriteParametersRequest& request) const { return parameter_text(request); }
  std::string operator()(const SetFanRequest& request) const { return std::string("fan: ") + on_off(request.value); }
  std::string operator()(const RainSuppressionRequest& request) const {
    return std::string("rain_suppression: ") + on_off(request.value);
  }
  std::string operator()(const WriteExtrinsicsRequest&) const { return "stored extrinsics"; }
  template <class Other>
  std::string operator()(const Other&) const {
    return "?";
  }
};

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

std::string setting_text(const ControlPayload& request) { return std::visit(SettingText{}, request); }

bool is_met_unknown(const ControlPayload& request) {
  if (const auto* mode = std::get_if<SetReturnModeRequest>(&request))
    return mode->value == Echoes::first || mode->value == Echoes::strongest;
  if (const auto* imu = std::get_if<SetImuRateRequest>(&request)) return imu->value == ImuRate::off;
  if (const auto* write = std::get_if<WriteParametersRequest>(&request)) return is_off(*write);
  if (const auto* rain = std::get_if<RainSuppressionRequest>(&request)) return rain->value == Switch::off;
  return false;
}

}  // namespace rigcal::livox
