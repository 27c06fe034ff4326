#include "drivers/livox/device/control_loop.h"

#include <algorithm>
#include <utility>

#include "core/base/seconds.h"
#include "drivers/livox/device/host_choice.h"

namespace rigcal::livox {
namespace {

constexpr std::size_t control_queue = 4096;
constexpr std::size_t control_batch = 32;
constexpr std::int64_t longest_wait_ns = 1'000'000'000;
constexpr std::int64_t utc_wait_ns = 100'000'000;  // Where the time of day is to be told: no second may be missed.
// Devices take a time 10 to 500 ms after its pulse; with some room for the way.
constexpr std::int64_t soonest_utc_ns = 50'000'000;
constexpr std::int64_t latest_utc_ns = 400'000'000;

}  // namespace

Expected<std::unique_ptr<ControlLoop>> ControlLoop::open(Wiring wiring, Senders& senders) {
  net::UdpOptions options;
  options.reuse_address = true;  // Broadcasts reach every program that listens.
  options.local = {{0, 0, 0, 0}, wiring.discovery_port};
  auto discovery = net::UdpSocket::open(options);
  if (!discovery) return discovery.error();
  std::vector<net::UdpSocket> commands;
  std::vector<int> descriptors{discovery->descriptor()};
  std::vector<HostAddress> hosts;
  for (std::size_t i = 0; i < wiring.hosts.size(); ++i) {
    options = {};
    options.local = {wiring.hosts[i].ip, 0};
    if (wiring.bind_to_interface) options.interface = wiring.hosts[i].name;
    auto command = net::UdpSocket::open(options);
    if (!command) return command.error();
    const std::uint16_t data_port = wiring.data_ports[i];
    hosts.push_back({wiring.hosts[i].ip, wiring.hosts[i].mask, command->local().port, data_port, data_port});
    descriptors.push_back(command->descriptor());
    commands.push_back(*std::move(command));
  }
  auto waiter = net::Waiter::create(descriptors);
  if (!waiter) return waiter.error();
  auto protocol = HostProtocol::create(std::move(hosts), wiring.devices);
  if (!protocol) return protocol.error();
  return std::unique_ptr<ControlLoop>(new ControlLoop(std::move(wiring), senders, *std::move(protocol),
                                                      *std::move(discovery), std::move(commands), *std::move(waiter)));
}

ControlLoop::ControlLoop(Wiring wiring, Senders& senders, HostProtocol protocol, net::UdpSocket discovery,
                         std::vector<net::UdpSocket> commands, net::Waiter waiter)
    : wiring_(std::move(wiring)),
      senders_(senders),
      protocol_(std::move(protocol)),
      discovery_(std::move(discovery)),
      commands_(std::move(commands)),
      waiter_(std::move(waiter)),
      batch_(control_batch),
      clock_(wiring_.session_start),
      ring_(control_queue),
      prepared_(wiring_.hosts.size()) {}

void ControlLoop::run() {
  while (true) {
    heartbeat_.beat();
    std::int64_t wait_ns = longest_wait_ns;
    {
      const std::lock_guard lock(mutex_);
      if (protocol_.is_closed()) break;
      if (const auto deadline = protocol_.deadline_ns())
        wait_ns = std::clamp<std::int64_t>(*deadline - monotonic_now_ns(), 0, longest_wait_ns);
    }
    waiter_.wait(wiring_.send_utc ? std::min(wait_ns, utc_wait_ns) : wait_ns);
    const std::lock_guard lock(mutex_);
    const net::ClockReading now = net::read_clocks();
    clock_.update(now);
    if (now.monotonic_ns - followed_ns_ >= longest_wait_ns) follow_interfaces(now.monotonic_ns);
    if (waiter_.is_ready(0)) hear(discovery_, std::nullopt);
    for (std::size_t i = 0; i < commands_.size(); ++i)
      if (waiter_.is_ready(i + 1)) hear(commands_[i], i);
    protocol_.tick(now.monotonic_ns, output_);
    if (wiring_.send_utc) tell_utc(now);
    hand_out();
  }
  heartbeat_.rest();
}

void ControlLoop::follow_interfaces(std::int64_t now_ns) {
  followed_ns_ = now_ns;
  for (net::UdpSocket& socket : commands_) socket.follow_interface();
}

// Pulses of GPS receivers and masters of time come with the full seconds of UTC, and so do those of a host that makes
// them itself by its clock.
void ControlLoop::tell_utc(const net::ClockReading& now) {
  const std::int64_t second = now.realtime_ns / ns_per_second;
  const std::int64_t since_pulse_ns = now.realtime_ns % ns_per_second;
  if (second == utc_told_s_ || since_pulse_ns < soonest_utc_ns || since_pulse_ns > latest_utc_ns) return;
  utc_told_s_ = second;
  protocol_.tell_utc(second * ns_per_second, output_);
}

void ControlLoop::hear(net::UdpSocket& socket, std::optional<std::size_t> host) {
  const auto count = socket.receive(batch_);
  if (!count) {  // The interface is down; heartbeats tell what comes of it.
    ++counted_.receive_errors;
    return;
  }
  for (std::size_t i = 0; i < *count; ++i) {
    const net::Received& received = batch_[i];
    const std::size_t at = host ? *host : host_of(wiring_.hosts, received);
    const net::ClockReading& now = clock_.latest();
    if (at >= wiring_.hosts.size()) {
      protocol_.receive_elsewhere(now.monotonic_ns, net::interface_name(received.interface), received.from,
                                  received.bytes, output_);
      continue;
    }
    ring_.push({clock_.from_recent_realtime(received.realtime_ns, now), received.from, received.to, received.bytes});
    protocol_.receive(now.monotonic_ns, at, received.from, received.bytes, output_);
  }
}

// Sends what the protocol wants to be sent and keeps its events.
void ControlLoop::hand_out() {
  for (const OutgoingFrame& frame : output_.frames) {
    if (!prepared_[frame.host] && wiring_.prepare) wiring_.prepare(frame.host);
    prepared_[frame.host] = true;
    const net::UdpSocket& socket = commands_[frame.host];
    const auto sent = socket.send(frame.to, frame.bytes);
    // One that could not be sent is like one that got lost: it is repeated.
    if (!sent || !*sent) {
      ++(sent ? counted_.unsent : counted_.send_errors);
      continue;
    }
    ring_.push({clock_.from_monotonic(clock_.latest().monotonic_ns), socket.local(), frame.to, frame.bytes});
  }
  for (Event& event : output_.events) {
    event.stamp_ns = clock_.from_monotonic(event.stamp_ns);
    if (events_.size() >= kMostEvents) {
      events_.pop_front();
      ++counted_.lost_events;
    }
    events_.push_back(std::move(event));
  }
  output_.clear();
  for (std::size_t i = 0; i < protocol_.device_count(); ++i) {
    const LinkState state = protocol_.device(i).state;
    const bool is_ours = state != LinkState::waiting && state != LinkState::handshaking && state != LinkState::closed;
    // It stays so afterwards: packets may wait in the socket, and what a lost device still sends is of use.
    if (is_ours) senders_.set(i, protocol_.device(i).ip);
  }
}

template <class Call>
auto ControlLoop::with_protocol(const Call& call) {
  const std::lock_guard lock(mutex_);
  const net::ClockReading now = net::read_clocks();
  clock_.update(now);
  auto result = call(now.monotonic_ns);
  hand_out();
  waiter_.wake();
  return result;
}

void ControlLoop::leave() {
  with_protocol([this](std::int64_t now_ns) {
    protocol_.leave(now_ns, output_);
    return 0;
  });
}

Expected<void> ControlLoop::request(std::size_t device, ControlPayload request) {
  return with_protocol(
      [&](std::int64_t now_ns) { return protocol_.request(now_ns, device, std::move(request), output_); });
}

void ControlLoop::set_sampling(std::size_t device, bool on) {
  with_protocol([&](std::int64_t now_ns) {
    protocol_.set_sampling(now_ns, device, on, output_);
    return 0;
  });
}

void ControlLoop::set_power(std::size_t device, PowerMode mode) {
  with_protocol([&](std::int64_t now_ns) {
    protocol_.set_power(now_ns, device, mode, output_);
    return 0;
  });
}

std::vector<Event> ControlLoop::take_events() {
  const std::lock_guard lock(mutex_);
  std::vector<Event> taken(std::make_move_iterator(events_.begin()), std::make_move_iterator(events_.end()));
  events_.clear();
  return taken;
}

std::vector<LinkInfo> ControlLoop::links() const {
  const std::lock_guard lock(mutex_);
  std::vector<LinkInfo> links;
  for (std::size_t i = 0; i < protocol_.device_count(); ++i) links.push_back(protocol_.device(i));
  return links;
}

std::vector<Sighting> ControlLoop::sightings() const {
  const std::lock_guard lock(mutex_);
  return protocol_.sightings();
}

ControlCounters ControlLoop::counters() const {
  const std::lock_guard lock(mutex_);
  ControlCounters counters = counted_;
  counters.protocol = protocol_.counters();
  counters.dropped_by_kernel = discovery_.dropped();
  for (const net::UdpSocket& socket : commands_) counters.dropped_by_kernel += socket.dropped();
  return counters;
}

}  // namespace rigcal::livox
