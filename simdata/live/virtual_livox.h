#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "core/base/random.h"
#include "core/records/records.h"
#include "simdata/live/device_time.h"
#include "simdata/live/virtual_settings.h"

namespace rigcal::sim {

/// What goes wrong with the control frames that a device sends. Shares of all of them.
struct ControlFaults {
  double drop = 0.0;
  double duplicate = 0.0;
  double delay = 0.0;  ///< By up to `longest_delay_s`; others overtake it.
  double longest_delay_s = 0.3;
  double wrong_number = 0.0;    ///< An ack that answers another request.
  double wrong_checksum = 0.0;  ///< One bit is wrong.
};

struct VirtualLivoxOptions {
  livox::Broadcast identity;
  livox::Ipv4 ip{};
  std::optional<livox::FirmwareVersion> firmware;  ///< Nothing: a late one of the model.
  Endpoint broadcast_to{{255, 255, 255, 255}, livox::kDiscoveryPort};
  double broadcast_s = 1.0;
  double owner_timeout_s = 5.0;  ///< Without a heartbeat.
  double spin_up_s = 2.0;        ///< From switching on to the first points.
  double boot_s = 1.0;           ///< Dark, before that.
  TimeSourceOptions time;
  ControlFaults faults;
  std::uint64_t seed = 1;
};

/// A control frame from the device's port 65000.
struct DeviceFrame {
  Endpoint to;
  std::vector<std::uint8_t> bytes;
};

/// The control side of a LiDAR as its firmware behaves: broadcasts until a host takes it, answers that host, spins up,
/// samples, gives itself free when the heartbeats stop. A pure state machine: frames and time (any monotonic clock) in,
/// frames out. Its points are made and sent by others, as `sampling`, `settings` and `owner` say.
class VirtualLivox {
 public:
  struct Owner {
    livox::Ipv4 ip{};
    std::uint16_t command_port = 0;
    std::uint16_t data_port = 0;
    std::uint16_t imu_port = 0;
  };

  /// Switched on at `now_ns`.
  VirtualLivox(VirtualLivoxOptions options, std::int64_t now_ns);

  /// A datagram to port 65000; any bytes are safe.
  void receive(std::int64_t now_ns, const Endpoint& from, ByteView bytes, std::vector<DeviceFrame>& out);
  void tick(std::int64_t now_ns, std::vector<DeviceFrame>& out);
  /// When `tick` has something to do next.
  [[nodiscard]] std::int64_t deadline_ns() const;

  [[nodiscard]] bool is_sampling() const { return is_sampling_ && owner_.has_value(); }
  [[nodiscard]] const std::optional<Owner>& owner() const { return owner_; }
  [[nodiscard]] const VirtualSettings& settings() const { return settings_; }
  [[nodiscard]] livox::WorkState work_state() const { return work_state_; }
  [[nodiscard]] std::uint32_t status() const { return time_.with_sync_bits(status_); }
  /// What its stamps follow.
  [[nodiscard]] const DeviceTime& time() const { return time_; }
  /// When its clock started.
  [[nodiscard]] std::int64_t booted_ns() const { return booted_ns_; }

  /// How it was set up when it was switched on.
  void wake_with(livox::DataType points, bool nearest_only) { settings_.set(points, nearest_only); }
  /// It refuses return modes with another number of echoes than it has: nothing else was recorded.
  void keep_echoes() { settings_.keep_echoes(); }

  // Faults that are asked for.
  void reboot(std::int64_t now_ns);
  /// Hears and says nothing until then; its points stop too.
  void fall_silent(std::int64_t until_ns) { silent_until_ns_ = until_ns; }
  [[nodiscard]] bool is_silent(std::int64_t now_ns) const { return is_dark_ || now_ns < silent_until_ns_; }
  /// An error in the system bits also stops it from working.
  void set_status(std::uint32_t status);
  /// The word alone, as a device was recorded to tell it while it went on working.
  void report_status(std::uint32_t status) { status_ = status; }
  void refuse(livox::Command command) { refused_.insert(command); }
  /// Another host has it (or lets it go): it does not broadcast and takes nobody.
  void set_owned_by_other(bool owned) { is_owned_by_other_ = owned; }

 private:
  struct Delayed {
    std::int64_t due_ns = 0;
    DeviceFrame frame;
  };

  void start(std::int64_t now_ns);
  void spin_up(std::int64_t now_ns);
  void release(std::int64_t now_ns);
  void shake_hands(std::int64_t now_ns, const Endpoint& from, const livox::ControlFrame& frame,
                   std::vector<DeviceFrame>& out);
  [[nodiscard]] std::optional<livox::ControlPayload> answer(std::int64_t now_ns, const livox::ControlPayload& request);
  [[nodiscard]] livox::HeartbeatAck heartbeat(std::int64_t now_ns) const;
  [[nodiscard]] std::optional<livox::ControlPayload> switch_power(std::int64_t now_ns, livox::PowerMode mode);
  void send(std::int64_t now_ns, const Endpoint& to, std::vector<std::uint8_t> bytes, std::vector<DeviceFrame>& out);
  [[nodiscard]] bool happens(double share) { return share > 0.0 && random_.uniform() < share; }

  VirtualLivoxOptions options_;
  VirtualSettings settings_;
  DeviceTime time_;
  Random random_;
  std::optional<Owner> owner_;
  bool is_owned_by_other_ = false;
  bool is_sampling_ = false;
  bool is_dark_ = true;
  livox::WorkState work_state_ = livox::WorkState::initialising;
  std::uint32_t status_ = 0;
  std::uint16_t message_seq_ = 0;
  std::int64_t booted_ns_ = 0;
  std::int64_t dark_until_ns_ = 0;
  std::int64_t spun_up_ns_ = 0;
  std::int64_t silent_until_ns_ = INT64_MIN;
  std::int64_t heartbeat_ns_ = 0;
  std::int64_t broadcast_due_ns_ = 0;
  std::int64_t status_due_ns_ = 0;
  std::optional<std::int64_t> reboot_due_ns_;
  std::set<livox::Command> refused_;
  std::vector<Delayed> delayed_;
};

}  // namespace rigcal::sim
