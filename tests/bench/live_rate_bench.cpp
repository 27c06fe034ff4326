// What it costs to receive live LiDARs on loopback, and what gets lost:
// live_rate_bench [TIMES] [SECONDS] [BUFFER_BYTES] [count | decode | record | one_by_one]
// Load 1: an AVIA (240 000 points/s) and three MID-40s (100 000 each) in 5500 packets a second. Another process sends
// and is not counted. `count` takes each packet and counts its points, as the vendor's figures were taken; `decode`
// makes points of them; `record` writes them to a file; `one_by_one` is how the vendor's SDK receives, for comparison
// on the same machine: epoll, one datagram each time it wakes up.
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/io/pcapng_writer.h"
#include "drivers/livox/device/doorbell.h"
#include "drivers/livox/device/receiver.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/bench/cpu_seconds.h"

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

std::uint64_t points_of(ByteView packet) {
  const auto parsed = livox::parse_sample_packet(packet);
  if (!parsed) return 0;
  const livox::RecordLayout& layout = livox::record_layout(parsed->header.data_type);
  return std::uint64_t{layout.slots} * layout.echoes;
}

/// What is done with each packet.
class Taker {
 public:
  explicit Taker(const std::string& way) : decodes_(way == "decode") {
    if (way != "record") return;
    path_ =
        (std::filesystem::temp_directory_path() / ("live_rate_bench_" + std::to_string(getpid()) + ".pcapng")).string();
    auto writer = PcapngWriter::create(path_);
    if (!writer) std::exit(4);
    writer_ = *std::move(writer);
  }
  ~Taker() {
    if (writer_) std::filesystem::remove(path_);
  }
  Taker(const Taker&) = delete;
  Taker& operator=(const Taker&) = delete;

  void take_all(livox::DatagramRing& ring) {
    for (Datagram datagram; ring.peek(datagram); ring.pop(), ++packets) {
      points += points_of(datagram.bytes);
      if (writer_ && !writer_->write(datagram)) std::exit(4);
      if (!decodes_) continue;
      const auto packet = livox::parse_sample_packet(datagram.bytes);
      if (packet) livox::decode_points(*packet, decoded_);
    }
  }

  std::uint64_t packets = 0;
  std::uint64_t points = 0;

 private:
  bool decodes_;
  std::string path_;
  std::optional<PcapngWriter> writer_;
  std::vector<Point> decoded_;
};

/// Sends from another process; the count comes back at its end.
class Sender {
 public:
  Sender(const Endpoint& to, double times, double seconds) {
    if (pipe(report_) != 0) std::exit(4);
    process_ = fork();
    if (process_ == 0) send_all(to, times, seconds, report_[1]);
  }
  [[nodiscard]] bool is_done() {
    int status = 0;
    return waitpid(process_, &status, WNOHANG) != 0;
  }
  [[nodiscard]] std::uint64_t sent() const {
    std::uint64_t count = 0;
    if (read(report_[0], &count, sizeof count) != sizeof count) std::exit(1);
    return count;
  }

 private:
  int report_[2] = {};
  pid_t process_ = 0;
};

