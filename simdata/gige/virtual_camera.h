#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/seconds.h"
#include "core/records/records.h"
#include "drivers/gige_codec/ack.h"
#include "simdata/gige/camera_registers.h"
#include "simdata/gige/exposure_schedule.h"
#include "simdata/gige/frame_source.h"

namespace rigcal::sim {

/// Where packets go, and how.
struct StreamTarget {
  Endpoint to;
  std::uint32_t packet_bytes = 1500;  ///< With the headers of IP and UDP.
  bool do_not_fragment = true;
  std::int64_t packet_delay_ns = 0;
};

/// A frame that the camera has exposed, without its pixels.
struct FrameOrder {
  std::uint16_t block = 0;
  std::uint64_t number = 0;   ///< Since the acquisition began, from 0.
  std::int64_t start_ns = 0;  ///< Of the exposure, in the clock of the calls.
  std::uint64_t ticks = 0;    ///< The same on the camera's clock.
  std::optional<std::int64_t> pulse;
  CameraSettings settings;

  /// The pulse that the camera gives on an output line while it exposes; nothing where its strobe is off.
  [[nodiscard]] std::optional<LinePulse> strobe(std::uint32_t line) const;
  /// What its pixels are made by.
  [[nodiscard]] FrameWish wish() const;
};

/// What the camera wants to be done.
struct CameraOutput {
  struct Answer {
    Endpoint to;
    std::vector<std::uint8_t> bytes;
  };
  std::vector<Answer> answers;               ///< From its control port.
  std::vector<FrameOrder> frames;            ///< To be sent on the stream.
  std::vector<gige::ResendRequest> resends;  ///< Packets to be sent once more.
  std::optional<StreamTarget> test_packet;   ///< To be sent once, as large as it says.
  std::optional<gige::Ipv4> new_address;     ///< It is to live there from now on.
  bool is_stream_closed = false;             ///< Nothing more is to be sent of what waits.

  void clear() { *this = {}; }
};

/// A GigE Vision camera as its firmware behaves: answers discoveries, lets one host at a time control it, frees itself
/// when the heartbeats stop, keeps registers and features, exposes by itself or for each trigger. A pure state machine:
/// datagrams, pulses and time (any monotonic clock) in; answers and exposed frames out. Pixels and packets are made by
/// others.
class VirtualCamera {
 public:
  /// Switched on at `now_ns`; `stream_port` is where its packets come from.
  VirtualCamera(const VirtualCameraOptions& options, std::uint16_t stream_port, std::int64_t now_ns);

  /// A datagram to port 3956; any bytes are safe.
  void receive(std::int64_t now_ns, const Endpoint& from, ByteView bytes, CameraOutput& out);
  void tick(std::int64_t now_ns, CameraOutput& out);
  /// When `tick` has something to do next.
  [[nodiscard]] std::int64_t deadline_ns() const;
  /// A pulse that has begun on one of its lines.
  void pulse(const LinePulse& pulse);
  /// How bright a frame was, 0 .. 1 on average, for the exposure's automatic.
  void meter(std::int64_t now_ns, double mean);

  [[nodiscard]] bool is_acquiring() const { return schedule_.is_running(); }
  [[nodiscard]] const std::optional<Endpoint>& owner() const { return owner_; }
  [[nodiscard]] StreamTarget stream() const;
  [[nodiscard]] CameraSettings settings() const { return registers_.settings(); }
  [[nodiscard]] const gige::Ipv4& ip() const { return options_.identity.ip; }
  [[nodiscard]] std::uint64_t ignored_triggers() const { return schedule_.ignored(); }
  /// Whether its host wants to know which packets are sent again.
  [[nodiscard]] bool marks_resent() const {
    return (registers_.memory().value(gige::bootstrap::kControlConfiguration) & gige::kExtendedStatus) != 0;
  }
  void set_stream_port(std::uint16_t port);
  /// What its clock reads.
  [[nodiscard]] std::uint64_t ticks(std::int64_t now_ns) const;

