#include "drivers/net/udp_socket.h"

#include <arpa/inet.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "core/base/seconds.h"
#include "core/base/system_call.h"
#include "drivers/net/port_holders.h"

namespace rigcal::net {
namespace {

sockaddr_in to_address(const Endpoint& endpoint) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(endpoint.port);
  std::memcpy(&address.sin_addr, endpoint.ip.data(), endpoint.ip.size());
  return address;
}

Endpoint to_endpoint(const sockaddr_in& address) {
  Endpoint endpoint;
  std::memcpy(endpoint.ip.data(), &address.sin_addr, endpoint.ip.size());
  endpoint.port = ntohs(address.sin_port);
  return endpoint;
}

bool set_option(int descriptor, int level, int name, int value) {
  return setsockopt(descriptor, level, name, &value, sizeof value) == 0;
}

// Keeps the socket to the interface of that name.
bool bind_to(int descriptor, const std::string& interface) {
  return setsockopt(descriptor, SOL_SOCKET, SO_BINDTODEVICE, interface.c_str(),
                    static_cast<socklen_t>(interface.size())) == 0;
}

// 0: there is none of that name.
int interface_number(int descriptor, const std::string& interface) {
  ifreq request{};
  if (interface.size() >= sizeof request.ifr_name) return 0;
  std::memcpy(request.ifr_name, interface.data(), interface.size());
  return ioctl(descriptor, SIOCGIFINDEX, &request) == 0 ? request.ifr_ifindex : 0;
}

Error socket_error(const std::string& what, const Endpoint& local, std::string mend) {
  return call_error(what, errno, "UDP " + to_string(local), std::move(mend));
}

std::string mend_of_bind(int error) {
  switch (error) {
    case EADDRINUSE:
      return "another program has the port: end it (`ss -lunp` shows which)";
    case EADDRNOTAVAIL:
      return "no interface of this machine has that address: set it, or take another one (`ip addr` shows them)";
    case EACCES:
      return "take a port above 1023";
    default:
      return {};
  }
}

Expected<void> set_up(int descriptor, const UdpOptions& options) {
  if (options.reuse_address && !set_option(descriptor, SOL_SOCKET, SO_REUSEADDR, 1))
    return socket_error("cannot share the port", options.local, {});
  if (options.broadcast && !set_option(descriptor, SOL_SOCKET, SO_BROADCAST, 1))
    return socket_error("cannot broadcast", options.local, {});
  if (!set_option(descriptor, SOL_SOCKET, SO_TIMESTAMPNS, 1) ||
      (options.tell_destination && !set_option(descriptor, IPPROTO_IP, IP_PKTINFO, 1)))
    return socket_error("the system gives no stamps or addresses of datagrams", options.local, {});
  if (!options.interface.empty() && !bind_to(descriptor, options.interface))
    return socket_error("cannot bind to the interface '" + options.interface + "'", options.local,
                        errno == ENODEV ? "there is no such interface (`ip link` lists them)"
                                        : "this needs CAP_NET_RAW: leave the interface away, or give the capability");
  if (options.receive_bytes > 0) {
    const int bytes = static_cast<int>(std::min<std::size_t>(options.receive_bytes, 1U << 30U));
    // The first one may go beyond the system's limit and needs a privilege; how much was given is asked afterwards.
    if (!set_option(descriptor, SOL_SOCKET, SO_RCVBUFFORCE, bytes))
      static_cast<void>(set_option(descriptor, SOL_SOCKET, SO_RCVBUF, bytes));
  }
  return {};
}

// No room now, nobody who listens, or a datagram too long for the way there: lost, as on any network.
bool is_loss(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == ENOBUFS || error == ECONNREFUSED || error == EINTR ||
         error == EMSGSIZE;
}

constexpr std::size_t control_bytes = 128;  // Stamp and address information take 64.

}  // namespace

struct ReceiveBatch::Buffers {
  explicit Buffers(std::size_t count)
      : bytes(count * kDatagramBytes),
        control(count),
        from(count),
        parts(count),
        headers(count),
        received(count),
        size(count) {
    for (std::size_t i = 0; i < count; ++i) {
      parts[i] = {bytes.data() + i * kDatagramBytes, kDatagramBytes};
      msghdr& header = headers[i].msg_hdr;
      header.msg_name = &from[i];
      header.msg_iov = &parts[i];
      header.msg_iovlen = 1;
      header.msg_control = control[i].bytes;
    }
    prepare();
  }

