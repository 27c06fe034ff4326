#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/error.h"
#include "core/base/file_descriptor.h"
#include "core/records/records.h"

namespace rigcal::net {

struct UdpOptions {
  Endpoint local;                 ///< Address 0.0.0.0: any. Port 0: the system chooses.
  bool reuse_address = false;     ///< Several programs may listen on the port; needed for broadcasts.
  bool broadcast = false;         ///< May send to broadcast addresses.
  std::size_t receive_bytes = 0;  ///< Receive buffer; 0: as the system has it.
  std::string interface;          ///< Only from and to this interface (SO_BINDTODEVICE); empty: any.
  /// Tell of each datagram how it was addressed and where it came in. Without, all count as sent to `local`, which is
  /// what they are where that is an address, and cheaper.
  bool tell_destination = true;
};

/// A datagram as it came. `bytes` lives until the batch is used again.
struct Received {
  std::int64_t realtime_ns = 0;  ///< When the kernel had it, CLOCK_REALTIME.
  Endpoint from;
  Endpoint to;                             ///< As it was addressed: a broadcast keeps its address.
  std::array<std::uint8_t, 4> local_ip{};  ///< Of the interface that it came in on, where that is told.
  int interface = 0;                       ///< The system's number of that interface, where it is told.
  bool truncated = false;                  ///< Longer than the batch's buffers.
  ByteView bytes;
};

/// Buffers for datagrams that are received at once. All memory is asked for when it is made.
class ReceiveBatch {
 public:
  static constexpr std::size_t kDatagramBytes = 2048;  ///< No Livox datagram is longer than 1400.

  explicit ReceiveBatch(std::size_t datagrams);
  ~ReceiveBatch();
  ReceiveBatch(ReceiveBatch&&) noexcept;
  ReceiveBatch& operator=(ReceiveBatch&&) noexcept;

  [[nodiscard]] std::size_t capacity() const;
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] const Received& operator[](std::size_t index) const;

 private:
  friend class UdpSocket;
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

/// A datagram to be sent.
struct Parts {
  Endpoint to;
  ByteView head;
  ByteView body;
};

/// A bound, non-blocking UDP socket with kernel stamps and the kernel's count of drops.
class UdpSocket {
 public:
  /// Errors (kind system): the port is taken, no such address or interface, no permission.
  [[nodiscard]] static Expected<UdpSocket> open(const UdpOptions& options);

  [[nodiscard]] int descriptor() const { return socket_.get(); }
  [[nodiscard]] const Endpoint& local() const { return local_; }
  /// What the system has given, which may be less than what was asked for.
  [[nodiscard]] std::size_t receive_bytes() const { return receive_bytes_; }

  /// What is there now, at most a batch; 0 where nothing is. Errors: the interface is gone.
  Expected<std::size_t> receive(ReceiveBatch& batch);
  /// False where the system has no room now, nobody listens or it is too long for the way there; the datagram is lost
  /// then, as on any network. Errors: no way there, no permission.
  Expected<bool> send(const Endpoint& to, ByteView bytes) const;

  /// Hands over many datagrams at once, each of two parts that lie behind one another on the wire. Returns how many the
  /// system has taken; the rest is lost as with `send`. Errors: as of `send`.
  Expected<std::size_t> send_all(std::span<const Parts> datagrams) const;
  /// Whether datagrams that are too long for the network are refused rather than sent in fragments. Best effort.
  void set_do_not_fragment(bool refuse) const;

  /// An adapter that is plugged in anew has its name again, but another number by the system, and a socket that was
  /// bound to it stays bound to the old one: this binds it to the new one. Whether there was one, and the system let
  /// it. Asks the system each time; nothing where no interface was named.
  bool follow_interface();

  /// Datagrams that the kernel had to throw away because the buffer was full, until the last `receive`.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  UdpSocket() = default;
  /// Of the call that has just failed.
  [[nodiscard]] Error send_error(const Endpoint& to) const;
  void count_drops();

  FileDescriptor socket_;
  Endpoint local_;
  std::string interface_;
  int interface_number_ = 0;
  std::size_t receive_bytes_ = 0;
  std::uint32_t kernel_drops_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace rigcal::net
