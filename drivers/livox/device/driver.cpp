#include "drivers/livox/device/driver.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "drivers/livox/device/host_choice.h"
#include "drivers/net/privileges.h"
#include "drivers/net/socket_limits.h"

namespace rigcal::livox {
namespace {

constexpr std::int64_t receive_wait_ns = 100'000'000;
constexpr std::int64_t longest_take_wait_ns = 50'000'000;

}  // namespace

Expected<std::unique_ptr<Driver>> Driver::start(const DriverOptions& options) {
  std::unique_ptr<Driver> driver(new Driver);
  driver->options_ = options;
  const auto interfaces = net::list_interfaces();
  if (!interfaces) return interfaces.error();
  auto hosts = choose_hosts(*interfaces, options.devices, options.interface, options.host_ip);
  if (!hosts) return hosts.error();
  driver->hosts_ = *std::move(hosts);
  driver->session_start_ = net::read_clocks();
  std::vector<std::uint16_t> data_ports;
  for (const net::Interface& host : driver->hosts_) {
    if (!host.is_up)
      driver->notes_.push_back(host.name +
                               " has no carrier yet; LiDARs behind it are waited for: plug the cable in and " +
                               "switch on what is at its other end, or: sudo ip link set " + host.name + " up");
    net::UdpOptions socket;
    socket.local = {host.ip, 0};
    socket.receive_bytes = options.receive_bytes;
    socket.tell_destination = false;  // It listens at one address.
    if (options.bind_to_interface) socket.interface = host.name;
    auto receiver = Receiver::open(socket, driver->senders_, driver->session_start_, options.queue_datagrams);
    if (!receiver) return receiver.error();
    const net::UdpSocket& opened = (*receiver)->socket();
    if (opened.receive_bytes() < options.receive_bytes)
      driver->notes_.push_back(host.name + ": " +
                               net::receive_buffer_hint(options.receive_bytes, opened.receive_bytes()));
    data_ports.push_back(opened.local().port);
    driver->receivers_.push_back(*std::move(receiver));
  }
  const auto prepare = [of = driver.get()](std::size_t host) { of->receivers_[host]->prepare(); };
  auto control = ControlLoop::open({driver->hosts_, std::move(data_ports), options.devices, options.discovery_port,
                                    options.bind_to_interface, driver->session_start_, options.send_utc, prepare},
                                   driver->senders_);
  if (!control) return control.error();
  driver->control_ = *std::move(control);
  if (options.lock_memory) {
    if (std::string refusal = net::lock_memory(); !refusal.empty()) driver->notes_.push_back(std::move(refusal));
  }
  driver->thread_notes_.resize(driver->receivers_.size());
  driver->is_running_ = true;
  driver->is_receiving_ = true;
  Driver& running = *driver;
  for (std::size_t i = 0; i < running.receivers_.size(); ++i)
    running.threads_.emplace_back([&running, i] { running.run_receiver(i); });
  while (running.started_ < running.receivers_.size()) std::this_thread::yield();
  for (std::string& note : running.thread_notes_)
    if (!note.empty()) running.notes_.push_back(std::move(note));
  running.control_thread_ = std::thread([&running] {
    net::name_thread("livox-control");
    running.control_->run();
  });
  return driver;
}

void Driver::run_receiver(std::size_t index) {
  net::name_thread("livox-receive");
  if (options_.realtime) thread_notes_[index] = net::become_realtime();
  ++started_;
  while (is_receiving_.load(std::memory_order_relaxed))
    if (receivers_[index]->receive_some(receive_wait_ns)) doorbell_.ring();
  receivers_[index]->receive_some(0);  // What came while the devices were being freed.
  receivers_[index]->heartbeat().rest();
}

Driver::~Driver() { stop(); }

void Driver::stop() {
  if (control_thread_.joinable()) {
    control_->leave();
    control_thread_.join();
  }
  is_receiving_ = false;
  for (const auto& receiver : receivers_) receiver->wake();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  is_running_ = false;  // From now on nothing is added to the queues.
}

bool Driver::take_oldest(Datagram& datagram) {
  const auto take = [&](DatagramRing& ring) {
    Datagram candidate;
    if (!ring.peek(candidate)) return;
    if (taken_from_ != nullptr && candidate.stamp_ns >= datagram.stamp_ns) return;
    datagram = candidate;
    taken_from_ = &ring;
  };
  take(control_->ring());
  for (const auto& receiver : receivers_) take(receiver->ring());
  return taken_from_ != nullptr;
}

bool Driver::next(Datagram& datagram, std::int64_t timeout_ns) {
  if (taken_from_ != nullptr) taken_from_->pop();
  taken_from_ = nullptr;
  if (take_oldest(datagram)) return true;
  const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(timeout_ns);
  while (true) {
    const bool was_running = is_running_.load();
    doorbell_.listen();
    if (take_oldest(datagram)) {
      doorbell_.hush();
      return true;
    }
    const std::chrono::nanoseconds left = end - std::chrono::steady_clock::now();
    if (!was_running || left.count() <= 0) {
      doorbell_.hush();
      return false;
    }
    // Control frames do not ring, and neither does the end.
    doorbell_.wait(std::min<std::int64_t>(left.count(), longest_take_wait_ns));
  }
}

std::vector<DeviceReport> Driver::devices() const {
  std::vector<DeviceReport> reports;
  for (LinkInfo& link : control_->links()) {
    DeviceReport report;
    report.link = std::move(link);
    for (const auto& receiver : receivers_) {
      const DeviceTraffic& traffic = receiver->traffic(reports.size());
      report.packets += traffic.packets.load(std::memory_order_relaxed);
      report.bytes += traffic.bytes.load(std::memory_order_relaxed);
      report.last_packet_ns = std::max(report.last_packet_ns, traffic.last_ns.load(std::memory_order_relaxed));
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

std::vector<InterfaceReport> Driver::interfaces() const {
  std::vector<InterfaceReport> reports;
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    Receiver& receiver = *receivers_[i];
    reports.push_back({hosts_[i], receiver.socket().receive_bytes(), receiver.ring().high_water(),
                       receiver.ring().capacity(), receiver.counters()});
  }
  return reports;
}

std::vector<const Heartbeat*> Driver::heartbeats() const {
  std::vector<const Heartbeat*> beats{&control_->heartbeat()};
  for (const auto& receiver : receivers_) beats.push_back(&receiver->heartbeat());
  return beats;
}

std::vector<std::string> Driver::notes() const { return notes_; }

}  // namespace rigcal::livox
