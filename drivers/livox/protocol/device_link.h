#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "drivers/livox/protocol/events.h"
#include "drivers/livox/protocol/settings.h"

namespace rigcal::livox {

/// Where the host stands with a device.
enum class LinkState : std::uint8_t {
  waiting,      ///< For a broadcast.
  handshaking,  ///< The handshake is on its way.
  identifying,  ///< Taken; asks for the firmware.
  preparing,    ///< Waits for the work state that is wanted.
  configuring,  ///< Sends the settings, one by one.
  resting,      ///< In standby or power saving, as wanted.
  idle,         ///< Set up, not sampling.
  sampling,
  leaving,  ///< Stops sampling and disconnects.
  closed,
};
[[nodiscard]] const char* to_string(LinkState state);

/// How often and how long. The device's own limit without a heartbeat is about 5 s.
constexpr std::int64_t kHeartbeatPeriodNs = 800'000'000;
/// While the last one is not answered: five may get lost before the device is.
constexpr std::int64_t kHeartbeatRetryNs = 400'000'000;
constexpr std::int64_t kSilenceNs = 3'000'000'000;
constexpr std::int64_t kAnswerNs = 500'000'000;
constexpr int kAttempts = 3;
constexpr std::int64_t kPowerRetryNs = 5'000'000'000;
constexpr std::int64_t kSamplingRetryNs = 1'000'000'000;
/// Until a setting that was not answered is asked for again; what the user asks comes first.
constexpr std::int64_t kSettingRetryNs = 1'000'000'000;
/// A broadcast of a connected device counts when no heartbeat was answered for this long; before, it is a late one.
constexpr std::int64_t kLetGoNs = 1'200'000'000;
/// Leaving takes no longer.
constexpr std::int64_t kLeaveNs = 1'000'000'000;
constexpr std::size_t kMaxRequests = 16;

/// An address of this host and the ports that devices are told.
struct HostAddress {
  Ipv4 ip{};
  Ipv4 mask{255, 255, 255, 0};
  std::uint16_t command_port = 0;
  std::uint16_t data_port = 0;
  std::uint16_t imu_port = 0;
};

/// A device that the host is to take: known by its code, or where that is empty by its address.
struct WantedDevice {
  std::string broadcast_code;
  std::optional<Ipv4> ip;
  DeviceSettings settings;
  bool sampling = true;
  PowerMode power = PowerMode::normal;
};

struct LinkCounters {
  std::uint64_t handshakes = 0;
  std::uint64_t losses = 0;
  std::uint64_t interruptions = 0;  ///< Times that sampling ended though nobody here wanted it to; also by losses.
  std::uint64_t repeated = 0;       ///< Requests sent again.
  std::uint64_t stray_acks = 0;     ///< That answer nothing: late, twice, or with a wrong number.
  std::uint64_t unreadable = 0;     ///< Acks and messages whose payload makes no sense.
  std::uint64_t refused_heartbeats = 0;
  std::uint64_t utc_taken = 0;    ///< Times of day that the device took,
  std::uint64_t utc_refused = 0;  ///< and that it did not.
};

/// A wanted setting that is not in force.
struct MissingSetting {
  std::string setting;  ///< See `setting_text`.
  Outcome outcome = Outcome::refused;
};

/// What is known of a device.
struct LinkInfo {
  LinkState state = LinkState::waiting;
  Broadcast broadcast;  ///< Of the last handshake; the wanted code before.
  Ipv4 ip{};
  FirmwareVersion firmware{};
  WorkState work_state = WorkState::initialising;
  std::uint32_t progress_percent = 0;  ///< While initialising.
  std::uint8_t features = 0;
  std::uint32_t status = 0;
  /// As far as they were asked for; without those that a device meets which does not know them.
  std::vector<MissingSetting> missing_settings;
  LinkCounters counters;
};

/// The host's end of the connection with one device. Times are of any monotonic clock.
class DeviceLink {
 public:
  DeviceLink(std::size_t index, WantedDevice wanted);

  [[nodiscard]] const LinkInfo& info() const { return info_; }
  [[nodiscard]] const WantedDevice& wanted() const { return wanted_; }
  [[nodiscard]] bool is_connected() const;
  /// Whether frames from `info().ip` are for this link.
  [[nodiscard]] bool is_addressed() const { return is_connected() || info_.state == LinkState::handshaking; }

  void receive_broadcast(std::int64_t now_ns, const Broadcast& broadcast, const Endpoint& from, const HostAddress& host,
                         std::size_t host_index, ProtocolOutput& out);
  /// A frame from the device's address.
  void receive_frame(std::int64_t now_ns, const ControlFrame& frame, ProtocolOutput& out);
  void tick(std::int64_t now_ns, ProtocolOutput& out);
  /// When `tick` has something to do; nothing while only the device can go on.
  [[nodiscard]] std::optional<std::int64_t> deadline_ns() const;

