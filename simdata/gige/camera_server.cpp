#include "simdata/gige/camera_server.h"

#include <algorithm>
#include <deque>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include "core/base/seconds.h"
#include "drivers/gige_codec/pixel_code.h"
#include "drivers/net/udp_socket.h"
#include "drivers/net/waiter.h"
#include "simdata/gige/brightness.h"
#include "simdata/gige/camera_sockets.h"

namespace rigcal::sim {
namespace {

constexpr std::int64_t shortest_wait_ns = 250'000;  // Packets leave in small groups, not one by one.
constexpr std::int64_t longest_wait_ns = 100'000'000;
constexpr std::int64_t source_wait_ns = 2'000'000;  // Until a frame that is not made yet is asked for again.
constexpr std::int64_t pulse_ns = 1'000'000;        // Of a datagram.
constexpr std::size_t most_waiting = 16;            // Frames whose pixels are not there yet.
constexpr std::size_t most_pulses = 1U << 16U;
constexpr std::size_t group = 64;

struct Unit {
  ServedCamera served;
  net::UdpSocket control;
  net::UdpSocket stream;
  VirtualCamera camera;
  StreamSender sender;
  std::deque<FrameOrder> waiting;
  CameraCounts counts;
};

Expected<std::unique_ptr<Unit>> open_unit(ServedCamera served, std::uint64_t seed) {
  const gige::Ipv4 ip = served.device.identity.ip;
  auto control = open_socket(ip, gige::kControlPort);
  if (!control) return control.error();
  auto stream = open_socket(ip, 0);
  if (!stream) return stream.error();
  VirtualCamera camera(served.device, stream->local().port, monotonic_now_ns());
  StreamSender sender(served.faults, served.device.link_bits_per_s, seed);
  return std::make_unique<Unit>(
      Unit{std::move(served), *std::move(control), *std::move(stream), std::move(camera), std::move(sender), {}, {}});
}

}  // namespace

class CameraServer::Impl {
 public:
  Impl(std::vector<std::unique_ptr<Unit>> units, std::vector<net::UdpSocket> broadcasts,
       std::vector<net::UdpSocket> triggers, net::Waiter waiter, const CameraServerOptions& options)
      : options_(options),
        units_(std::move(units)),
        broadcasts_(std::move(broadcasts)),
        triggers_(std::move(triggers)),
        waiter_(std::move(waiter)),
        batch_(64),
        thread_([this](const std::stop_token& stop) { run(stop); }) {}

  ~Impl() {
    thread_.request_stop();
    const std::lock_guard lock(mutex_);
    waiter_.wake();
  }

  template <class Work>
  void with_unit(std::size_t camera, const Work& work) {
    const std::lock_guard lock(mutex_);
    RIGCAL_ASSERT(camera < units_.size(), "a camera that is not served");
    work(*units_[camera]);
    waiter_.wake();
  }

  void pulse(const LinePulse& pulse) {
    const std::lock_guard lock(mutex_);
    add_pulse(pulse);
    waiter_.wake();
  }

  std::vector<CameraCounts> counts() const {
    const std::lock_guard lock(mutex_);
    std::vector<CameraCounts> all;
    for (const auto& unit : units_) {
      CameraCounts counts = unit->counts;
      counts.stream = unit->sender.counts();
      counts.ignored_triggers = unit->camera.ignored_triggers();
      counts.is_owned = unit->camera.owner().has_value();
      counts.is_acquiring = unit->camera.is_acquiring();
      counts.is_idle = unit->waiting.empty() && unit->sender.deadline_ns() == INT64_MAX;
      all.push_back(counts);
    }
    return all;
  }

  void do_output(Unit& unit, CameraOutput& output) {
    if (output.is_stream_closed) {
      unit.sender.clear();
      unit.waiting.clear();
    }
    for (const CameraOutput::Answer& answer : output.answers)
      static_cast<void>(unit.control.send(answer.to, answer.bytes));
    for (const gige::ResendRequest& request : output.resends) unit.sender.resend(request);
    if (output.test_packet) send_test_packet(unit, *output.test_packet);
    for (FrameOrder& frame : output.frames) {
      ++unit.counts.frames;
      if (options_.on_frame) options_.on_frame(index_of(unit), frame);
      unit.waiting.push_back(std::move(frame));
      if (unit.waiting.size() <= most_waiting) continue;
      unit.waiting.pop_front();
      ++unit.counts.dropped_frames;
    }
    if (output.new_address) move(unit, *output.new_address);
    output.clear();
  }

