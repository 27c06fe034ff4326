#include "drivers/livox/device/receiver.h"

#include <time.h>

#include <algorithm>
#include <utility>

namespace rigcal::livox {
namespace {

constexpr std::size_t batch_datagrams = 128;
constexpr int most_batches = 64;  // At once: a flood must not keep the thread from hearing that it is to stop.
constexpr std::int64_t clock_period_ns = 100'000'000;
constexpr std::int64_t pause_after_error_ns = 10'000'000;
constexpr std::int64_t shortest_pause_ns = 250'000;
constexpr std::size_t kernel_bytes_of_a_packet = 2304;  // What a full one takes of a socket's buffer, with its head.

void pause_for(std::int64_t nanoseconds) {
  const timespec pause{0, nanoseconds};
  nanosleep(&pause, nullptr);
}

}  // namespace

std::int64_t gathering_pause_ns(std::int64_t pause_ns, std::size_t came, std::size_t room) {
  if (came > room / 3) return pause_ns / 2 < shortest_pause_ns ? 0 : pause_ns / 2;
  if (came < room / 8) return std::clamp(2 * pause_ns, shortest_pause_ns, kLongestPauseNs);
  return pause_ns;
}

Expected<std::unique_ptr<Receiver>> Receiver::open(const net::UdpOptions& options, const Senders& senders,
                                                   const net::ClockReading& session_start,
                                                   std::size_t queue_datagrams) {
  auto socket = net::UdpSocket::open(options);
  if (!socket) return socket.error();
  auto waiter = net::Waiter::create({socket->descriptor()});
  if (!waiter) return waiter.error();
  return std::unique_ptr<Receiver>(
      new Receiver(*std::move(socket), *std::move(waiter), senders, session_start, queue_datagrams));
}

Receiver::Receiver(net::UdpSocket socket, net::Waiter waiter, const Senders& senders,
                   const net::ClockReading& session_start, std::size_t queue_datagrams)
    : socket_(std::move(socket)),
      waiter_(std::move(waiter)),
      senders_(senders),
      clock_(session_start),
      empty_since_ns_(session_start.monotonic_ns),
      batch_(batch_datagrams),
      ring_(queue_datagrams),
      // The kernel gives twice what it says.
      room_(std::min(2 * socket_.receive_bytes() / kernel_bytes_of_a_packet, ring_.capacity())),
      pause_ns_(kLongestPauseNs),
      heartbeat_("receiving at " + rigcal::to_string(socket_.local().ip)) {}

void Receiver::prepare() {
  if (is_prepared_.load()) return;
  ring_.take_memory();
  is_prepared_.store(true);
}

bool Receiver::receive_some(std::int64_t timeout_ns) {
  heartbeat_.beat();
  if (timeout_ns > 0) {
    if (is_flowing_ && pause_ns_ > 0) {
      pause_for(std::min(pause_ns_, timeout_ns));
    } else if (const net::ClockReading before = read_clocks(); !waiter_.wait(timeout_ns) || !waiter_.is_ready(0)) {
      empty_since_ns_ = before.monotonic_ns;
      socket_.follow_interface();
      return false;
    }
  }
  net::ClockReading now = read_clocks();
  std::size_t total = 0;
  for (int i = 0; i < most_batches; ++i) {
    const std::int64_t asked_ns = now.monotonic_ns;
    const auto count = socket_.receive(batch_);
    if (!count) {
      // The interface may come back; without a pause this thread would do nothing but fail.
      errors_.fetch_add(1, std::memory_order_relaxed);
      pause_for(pause_after_error_ns);
      return total > 0;
    }
    now = read_clocks();
    queue(*count, now);
    total += *count;
    if (*count < batch_.capacity()) {
      empty_since_ns_ = asked_ns;
      break;
    }
  }
  kernel_drops_.store(socket_.dropped(), std::memory_order_relaxed);
  is_flowing_ = total > 0;
  if (is_flowing_) pause_ns_ = gathering_pause_ns(pause_ns_, total, room_);
  return is_flowing_;
}

net::ClockReading Receiver::read_clocks() {
  const net::ClockReading now = net::read_clocks();
  if (now.monotonic_ns - clock_.latest().monotonic_ns >= clock_period_ns || clock_.has_stepped(now)) clock_.update(now);
  return now;
}

void Receiver::queue(std::size_t count, const net::ClockReading& now) {
  const bool is_prepared = is_prepared_.load();
  for (std::size_t i = 0; i < count; ++i) {
    const net::Received& received = batch_[i];
    const std::size_t device = senders_.find(received.from.ip);
    if (device == kNoDevice || !is_prepared) {
      strangers_.fetch_add(1, std::memory_order_relaxed);
      continue;
    }
    const std::int64_t stamp_ns = clock_.from_recent_realtime(received.realtime_ns, now, empty_since_ns_);
    if (!ring_.push({stamp_ns, received.from, received.to, received.bytes})) continue;
    received_.fetch_add(1, std::memory_order_relaxed);
    DeviceTraffic& traffic = traffic_[device];
    traffic.packets.fetch_add(1, std::memory_order_relaxed);
    traffic.bytes.fetch_add(received.bytes.size(), std::memory_order_relaxed);
    traffic.last_ns.store(stamp_ns, std::memory_order_relaxed);
  }
}

ReceiverCounters Receiver::counters() const {
  return {received_.load(std::memory_order_relaxed), kernel_drops_.load(std::memory_order_relaxed), ring_.dropped(),
          strangers_.load(std::memory_order_relaxed), errors_.load(std::memory_order_relaxed)};
}

}  // namespace rigcal::livox