int receive_one_by_one(double times, double seconds, std::size_t buffer) {
  net::UdpOptions options;
  options.local = {{127, 0, 0, 1}, 0};
  options.receive_bytes = buffer;
  const net::UdpSocket socket = open(options);
  const int off = 0;
  setsockopt(socket.descriptor(), SOL_SOCKET, SO_TIMESTAMPNS, &off, sizeof off);
  setsockopt(socket.descriptor(), IPPROTO_IP, IP_PKTINFO, &off, sizeof off);
  const int poll = epoll_create1(EPOLL_CLOEXEC);
  epoll_event wanted{EPOLLIN, {}};
  epoll_ctl(poll, EPOLL_CTL_ADD, socket.descriptor(), &wanted);
  Sender sender(socket.local(), times, seconds);
  const double cpu_before = cpu_seconds();
  std::vector<std::uint8_t> bytes(8192);
  std::uint64_t received = 0;
  std::uint64_t points = 0;
  while (true) {
    epoll_event event{};
    const bool ready = epoll_wait(poll, &event, 1, 50) > 0;
    if (!ready && sender.is_done()) break;
    if (!ready) continue;
    sockaddr_storage from{};
    socklen_t size = sizeof from;
    const ssize_t got =
        recvfrom(socket.descriptor(), bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (got > 0) points += points_of(ByteView(bytes).first(static_cast<std::size_t>(got)));
    if (got > 0) ++received;
  }
  const double cpu = cpu_seconds() - cpu_before;
  std::printf(
      "%.0f times, %.0f s, one by one: sent %llu, received %llu; %.2f M points, %.4f CPU s per million points\n", times,
      seconds, static_cast<unsigned long long>(sender.sent()), static_cast<unsigned long long>(received),
      1e-6 * static_cast<double>(points), cpu / (1e-6 * static_cast<double>(points)));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const double times = argc > 1 ? std::atof(argv[1]) : 1.0;
  const double seconds = argc > 2 ? std::atof(argv[2]) : 10.0;
  const std::size_t buffer = argc > 3 ? static_cast<std::size_t>(std::atol(argv[3])) : 8U << 20U;
  const std::string way = argc > 4 ? argv[4] : "count";
  if (way == "one_by_one") return receive_one_by_one(times, seconds, buffer);
  livox::Senders senders;
  for (std::size_t i = 0; i < std::size(streams); ++i) senders.set(i, {127, 0, 0, streams[i].last_number});
  net::UdpOptions options;
  options.local = {{127, 0, 0, 1}, 0};
  options.receive_bytes = buffer;
  options.tell_destination = false;
  auto opened = livox::Receiver::open(options, senders, net::read_clocks(), 1U << 14U);
  if (!opened) {
    std::fprintf(stderr, "%s\n", opened.error().message().c_str());
    return 4;
  }
  livox::Receiver& receiver = **opened;
  receiver.prepare();
  Taker taker(way);
  Sender sender(receiver.socket().local(), times, seconds);
  const double cpu_before = cpu_seconds();
  std::atomic<bool> running{true};
  livox::Doorbell doorbell;
  std::thread receiving([&] {
    while (running)
      if (receiver.receive_some(100'000'000)) doorbell.ring();
    receiver.receive_some(0);
  });
  while (!sender.is_done()) {  // As Driver::next does.
    taker.take_all(receiver.ring());
    doorbell.listen();
    Datagram more;
    if (receiver.ring().peek(more)) {
      doorbell.hush();
    } else {
      doorbell.wait(50'000'000);
    }
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  running = false;
  receiver.wake();
  receiving.join();
  taker.take_all(receiver.ring());
  const double cpu = cpu_seconds() - cpu_before;
  const std::uint64_t sent = sender.sent();
  const livox::ReceiverCounters counters = receiver.counters();
  std::printf(
      "%.0f times, %.0f s, %s, buffer %zu KiB: sent %llu, received %llu, dropped by the kernel %llu, by the queue "
      "%llu, not accounted for %lld; %.2f M points, %.4f CPU s per million points, queue at most %zu of %zu\n",
      times, seconds, way.c_str(), receiver.socket().receive_bytes() / 1024, static_cast<unsigned long long>(sent),
      static_cast<unsigned long long>(taker.packets), static_cast<unsigned long long>(counters.dropped_by_kernel),
      static_cast<unsigned long long>(counters.dropped_by_queue),
      static_cast<long long>(sent) -
          static_cast<long long>(taker.packets + counters.dropped_by_kernel + counters.dropped_by_queue),
      1e-6 * static_cast<double>(taker.points), cpu / (1e-6 * static_cast<double>(taker.points)),
      receiver.ring().high_water(), receiver.ring().capacity());
  return 0;
}