  // The kernel has written into those of the last batch only.
  void prepare() {
    for (std::size_t i = 0; i < size; ++i) {
      headers[i].msg_hdr.msg_namelen = sizeof(sockaddr_in);
      headers[i].msg_hdr.msg_controllen = control_bytes;
      headers[i].msg_hdr.msg_flags = 0;
    }
    size = 0;
  }

  struct Control {
    alignas(cmsghdr) std::uint8_t bytes[control_bytes];
  };
  std::vector<std::uint8_t> bytes;
  std::vector<Control> control;
  std::vector<sockaddr_in> from;
  std::vector<iovec> parts;
  std::vector<mmsghdr> headers;
  std::vector<Received> received;
  std::size_t size;
};

ReceiveBatch::ReceiveBatch(std::size_t datagrams) : buffers_(std::make_unique<Buffers>(datagrams)) {}
ReceiveBatch::~ReceiveBatch() = default;
ReceiveBatch::ReceiveBatch(ReceiveBatch&&) noexcept = default;
ReceiveBatch& ReceiveBatch::operator=(ReceiveBatch&&) noexcept = default;
std::size_t ReceiveBatch::capacity() const { return buffers_->headers.size(); }
std::size_t ReceiveBatch::size() const { return buffers_->size; }
const Received& ReceiveBatch::operator[](std::size_t index) const { return buffers_->received[index]; }

Expected<UdpSocket> UdpSocket::open(const UdpOptions& options) {
  UdpSocket made;
  made.socket_ = FileDescriptor(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!made.socket_.is_open()) return socket_error("cannot make a socket", options.local, {});
  if (const auto set = set_up(made.socket_.get(), options); !set) return set.error();
  sockaddr_in address = to_address(options.local);
  if (bind(made.socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    Error error = socket_error("cannot listen", options.local, mend_of_bind(errno));
    const std::vector<PortHolder> holders =
        errno == EADDRINUSE ? port_holders(options.local.port) : std::vector<PortHolder>{};
    if (!holders.empty()) error.what += " (" + holders_text(holders) + ")";
    return error;
  }
  socklen_t size = sizeof address;
  if (getsockname(made.socket_.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0)
    return socket_error("cannot tell the port", options.local, {});
  made.local_ = to_endpoint(address);
  made.interface_ = options.interface;
  made.interface_number_ = interface_number(made.socket_.get(), options.interface);
  int bytes = 0;
  size = sizeof bytes;
  if (getsockopt(made.socket_.get(), SOL_SOCKET, SO_RCVBUF, &bytes, &size) == 0)
    made.receive_bytes_ = static_cast<std::size_t>(bytes) / 2;  // The kernel doubles it for its own book-keeping.
  return made;
}

Expected<std::size_t> UdpSocket::receive(ReceiveBatch& batch) {
  ReceiveBatch::Buffers& buffers = *batch.buffers_;
  buffers.prepare();
  const int count = recvmmsg(socket_.get(), buffers.headers.data(), static_cast<unsigned>(buffers.headers.size()),
                             MSG_DONTWAIT, nullptr);
  if (count < 0) {
    // A port that nobody listens on any more comes back as an error of the next call: that is news, not a fault.
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR || errno == ECONNREFUSED) {
      count_drops();
      return std::size_t{0};
    }
    return socket_error("cannot receive", local_, "look at the network interface");
  }
  buffers.size = static_cast<std::size_t>(count);
  count_drops();
  for (std::size_t i = 0; i < buffers.size; ++i) {
    msghdr& header = buffers.headers[i].msg_hdr;
    Received& received = buffers.received[i];
    received.realtime_ns = 0;
    received.from = to_endpoint(buffers.from[i]);
    received.to = local_;
    received.truncated = (header.msg_flags & MSG_TRUNC) != 0;
    received.bytes = {static_cast<const std::uint8_t*>(buffers.parts[i].iov_base), buffers.headers[i].msg_len};
    for (cmsghdr* part = CMSG_FIRSTHDR(&header); part != nullptr; part = CMSG_NXTHDR(&header, part)) {
      if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SCM_TIMESTAMPNS) {
        timespec stamp{};
        std::memcpy(&stamp, CMSG_DATA(part), sizeof stamp);
        received.realtime_ns = static_cast<std::int64_t>(stamp.tv_sec) * ns_per_second + stamp.tv_nsec;
      } else if (part->cmsg_level == IPPROTO_IP && part->cmsg_type == IP_PKTINFO) {
        in_pktinfo info{};
        std::memcpy(&info, CMSG_DATA(part), sizeof info);
        std::memcpy(received.to.ip.data(), &info.ipi_addr, received.to.ip.size());
        std::memcpy(received.local_ip.data(), &info.ipi_spec_dst, received.local_ip.size());
        received.interface = info.ipi_ifindex;
      }
    }
  }
  return buffers.size;
}