 private:
  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::int64_t next = INT64_MAX;
      {
        const std::lock_guard lock(mutex_);
        const std::int64_t now = monotonic_now_ns();
        hear_triggers(now);
        give_pulses(now);
        hear_broadcasts(now);
        for (std::size_t i = 0; i < units_.size(); ++i) {
          serve(*units_[i], waiter_.is_ready(i), now);
          next = std::min(next, next_ns(*units_[i]));
        }
        if (!pulses_.empty()) next = std::min(next, pulses_.front().rise_ns);
      }
      waiter_.wait(std::clamp(next - monotonic_now_ns(), shortest_wait_ns, longest_wait_ns));
    }
  }

  std::size_t index_of(const Unit& unit) const {
    const auto is_it = [&unit](const auto& other) { return other.get() == &unit; };
    return static_cast<std::size_t>(std::find_if(units_.begin(), units_.end(), is_it) - units_.begin());
  }

  void add_pulse(const LinePulse& pulse) {
    if (pulses_.size() >= most_pulses) return;
    const auto sooner = [](const LinePulse& a, const LinePulse& b) { return a.rise_ns < b.rise_ns; };
    pulses_.insert(std::upper_bound(pulses_.begin(), pulses_.end(), pulse, sooner), pulse);
  }

  void hear_triggers(std::int64_t now) {
    for (std::size_t k = 0; k < triggers_.size(); ++k) {
      if (!waiter_.is_ready(units_.size() + broadcasts_.size() + k)) continue;
      const auto count = triggers_[k].receive(batch_);
      for (std::size_t i = 0; count && i < *count; ++i) {
        const ByteView bytes = batch_[i].bytes;
        const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        const std::uint32_t line = text.starts_with("Line2") ? 2 : 0;
        add_pulse({line, now, now + pulse_ns, pulse_number_++});
      }
    }
  }

  void give_pulses(std::int64_t now) {
    while (!pulses_.empty() && pulses_.front().rise_ns <= now) {
      for (const auto& unit : units_) {
        if (!unit->camera.is_silent(now)) unit->camera.pulse(pulses_.front());
      }
      pulses_.pop_front();
    }
  }

  void hear_broadcasts(std::int64_t now) {
    for (std::size_t k = 0; k < broadcasts_.size(); ++k) {
      if (!waiter_.is_ready(units_.size() + k)) continue;
      const auto count = broadcasts_[k].receive(batch_);
      for (std::size_t i = 0; count && i < *count; ++i) {
        const auto frame = gige::parse_command(batch_[i].bytes);
        const auto command = frame ? static_cast<gige::Command>(frame->command) : gige::Command::pending;
        if (command != gige::Command::discovery && command != gige::Command::force_ip) continue;
        for (const auto& unit : units_) {
          if (!is_on_interface(unit->camera.ip(), batch_[i].interface)) continue;
          unit->camera.receive(now, batch_[i].from, batch_[i].bytes, output_);
          do_output(*unit, output_);
        }
      }
    }
  }

  void serve(Unit& unit, bool is_spoken_to, std::int64_t now) {
    if (is_spoken_to) {
      const auto count = unit.control.receive(batch_);
      for (std::size_t i = 0; count && i < *count; ++i) {
        unit.camera.receive(now, batch_[i].from, batch_[i].bytes, output_);
        do_output(unit, output_);
      }
    }
    unit.camera.tick(now, output_);
    do_output(unit, output_);
    while (!unit.waiting.empty() && make_frame(unit, now)) {
    }
    unit.sender.take_due(now, group, outgoing_);
    while (!outgoing_.empty()) {
      if (!unit.camera.is_silent(now)) send(unit);
      unit.sender.take_due(now, group, outgoing_);
    }
  }

  bool make_frame(Unit& unit, std::int64_t now) {
    const FrameOrder& order = unit.waiting.front();
    if (memory_.empty()) memory_ = unit.sender.take_memory();
    if (!unit.served.source->make(order.wish(), memory_)) return false;
    if (memory_.size() == order.settings.image_bytes) {
      if (order.settings.exposure_auto != ExposureAuto::off)
        unit.camera.meter(now, mean_brightness(memory_, order.settings.pixel_format));
      const StreamTarget target = unit.camera.stream();
      unit.stream.set_do_not_fragment(target.do_not_fragment);
      unit.sender.mark_resent(unit.camera.marks_resent());
      unit.sender.add(order, std::exchange(memory_, {}), target, now);
    } else {
      ++unit.counts.dropped_frames;
    }
    unit.waiting.pop_front();
    return true;
  }

  void send(Unit& unit) {
    parts_.clear();
    for (const StreamSender::Outgoing& packet : outgoing_)
      parts_.push_back({packet.to, packet.packet.header, packet.packet.payload});
    const auto taken = unit.stream.send_all(parts_);
    unit.counts.unsent_packets += parts_.size() - (taken ? *taken : 0);
  }

  static void send_test_packet(Unit& unit, const StreamTarget& target) {
    const auto header = gige::make_stream_header({});
    const std::vector<std::uint8_t> filling(target.packet_bytes - gige::kWireHeaderBytes - header.size());
    unit.stream.set_do_not_fragment(target.do_not_fragment);
    const net::Parts packet{target.to, header, filling};
    static_cast<void>(unit.stream.send_all({&packet, 1}));
  }

  // To another address; where this machine does not have it, the camera is gone from the network, as a real one is.
  void move(Unit& unit, const gige::Ipv4& ip) {
    auto control = open_socket(ip, gige::kControlPort);
    auto stream = open_socket(ip, 0);
    if (!control || !stream) return;
    unit.control = *std::move(control);
    unit.stream = *std::move(stream);
    unit.camera.set_stream_port(unit.stream.local().port);
    if (auto waiter = net::Waiter::create(descriptors(units_, broadcasts_, triggers_))) waiter_ = *std::move(waiter);
  }

  static std::int64_t next_ns(const Unit& unit) {
    std::int64_t next = std::min(unit.camera.deadline_ns(), unit.sender.deadline_ns());
    if (!unit.waiting.empty()) next = std::min(next, monotonic_now_ns() + source_wait_ns);
    return next;
  }

 public:
  static std::vector<int> descriptors(const std::vector<std::unique_ptr<Unit>>& units,
                                      const std::vector<net::UdpSocket>& broadcasts,
                                      const std::vector<net::UdpSocket>& triggers) {
    std::vector<int> all;
    for (const auto& unit : units) all.push_back(unit->control.descriptor());
    for (const auto* sockets : {&broadcasts, &triggers}) {
      for (const net::UdpSocket& socket : *sockets) all.push_back(socket.descriptor());
    }
    return all;
  }

 private:
  CameraServerOptions options_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Unit>> units_;
  std::vector<net::UdpSocket> broadcasts_;
  std::vector<net::UdpSocket> triggers_;
  net::Waiter waiter_;
  net::ReceiveBatch batch_;
  std::deque<LinePulse> pulses_;
  std::int64_t pulse_number_ = 0;
  CameraOutput output_;
  std::vector<StreamSender::Outgoing> outgoing_;
  std::vector<net::Parts> parts_;
  std::vector<std::uint8_t> memory_;
  std::jthread thread_;  ///< Last: it uses all of the others.
};

