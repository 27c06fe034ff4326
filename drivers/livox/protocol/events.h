#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/records/records.h"
#include "drivers/livox_codec/control_payload.h"

/// What the protocol hands out: frames to send and events.
namespace rigcal::livox {

/// A device has spoken for the first time, or from another address than before.
struct Seen {
  Broadcast broadcast;
  Ipv4 ip{};
};
/// A device that is wanted has an address that the host's interface cannot reach.
struct Unreachable {
  Broadcast broadcast;
  Ipv4 ip{};
};
/// A device that is wanted broadcasts where this host does not listen for packets.
struct HeardElsewhere {
  Broadcast broadcast;
  Ipv4 ip{};
  std::string interface;
};
/// Another device (this one) speaks from the address of the connected one.
struct AddressConflict {
  Broadcast broadcast;
  Ipv4 ip{};
};
/// The device does not take this host: another one has it.
struct HandshakeRefused {};
struct HandshakeUnanswered {};
struct Connected {
  DeviceType type = DeviceType::avia;
  FirmwareVersion firmware{};
  Ipv4 ip{};
};
struct WorkStateChanged {
  WorkState before = WorkState::initialising;
  WorkState now = WorkState::initialising;
};
struct StatusChanged {
  std::uint32_t before = 0;
  std::uint32_t now = 0;
};
struct SamplingChanged {
  bool on = false;
};

enum class Outcome : std::uint8_t {
  done,
  switching,    ///< The motor spins up or down; the work state tells when it is done.
  refused,      ///< `answer` says why, where the device did.
  unsupported,  ///< The model or its firmware cannot do it; it was not asked.
  unanswered,   ///< After all attempts.
  lost,         ///< The device went away meanwhile.
};
/// What became of a request: one of the settings, a start or stop of sampling, or one that the user made.
struct RequestEnded {
  Command command = Command::heartbeat;
  Outcome outcome = Outcome::done;
  ControlPayload answer;  ///< A RawControl without payload where there is none.
  /// The setting that is not in force because of this, or (`done`) is after all; empty where nothing changed in that.
  std::string setting{};
};

enum class LossCause : std::uint8_t {
  silence,       ///< No heartbeat was answered for three seconds.
  let_go,        ///< It looks for a host again: it has restarted, or has not heard this one.
  rebooting,     ///< As it was told to.
  disconnected,  ///< As it was told to.
};
struct Lost {
  LossCause cause = LossCause::silence;
};
/// The device was given free; nothing more comes of it.
struct Closed {};

using EventContent =
    std::variant<Seen, Unreachable, HeardElsewhere, AddressConflict, HandshakeRefused, HandshakeUnanswered, Connected,
                 WorkStateChanged, StatusChanged, SamplingChanged, RequestEnded, Lost, Closed>;

constexpr std::size_t kNoDevice = SIZE_MAX;

struct Event {
  std::int64_t stamp_ns = 0;
  std::size_t device = kNoDevice;  ///< Index in the list of wanted ones.
  EventContent content;
};

/// A frame that the caller has to send from the command port of that host address.
struct OutgoingFrame {
  std::size_t host = 0;
  Endpoint to;
  std::vector<std::uint8_t> bytes;
};

/// What calls on the protocol append to; the caller empties it.
struct ProtocolOutput {
  std::vector<OutgoingFrame> frames;
  std::vector<Event> events;

  void clear() {
    frames.clear();
    events.clear();
  }
};

[[nodiscard]] const char* to_string(Outcome outcome);
[[nodiscard]] const char* to_string(LossCause cause);
[[nodiscard]] const char* to_string(WorkState state);

/// That a setting (see `setting_text`) is not in force, for which it was asked with this outcome; and what to do then.
[[nodiscard]] std::string missing_text(const std::string& setting, Outcome outcome);
[[nodiscard]] std::string mend_of_missing(Outcome outcome);

/// A sentence for a log, without the device's name.
[[nodiscard]] std::string event_text(const EventContent& content);

}  // namespace rigcal::livox
