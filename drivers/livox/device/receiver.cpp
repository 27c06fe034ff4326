#include "drivers/livox/device/receiver.h"

#include <time.h>

#include <utility>

namespace rigcal::livox {
namespace {

constexpr std::size_t batch_datagrams = 128;
constexpr std::int64_t clock_period_ns = 100'000'000;
constexpr std::int64_t pause_after_error_ns = 10'000'000;
// At low rates packets are let gather: the kernel has stamped them, and a wake-up for each costs more than all the
// rest. Even the smallest buffer holds three times as many as may come meanwhile, or they are no longer few.
constexpr std::size_t few_datagrams = 32;
constexpr std::int64_t pause_at_low_rates_ns = 1'500'000;

void pause_for(std::int64_t nanoseconds) {
  const timespec pause{0, nanoseconds};
  nanosleep(&pause, nullptr);
}

}  // namespace

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
      batch_(batch_datagrams),
      ring_(queue_datagrams) {}

void Receiver::receive_some(std::int64_t timeout_ns) {
  if (!waiter_.wait(timeout_ns) || !waiter_.is_ready(0)) return;
  const net::ClockReading now = net::read_clocks();
  if (now.monotonic_ns - clock_.latest().monotonic_ns >= clock_period_ns) clock_.update(now);
  std::size_t total = 0;
  while (true) {
    const auto count = socket_.receive(batch_);
    if (!count) {
      // The interface may come back; without a pause this thread would do nothing but fail.
      errors_.fetch_add(1, std::memory_order_relaxed);
      return pause_for(pause_after_error_ns);
    }
    for (std::size_t i = 0; i < *count; ++i) {
      const net::Received& received = batch_[i];
      const std::size_t device = senders_.find(received.from.ip);
      if (device == kNoDevice) {
        strangers_.fetch_add(1, std::memory_order_relaxed);
        continue;
      }
      const std::int64_t stamp_ns = clock_.from_realtime(received.realtime_ns);
      if (!ring_.push({stamp_ns, received.from, received.to, received.bytes})) continue;
      received_.fetch_add(1, std::memory_order_relaxed);
      DeviceTraffic& traffic = traffic_[device];
      traffic.packets.fetch_add(1, std::memory_order_relaxed);
      traffic.bytes.fetch_add(received.bytes.size(), std::memory_order_relaxed);
      traffic.last_ns.store(stamp_ns, std::memory_order_relaxed);
    }
    kernel_drops_.store(socket_.dropped(), std::memory_order_relaxed);
    total += *count;
    if (*count < batch_.capacity()) break;
  }
  if (timeout_ns > 0 && total < few_datagrams) pause_for(pause_at_low_rates_ns);
}

ReceiverCounters Receiver::counters() const {
  return {received_.load(std::memory_order_relaxed), kernel_drops_.load(std::memory_order_relaxed), ring_.dropped(),
          strangers_.load(std::memory_order_relaxed), errors_.load(std::memory_order_relaxed)};
}

}  // namespace rigcal::livox