  /// Tells a device that has a pulse a second (PPS) what time it was at the last one; the others nothing. One that is
  /// lost is not repeated: the next second has its own.
  void tell_utc(std::int64_t unix_ns, ProtocolOutput& out);
  /// Errors: no device, not its kind of request, too many waiting.
  Expected<void> request(std::int64_t now_ns, ControlPayload request, ProtocolOutput& out);
  void set_sampling(std::int64_t now_ns, bool on, ProtocolOutput& out);
  void set_power(std::int64_t now_ns, PowerMode mode, ProtocolOutput& out);
  /// Stops and frees the device, for good.
  void leave(std::int64_t now_ns, ProtocolOutput& out);

 private:
  enum class Purpose : std::uint8_t { identify, power, setup, sampling, user, leave };
  struct Exchange {
    Purpose purpose = Purpose::user;
    Command command = Command::heartbeat;
    std::uint16_t seq = 0;
    int attempts_left = 0;
    std::int64_t due_ns = 0;
    std::vector<std::uint8_t> bytes;
    std::size_t step = 0;  ///< Of `setup_`, where that is the purpose.
  };
  struct SetupStep {
    ControlPayload request;
    Outcome outcome = Outcome::done;  ///< The last one.
  };

  [[nodiscard]] std::uint16_t next_seq();
  void shake_hands(std::int64_t now_ns, ProtocolOutput& out);
  void take_handshake_ack(std::int64_t now_ns, const ControlPayload& payload, ProtocolOutput& out);
  void take_heartbeat_ack(std::int64_t now_ns, const HeartbeatAck& ack, ProtocolOutput& out);
  void take_ack(std::int64_t now_ns, const ControlFrame& frame, ProtocolOutput& out);
  void note_status(std::int64_t now_ns, std::uint32_t word, ProtocolOutput& out);
  [[nodiscard]] bool is_own_heartbeat(std::uint16_t seq);
  [[nodiscard]] bool is_wanted_work_state() const;

  void start(std::int64_t now_ns, const ControlPayload& request, Purpose purpose, ProtocolOutput& out);
  void finish(std::int64_t now_ns, Outcome outcome, ControlPayload answer, ProtocolOutput& out);
  void finish_request(std::int64_t now_ns, const Exchange& exchange, Outcome outcome, ProtocolOutput& out);
  void identify(std::int64_t now_ns, const DeviceInformationAck& ack, ProtocolOutput& out);
  void start_setting(std::int64_t now_ns, std::size_t step, ProtocolOutput& out);
  bool retry_setting(std::int64_t now_ns, ProtocolOutput& out);
  void finish_setting(std::int64_t now_ns, const Exchange& exchange, Outcome outcome, ControlPayload answer,
                      ProtocolOutput& out);
  void list_missing_settings();
  void advance(std::int64_t now_ns, ProtocolOutput& out);
  bool advance_once(std::int64_t now_ns, ProtocolOutput& out);
  void prepare(std::int64_t now_ns, bool is_wanted, ProtocolOutput& out);
  void end_sampling(std::int64_t now_ns, bool is_wanted, ProtocolOutput& out);
  void lose(std::int64_t now_ns, LossCause cause, ProtocolOutput& out);
  void close(std::int64_t now_ns, ProtocolOutput& out);
  void send(const Endpoint& to, std::vector<std::uint8_t> bytes, ProtocolOutput& out) const;
  void tell(std::int64_t now_ns, EventContent content, ProtocolOutput& out) const;

  std::size_t index_;
  WantedDevice wanted_;
  LinkInfo info_;
  HostAddress host_;
  std::size_t host_index_ = 0;
  Endpoint broadcast_from_;
  std::uint16_t seq_ = 0;

  std::uint16_t handshake_seq_ = 0;
  bool tries_other_form_ = false;  ///< Of the handshake than the model's usual one.
  std::int64_t handshake_due_ns_ = 0;
  std::optional<std::int64_t> last_handshake_ns_;
  std::int64_t life_ns_ = 0;  ///< Of the handshake's or the last heartbeat's ack.
  std::int64_t heartbeat_due_ns_ = 0;
  std::array<std::optional<std::uint16_t>, 4> heartbeats_{};  ///< Numbers not answered yet, newest first.

  std::optional<std::uint16_t> utc_seq_;  ///< Of the last time of day, until it is answered.
  std::optional<Exchange> exchange_;
  std::vector<SetupStep> setup_;
  std::size_t setup_step_ = 0;
  std::size_t retry_step_ = 0;  ///< Where the next setting that was not answered is looked for.
  std::int64_t setting_due_ns_ = 0;
  std::deque<ControlPayload> requests_;
  bool sampling_asked_ = false;
  std::int64_t sampling_due_ns_ = 0;
  std::int64_t power_due_ns_ = 0;
  int leave_step_ = 0;
  std::int64_t leave_end_ns_ = 0;
};

}  // namespace rigcal::livox