// Once a batch, and also where nothing came: SO_RXQ_OVFL would cost something for each datagram and tell of the last
// drops only with the next one.
void UdpSocket::count_drops() {
  std::uint32_t figures[SK_MEMINFO_VARS] = {};
  socklen_t size = sizeof figures;
  if (getsockopt(socket_.get(), SOL_SOCKET, SO_MEMINFO, figures, &size) != 0 || size < sizeof figures) return;
  dropped_ += figures[SK_MEMINFO_DROPS] - kernel_drops_;  // Of 32 bits: it wraps, and the difference with it.
  kernel_drops_ = figures[SK_MEMINFO_DROPS];
}

Error UdpSocket::send_error(const Endpoint& to) const {
  return socket_error("cannot send to " + to_string(to), local_,
                      errno == ENETUNREACH || errno == EHOSTUNREACH
                          ? "no interface leads there: give one an address in that network"
                          : "look at the network interface and the firewall");
}

Expected<bool> UdpSocket::send(const Endpoint& to, ByteView bytes) const {
  const sockaddr_in address = to_address(to);
  const ssize_t sent = sendto(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                              reinterpret_cast<const sockaddr*>(&address), sizeof address);
  if (sent == static_cast<ssize_t>(bytes.size())) return true;
  if (is_loss(errno)) return false;
  return send_error(to);
}

Expected<std::size_t> UdpSocket::send_all(std::span<const Parts> datagrams) const {
  constexpr std::size_t most = 64;
  std::array<mmsghdr, most> headers{};
  std::array<std::array<iovec, 2>, most> parts{};
  std::array<sockaddr_in, most> addresses{};
  std::size_t taken = 0;
  std::size_t at = 0;
  while (at < datagrams.size()) {
    const std::size_t count = std::min(most, datagrams.size() - at);
    for (std::size_t i = 0; i < count; ++i) {
      const Parts& datagram = datagrams[at + i];
      addresses[i] = to_address(datagram.to);
      const auto part = [](ByteView bytes) { return iovec{const_cast<std::uint8_t*>(bytes.data()), bytes.size()}; };
      parts[i] = {part(datagram.head), part(datagram.body)};
      msghdr& header = headers[i].msg_hdr;
      header.msg_name = &addresses[i];
      header.msg_namelen = sizeof addresses[i];
      header.msg_iov = parts[i].data();
      header.msg_iovlen = parts[i].size();
    }
    const int sent = sendmmsg(socket_.get(), headers.data(), static_cast<unsigned>(count), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && !is_loss(errno)) return send_error(datagrams[at].to);
    // It stops before the first one that it does not take.
    taken += static_cast<std::size_t>(std::max(sent, 0));
    at += static_cast<std::size_t>(std::max(sent, 1));
  }
  return taken;
}

bool UdpSocket::follow_interface() {
  if (interface_.empty()) return false;
  const int number = interface_number(socket_.get(), interface_);
  if (number == 0 || number == interface_number_ || !bind_to(socket_.get(), interface_)) return false;
  interface_number_ = number;
  return true;
}

void UdpSocket::set_do_not_fragment(bool refuse) const {
  static_cast<void>(set_option(socket_.get(), IPPROTO_IP, IP_MTU_DISCOVER, refuse ? IP_PMTUDISC_DO : IP_PMTUDISC_DONT));
}

}  // namespace rigcal::net
