#pragma once

#include <map>
#include <optional>
#include <vector>

#include "drivers/livox_codec/control_payload.h"
#include "drivers/livox_codec/sample_packet.h"

namespace rigcal::sim {

/// What a virtual device remembers, and its answers to requests about that. Models answer what they have and refuse
/// what they have not; addresses and coordinates outlast a reboot, as everything here.
class VirtualSettings {
 public:
  VirtualSettings(const livox::Broadcast& identity, const livox::Ipv4& ip, const livox::FirmwareVersion& firmware);

  /// The answer to a request; nothing: the device knows no such request, or not with this value.
  [[nodiscard]] std::optional<livox::ControlPayload> answer(const livox::ControlPayload& request);

  /// What its points are sent as.
  [[nodiscard]] livox::DataType point_type() const;
  /// Single return: the first echo, not the strongest.
  [[nodiscard]] bool nearest_only() const { return echoes_ == livox::Echoes::first; }
  [[nodiscard]] bool sends_imu() const { return model().has_imu && imu_rate_ == livox::ImuRate::hz_200; }
  [[nodiscard]] bool suppresses_rain() const { return rain_ == livox::Switch::on; }
  /// As it wakes up: set by the rig file of a simulation, by an earlier owner of a real one.
  void set(livox::DataType points, bool nearest_only);
  /// From now on return modes with another number of echoes are refused.
  void keep_echoes() { keeps_echoes_ = true; }

 private:
  using Answer = std::optional<livox::ControlPayload>;
  Answer on(const livox::DeviceInformationRequest& request);
  Answer on(const livox::CoordinatesRequest& request);
  Answer on(const livox::SetIpModeRequest& request);
  Answer on(const livox::GetIpModeRequest& request);
  Answer on(const livox::WriteParametersRequest& request);
  Answer on(const livox::ReadParametersRequest& request);
  Answer on(const livox::ResetParametersRequest& request);
  Answer on(const livox::WriteExtrinsicsRequest& request);
  Answer on(const livox::ReadExtrinsicsRequest& request);
  Answer on(const livox::RainSuppressionRequest& request);
  Answer on(const livox::SetFanRequest& request);
  Answer on(const livox::GetFanRequest& request);
  Answer on(const livox::SetReturnModeRequest& request);
  Answer on(const livox::GetReturnModeRequest& request);
  Answer on(const livox::SetImuRateRequest& request);
  Answer on(const livox::GetImuRateRequest& request);
  template <class Request>
  Answer on(const Request&) {
    return std::nullopt;
  }

  [[nodiscard]] const LidarFacts& model() const { return livox::facts_of(identity_.type); }
  [[nodiscard]] bool is_mid40() const { return identity_.type == livox::DeviceType::mid40; }
  [[nodiscard]] livox::ParameterError check(const livox::Parameter& parameter) const;

  livox::Broadcast identity_;
  livox::FirmwareVersion firmware_;
  livox::Coordinates coordinates_ = livox::Coordinates::cartesian;
  livox::Echoes echoes_ = livox::Echoes::strongest;
  bool keeps_echoes_ = false;
  livox::ImuRate imu_rate_ = livox::ImuRate::hz_200;
  livox::Switch fan_ = livox::Switch::on;
  livox::Switch rain_ = livox::Switch::off;
  livox::StoredExtrinsics extrinsics_;
  livox::IpMode ip_mode_ = livox::IpMode::fixed;
  livox::Ipv4 ip_;
  livox::Subnet subnet_{{255, 255, 255, 0}, {192, 168, 1, 1}};
  std::map<std::uint16_t, std::uint8_t> parameters_;
};

}  // namespace rigcal::sim
