#include "simdata/live/virtual_settings.h"

namespace rigcal::sim {
namespace {

using livox::DeviceType;
using livox::ParameterError;
using livox::ParameterKey;
using livox::ReturnCode;

std::map<std::uint16_t, std::uint8_t> default_parameters(DeviceType type) {
  const LivoxFacts& model = livox::facts_of(type).livox;
  std::map<std::uint16_t, std::uint8_t> values;
  const auto add = [&](ParameterKey key, std::uint8_t value) { values[static_cast<std::uint16_t>(key)] = value; };
  if (model.has_sensitivity) add(ParameterKey::high_sensitivity, 1);
  if (model.has_scan_choice) add(ParameterKey::scan_pattern, 0);
  if (model.has_slot) add(ParameterKey::slot_number, 1);
  return values;
}

// The tens of 192.168.1.x that old firmware lets a unit of a Mid-100 have.
bool is_in_share(const livox::Broadcast& identity, const livox::Ipv4& ip) {
  const int first = identity.broadcast_code.back() == '2' ? 81 : identity.broadcast_code.back() == '3' ? 151 : 11;
  return ip[0] == 192 && ip[1] == 168 && ip[2] == 1 && ip[3] >= first && ip[3] < first + 70;
}

int echoes_of(livox::Echoes mode) { return mode == livox::Echoes::triple ? 3 : mode == livox::Echoes::dual ? 2 : 1; }

}  // namespace

VirtualSettings::VirtualSettings(const livox::Broadcast& identity, const livox::Ipv4& ip,
                                 const livox::FirmwareVersion& firmware)
    : identity_(identity), firmware_(firmware), ip_(ip), parameters_(default_parameters(identity.type)) {}

void VirtualSettings::set(livox::DataType points, bool nearest_only) {
  const livox::RecordLayout& layout = livox::record_layout(points);
  coordinates_ = layout.spherical ? livox::Coordinates::spherical : livox::Coordinates::cartesian;
  const livox::Echoes single = nearest_only ? livox::Echoes::first : livox::Echoes::strongest;
  echoes_ = layout.echoes == 3 ? livox::Echoes::triple : layout.echoes == 2 ? livox::Echoes::dual : single;
}

livox::DataType VirtualSettings::point_type() const {
  using livox::DataType;
  const bool spherical = coordinates_ == livox::Coordinates::spherical;
  if (is_mid40()) return spherical ? DataType::spherical : DataType::cartesian;
  switch (echoes_) {
    case livox::Echoes::dual:
      return spherical ? DataType::dual_spherical : DataType::dual_cartesian;
    case livox::Echoes::triple:
      return spherical ? DataType::triple_spherical : DataType::triple_cartesian;
    default:
      return spherical ? DataType::spherical_tagged : DataType::cartesian_tagged;
  }
}

std::optional<livox::ControlPayload> VirtualSettings::answer(const livox::ControlPayload& request) {
  return std::visit([this](const auto& content) { return on(content); }, request);
}

VirtualSettings::Answer VirtualSettings::on(const livox::DeviceInformationRequest&) {
  return livox::DeviceInformationAck{ReturnCode::success, firmware_};
}

VirtualSettings::Answer VirtualSettings::on(const livox::CoordinatesRequest& request) {
  coordinates_ = request.value;
  return livox::CoordinatesAck{};
}

VirtualSettings::Answer VirtualSettings::on(const livox::SetIpModeRequest& request) {
  if (request.mode == livox::IpMode::fixed) {
    if (is_mid40() && !is_in_share(identity_, request.ip)) return std::nullopt;
    ip_ = request.ip;
    if (request.subnet) subnet_ = *request.subnet;
  }
  ip_mode_ = request.mode;
  return livox::SetIpModeAck{};
}

VirtualSettings::Answer VirtualSettings::on(const livox::GetIpModeRequest&) {
  livox::GetIpModeAck ack{ReturnCode::success, ip_mode_, ip_, subnet_};
  if (is_mid40()) ack.subnet.reset();
  return ack;
}

ParameterError VirtualSettings::check(const livox::Parameter& parameter) const {
  if (parameters_.count(parameter.key) == 0) return ParameterError::key_not_supported;
  if (parameter.value.size() != 1) return ParameterError::wrong_length;
  const bool is_switch = parameter.key != static_cast<std::uint16_t>(ParameterKey::slot_number);
  return parameter.value[0] > (is_switch ? 1 : 9) ? ParameterError::wrong_value : ParameterError::none;
}

VirtualSettings::Answer VirtualSettings::on(const livox::WriteParametersRequest& request) {
  if (!model().livox.parameters) return std::nullopt;
  for (const livox::Parameter& parameter : request.parameters) {
    const ParameterError error = check(parameter);
    if (error != ParameterError::none) return livox::WriteParametersAck{ReturnCode::failure, parameter.key, error};
  }
  for (const livox::Parameter& parameter : request.parameters) parameters_[parameter.key] = parameter.value[0];
  return livox::WriteParametersAck{};
}

VirtualSettings::Answer VirtualSettings::on(const livox::ReadParametersRequest& request) {
  if (!model().livox.parameters) return std::nullopt;
  livox::ReadParametersAck ack;
  for (const std::uint16_t key : request.keys) {
    const auto found = parameters_.find(key);
    if (found == parameters_.end())
      return livox::ReadParametersAck{ReturnCode::failure, key, ParameterError::key_not_supported, {}};
    ack.parameters.push_back({key, {found->second}});
  }
  // 300 times the same key would fit into no frame.
  if (ack.parameters.size() > 100)
    return livox::ReadParametersAck{ReturnCode::failure, 0, ParameterError::buffer_too_small, {}};
  return ack;
}

VirtualSettings::Answer VirtualSettings::on(const livox::ResetParametersRequest& request) {
  if (!model().livox.resets_parameters) return std::nullopt;
  const auto defaults = default_parameters(identity_.type);
  if (request.scope == livox::ParameterReset::all) {
    parameters_ = defaults;
    return livox::ResetParametersAck{};
  }
  for (const std::uint16_t key : request.keys)
    if (defaults.count(key) == 0)
      return livox::ResetParametersAck{ReturnCode::failure, key, ParameterError::key_not_supported};
  for (const std::uint16_t key : request.keys) parameters_[key] = defaults.at(key);
  return livox::ResetParametersAck{};
}

VirtualSettings::Answer VirtualSettings::on(const livox::WriteExtrinsicsRequest& request) {
  extrinsics_ = request.value;
  return livox::WriteExtrinsicsAck{};
}

VirtualSettings::Answer VirtualSettings::on(const livox::ReadExtrinsicsRequest&) {
  return livox::ReadExtrinsicsAck{ReturnCode::success, extrinsics_};
}

VirtualSettings::Answer VirtualSettings::on(const livox::RainSuppressionRequest& request) {
  if (!model().livox.suppresses_rain) return std::nullopt;
  rain_ = request.value;
  return livox::RainSuppressionAck{};
}

VirtualSettings::Answer VirtualSettings::on(const livox::SetFanRequest& request) {
  if (!model().livox.fan) return std::nullopt;
  fan_ = request.value;
  return livox::SetFanAck{};
}

VirtualSettings::Answer VirtualSettings::on(const livox::GetFanRequest&) {
  if (!model().livox.fan) return std::nullopt;
  return livox::GetFanAck{ReturnCode::success, fan_};
}

VirtualSettings::Answer VirtualSettings::on(const livox::SetReturnModeRequest& request) {
  if (echoes_of(request.value) > model().echoes || !model().livox.return_mode) return std::nullopt;
  if (keeps_echoes_ && echoes_of(request.value) != echoes_of(echoes_)) return std::nullopt;
  echoes_ = request.value;
  return livox::SetReturnModeAck{};
}

VirtualSettings::Answer VirtualSettings::on(const livox::GetReturnModeRequest&) {
  if (!model().livox.return_mode) return std::nullopt;
  return livox::GetReturnModeAck{ReturnCode::success, echoes_};
}

VirtualSettings::Answer VirtualSettings::on(const livox::SetImuRateRequest& request) {
  if (!model().has_imu) return std::nullopt;
  imu_rate_ = request.value;
  return livox::SetImuRateAck{};
}

VirtualSettings::Answer VirtualSettings::on(const livox::GetImuRateRequest&) {
  if (!model().has_imu) return std::nullopt;
  return livox::GetImuRateAck{ReturnCode::success, imu_rate_};
}

}  // namespace rigcal::sim
