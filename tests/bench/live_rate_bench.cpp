// What it costs to receive live LiDARs on loopback, and what gets lost: live_rate_bench [TIMES] [SECONDS]
// [BUFFER_BYTES] Load 1: an AVIA (240 000 points/s) and three MID-40s (100 000 each) in 5500 packets a second. Another
// process sends.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "drivers/livox/device/receiver.h"
#include "drivers/livox_codec/sample_packet.h"

namespace {

using namespace rigcal;
using Clock = std::chrono::steady_clock;

struct Stream {
  std::uint8_t last_number;  // Of its address.
  livox::DataType type;
  double packets_per_s;
};
constexpr Stream streams[] = {{179, livox::DataType::cartesian_tagged, 2500.0},
                              {21, livox::DataType::cartesian, 1000.0},
                              {91, livox::DataType::cartesian, 1000.0},
                              {161, livox::DataType::cartesian, 1000.0}};

net::UdpSocket open(const net::UdpOptions& options) {
  auto socket = net::UdpSocket::open(options);
  if (socket) return *std::move(socket);
  std::fprintf(stderr, "%s\n", socket.error().message().c_str());
  std::exit(4);
}

// Sends for some seconds; how many packets left comes back through the pipe.
void send_all(const Endpoint& to, double times, double seconds, int report) {
  std::vector<net::UdpSocket> sockets;
  std::vector<std::vector<std::uint8_t>> packets;
  for (const Stream& stream : streams) {
    net::UdpOptions options;
    options.local = {{127, 0, 0, stream.last_number}, 0};
    sockets.push_back(open(options));
    livox::SampleHeader header;
    header.data_type = stream.type;
    std::vector<Point> points(livox::record_layout(stream.type).slots);
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] = {10.0F, 1.0F, 0.5F, 40, 16, static_cast<std::uint16_t>(i)};
    livox::encode_points(header, points, packets.emplace_back());
  }
  std::uint64_t sent = 0;
  std::vector<std::uint64_t> by_stream(sockets.size(), 0);
  const auto start = Clock::now();
  for (double now = 0.0; now < seconds;) {
    now = std::chrono::duration<double>(Clock::now() - start).count();
    for (std::size_t i = 0; i < sockets.size(); ++i) {
      const auto due = static_cast<std::uint64_t>(now * streams[i].packets_per_s * times);
      for (; by_stream[i] < due; ++by_stream[i]) {
        const auto done = sockets[i].send(to, packets[i]);
        if (done && *done) ++sent;
      }
    }
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  if (write(report, &sent, sizeof sent) != sizeof sent) std::exit(1);
  std::exit(0);
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

int main(int argc, char** argv) {
  const double times = argc > 1 ? std::atof(argv[1]) : 1.0;
  const double seconds = argc > 2 ? std::atof(argv[2]) : 10.0;
  const std::size_t buffer = argc > 3 ? static_cast<std::size_t>(std::atol(argv[3])) : 8U << 20U;
  livox::Senders senders;
  for (std::size_t i = 0; i < std::size(streams); ++i) senders.set(i, {127, 0, 0, streams[i].last_number});
  net::UdpOptions options;
  options.local = {{127, 0, 0, 1}, 0};
  options.receive_bytes = buffer;
  auto opened = livox::Receiver::open(options, senders, net::read_clocks(), 1U << 14U);
  if (!opened) {
    std::fprintf(stderr, "%s\n", opened.error().message().c_str());
    return 4;
  }
  livox::Receiver& receiver = **opened;
  int report[2];
  if (pipe(report) != 0) return 4;
  const pid_t sender = fork();
  if (sender == 0) send_all(receiver.socket().local(), times, seconds, report[1]);
  const double cpu_before = cpu_seconds();
  std::atomic<bool> running{true};
  std::thread receiving([&] {
    while (running) receiver.receive_some(100'000'000);
    receiver.receive_some(0);
  });
  std::uint64_t points = 0;
  std::uint64_t taken = 0;
  std::vector<Point> decoded;
  const auto take = [&] {
    Datagram datagram;
    for (; receiver.ring().peek(datagram); receiver.ring().pop(), ++taken) {
      const auto packet = livox::parse_sample_packet(datagram.bytes);
      if (!packet) continue;
      livox::decode_points(*packet, decoded);
      points += decoded.size();
    }
  };
  int status = 0;
  while (waitpid(sender, &status, WNOHANG) == 0) {
    take();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  running = false;
  receiver.wake();
  receiving.join();
  take();
  const double cpu = cpu_seconds() - cpu_before;
  std::uint64_t sent = 0;
  if (read(report[0], &sent, sizeof sent) != sizeof sent) return 1;
  const livox::ReceiverCounters counters = receiver.counters();
  std::printf(
      "%.0f times, %.0f s, buffer %zu KiB: sent %llu, received %llu, dropped by the kernel %llu, by the queue "
      "%llu, not accounted for %lld; %.2f M points, %.4f CPU s per million points, queue at most %zu of %zu\n",
      times, seconds, receiver.socket().receive_bytes() / 1024, static_cast<unsigned long long>(sent),
      static_cast<unsigned long long>(taken), static_cast<unsigned long long>(counters.dropped_by_kernel),
      static_cast<unsigned long long>(counters.dropped_by_queue),
      static_cast<long long>(sent) -
          static_cast<long long>(taken + counters.dropped_by_kernel + counters.dropped_by_queue),
      1e-6 * static_cast<double>(points), cpu / (1e-6 * static_cast<double>(points)), receiver.ring().high_water(),
      receiver.ring().capacity());
  return 0;
}