  // Faults that are asked for.
  void reboot(std::int64_t now_ns, CameraOutput& out);
  /// Hears and says nothing until then; whoever makes its packets has to keep still, too.
  void fall_silent(std::int64_t until_ns) { silent_until_ns_ = until_ns; }
  [[nodiscard]] bool is_silent(std::int64_t now_ns) const {
    return now_ns < dark_until_ns_ || now_ns < silent_until_ns_;
  }
  /// Another host has it (or lets it go).
  void set_owned_by_other(bool owned, CameraOutput& out);

 private:
  struct Delayed {
    std::int64_t due_ns = 0;
    CameraOutput::Answer answer;
  };
  struct Done {  ///< The last command that changed something: it may come twice, but must not be done twice.
    Endpoint from;
    std::uint16_t id = 0;
    std::int64_t time_ns = 0;
    std::vector<std::uint8_t> command;
    std::vector<std::uint8_t> ack;
  };

  void start(std::int64_t now_ns);
  /// When it frees itself for want of a heartbeat.
  [[nodiscard]] std::int64_t owner_until_ns() const;
  void release(CameraOutput& out);
  void stop_acquisition(CameraOutput& out);
  [[nodiscard]] bool may_read(const Endpoint& from) const;
  [[nodiscard]] bool may_write(const Endpoint& from) const { return owner_ == from; }
  void answer(std::int64_t now_ns, const Endpoint& to, std::uint16_t id, std::vector<std::uint8_t> bytes,
              CameraOutput& out);
  [[nodiscard]] std::vector<std::uint8_t> serve(std::int64_t now_ns, const Endpoint& from,
                                                const gige::CommandFrame& frame, const gige::Request& request,
                                                CameraOutput& out);
  [[nodiscard]] std::vector<std::uint8_t> read_registers(const Endpoint& from, const gige::CommandFrame& frame,
                                                         const gige::ReadRegistersRequest& request) const;
  [[nodiscard]] std::vector<std::uint8_t> write_registers(std::int64_t now_ns, const Endpoint& from,
                                                          const gige::CommandFrame& frame,
                                                          const gige::WriteRegistersRequest& request,
                                                          CameraOutput& out);
  [[nodiscard]] std::vector<std::uint8_t> read_memory(const Endpoint& from, const gige::CommandFrame& frame,
                                                      const gige::ReadMemoryRequest& request) const;
  [[nodiscard]] std::vector<std::uint8_t> write_memory(std::int64_t now_ns, const Endpoint& from,
                                                       const gige::CommandFrame& frame,
                                                       const gige::WriteMemoryRequest& request, CameraOutput& out);
  [[nodiscard]] gige::Status write_word(std::int64_t now_ns, const Endpoint& from, std::uint32_t address,
                                        std::uint32_t value, CameraOutput& out);
  [[nodiscard]] gige::Status write_privilege(const Endpoint& from, std::uint32_t value, CameraOutput& out);
  [[nodiscard]] gige::Status write_packet_size(std::uint32_t value, CameraOutput& out);
  [[nodiscard]] gige::Status do_command(std::int64_t now_ns, Feature feature);
  void control_timestamp(std::int64_t now_ns, std::uint32_t value);
  [[nodiscard]] std::int64_t answer_delay_ns() const { return whole_ns_of_seconds(options_.answer_delay_s); }

  VirtualCameraOptions options_;
  std::uint16_t stream_port_ = 0;
  CameraRegisters registers_;
  ExposureSchedule schedule_;
  std::optional<Endpoint> owner_;
  bool is_exclusive_ = false;
  bool is_owned_by_other_ = false;
  std::int64_t heard_ns_ = 0;  ///< From the owner.
  std::int64_t booted_ns_ = 0;
  std::int64_t clock_zero_ns_ = 0;  ///< When its clock read zero, of its own time before `booted_ns_`.
  std::int64_t dark_until_ns_ = INT64_MIN;
  std::int64_t silent_until_ns_ = INT64_MIN;
  std::optional<std::int64_t> reset_due_ns_;
  std::uint16_t block_ = 1;
  std::uint64_t number_ = 0;
  std::vector<Delayed> delayed_;
  std::optional<Done> done_;
};

}  // namespace rigcal::sim