CameraServer::CameraServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CameraServer::~CameraServer() = default;

Expected<std::unique_ptr<CameraServer>> CameraServer::start(std::vector<ServedCamera> cameras,
                                                            const CameraServerOptions& options) {
  std::vector<std::unique_ptr<Unit>> units;
  std::vector<net::UdpSocket> triggers;
  std::vector<gige::Ipv4> addresses;
  for (ServedCamera& camera : cameras) {
    const gige::Ipv4 ip = camera.device.identity.ip;
    addresses.push_back(ip);
    auto unit = open_unit(std::move(camera), options.seed + units.size());
    if (!unit) return unit.error();
    units.push_back(*std::move(unit));
    if (options.trigger_port == 0) continue;
    auto trigger = open_socket(ip, options.trigger_port);
    if (!trigger) return trigger.error();
    triggers.push_back(*std::move(trigger));
  }
  auto broadcasts = open_broadcasts(addresses);
  if (!broadcasts) return broadcasts.error();
  auto waiter = net::Waiter::create(Impl::descriptors(units, *broadcasts, triggers));
  if (!waiter) return waiter.error();
  return std::unique_ptr<CameraServer>(new CameraServer(std::make_unique<Impl>(
      std::move(units), *std::move(broadcasts), std::move(triggers), *std::move(waiter), options)));
}

void CameraServer::pulse(const LinePulse& pulse) { impl_->pulse(pulse); }

void CameraServer::reboot(std::size_t camera) {
  impl_->with_unit(camera, [this](Unit& unit) {
    CameraOutput output;
    unit.camera.reboot(monotonic_now_ns(), output);
    impl_->do_output(unit, output);
  });
}

void CameraServer::fall_silent(std::size_t camera, std::int64_t until_ns) {
  impl_->with_unit(camera, [until_ns](Unit& unit) { unit.camera.fall_silent(until_ns); });
}

void CameraServer::set_owned_by_other(std::size_t camera, bool owned) {
  impl_->with_unit(camera, [this, owned](Unit& unit) {
    CameraOutput output;
    unit.camera.set_owned_by_other(owned, output);
    impl_->do_output(unit, output);
  });
}

std::vector<CameraCounts> CameraServer::counts() const { return impl_->counts(); }

}  // namespace rigcal::sim
