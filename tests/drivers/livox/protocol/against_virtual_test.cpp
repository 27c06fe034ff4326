// Both ends of the wire, each written for itself, in one thread and on one clock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/base/random.h"
#include "drivers/livox/protocol/abilities.h"
#include "drivers/livox/protocol/host_protocol.h"
#include "simdata/live/virtual_livox.h"

namespace rigcal::livox {
namespace {

using sim::ControlFaults;
using sim::DeviceFrame;
using sim::VirtualLivox;
using sim::VirtualLivoxOptions;

constexpr std::int64_t ms = 1'000'000;
const Ipv4 host_ip{192, 168, 1, 5};

struct Model {
  std::string code;
  DeviceType type;
  std::uint8_t last;
};

// A rig with one of each, and a Mid-100's three units.
const std::vector<Model> models{
    {"3JEDK380010Z391", DeviceType::avia, 139},   {"0TFDG3B00600551", DeviceType::mid40, 21},
    {"0TFDG3B00600552", DeviceType::mid40, 91},   {"0TFDG3B00600553", DeviceType::mid40, 161},
    {"1HDDG3B00600551", DeviceType::horizon, 30}, {"1PQDL5H001UL991", DeviceType::tele15, 31},
    {"3GGDJ9600100401", DeviceType::mid70, 140}};

constexpr std::size_t rebooting = 19;
constexpr std::size_t disconnecting = 12;
static_assert(std::is_same_v<std::variant_alternative_t<rebooting, ControlContent>, RebootRequest>);
static_assert(std::is_same_v<std::variant_alternative_t<disconnecting, ControlContent>, DisconnectRequest>);

// A request that no device has a reason to refuse for what it says.
template <class Request>
Request sensible() {
  Request request{};
  if constexpr (std::is_same_v<Request, SetIpModeRequest>) request.mode = IpMode::dynamic;
  if constexpr (std::is_same_v<Request, SetPowerModeRequest>) request.value = PowerMode::normal;
  if constexpr (std::is_same_v<Request, RebootRequest>) request.value = 1000;
  if constexpr (std::is_same_v<Request, WriteParametersRequest>) request.parameters = {Parameter{1, {1}}};
  if constexpr (std::is_same_v<Request, SetUtcTimeRequest>) request.value.unix_ns = 1'600'000'000'000 * ms;
  return request;
}

class Lab {
 public:
  explicit Lab(const ControlFaults& faults = {}, double host_loss = 0.0) : host_loss_(host_loss), protocol(make()) {
    for (std::size_t i = 0; i < models.size(); ++i) {
      VirtualLivoxOptions options;
      options.identity = {models[i].code, models[i].type, kDevicePort};
      options.ip = {192, 168, 1, models[i].last};
      options.spin_up_s = 0.5 + 0.3 * static_cast<double>(i);
      options.faults = faults;
      options.seed = i + 1;
      devices.emplace_back(options, now);
    }
  }

  void pass(std::int64_t milliseconds) {
    for (const std::int64_t end = now + milliseconds * ms; now < end;) {
      now += 10 * ms;
      ProtocolOutput out;
      for (std::size_t i = 0; i < devices.size(); ++i) {
        std::vector<DeviceFrame> frames;
        devices[i].tick(now, frames);
        deliver(i, frames, out);
      }
      protocol.tick(now, out);
      while (!out.frames.empty()) out = exchange(std::move(out));
      keep(out);
    }
  }
  [[nodiscard]] int sampling() const {
    int count = 0;
    for (std::size_t i = 0; i < devices.size(); ++i)
      if (protocol.device(i).state == LinkState::sampling && devices[i].is_sampling()) ++count;
    return count;
  }
  template <class T>
  [[nodiscard]] std::vector<Event> told() const {
    std::vector<Event> found;
    for (const Event& event : events)
      if (std::holds_alternative<T>(event.content)) found.push_back(event);
    return found;
  }

  std::int64_t now = 1000 * ms;

 private:
  static HostProtocol make() {
    std::vector<WantedDevice> wanted;
    for (const Model& model : models) {
      WantedDevice device;
      device.broadcast_code = model.code;
      device.settings.coordinates = Coordinates::spherical;
      device.settings.return_mode = Echoes::dual;
      device.settings.imu_rate = ImuRate::hz_200;
      device.settings.extrinsics = StoredExtrinsics{};
      wanted.push_back(device);
    }
    auto made = HostProtocol::create({{host_ip, {255, 255, 255, 0}, 55501, 56001, 56001}}, wanted);
    EXPECT_TRUE(made.has_value());
    return *std::move(made);
  }
  void keep(ProtocolOutput& out) {
    events.insert(events.end(), out.events.begin(), out.events.end());
    out.events.clear();
  }
  void deliver(std::size_t device, const std::vector<DeviceFrame>& frames, ProtocolOutput& out) {
    for (const DeviceFrame& frame : frames)
      protocol.receive(now, 0, {{192, 168, 1, models[device].last}, kDevicePort}, frame.bytes, out);
  }
  ProtocolOutput exchange(ProtocolOutput sent) {
    ProtocolOutput out;
    for (const OutgoingFrame& frame : sent.frames) {
      if (host_loss_ > 0.0 && random_.uniform() < host_loss_) continue;
      for (std::size_t i = 0; i < devices.size(); ++i) {
        if (frame.to.ip[3] != models[i].last) continue;
        std::vector<DeviceFrame> answers;
        devices[i].receive(now, {host_ip, 55501}, frame.bytes, answers);
        deliver(i, answers, out);
      }
    }
    keep(sent);
    return out;
  }

  double host_loss_;
  Random random_{99};

 public:
  HostProtocol protocol;
  std::vector<VirtualLivox> devices;
  std::vector<Event> events;
};

TEST(AgainstVirtual, EveryModelIsTakenSetUpAndFreed) {
  Lab lab;
  lab.pass(4500);
  EXPECT_EQ(lab.sampling(), 7);
  EXPECT_EQ(lab.devices[0].settings().point_type(), DataType::dual_spherical);
  EXPECT_EQ(lab.devices[1].settings().point_type(), DataType::spherical);
  EXPECT_EQ(lab.devices[1].owner()->imu_port, 56001);
  for (std::size_t i = 0; i < models.size(); ++i) EXPECT_EQ(lab.protocol.device(i).counters.handshakes, 1U) << i;
  ProtocolOutput out;
  lab.protocol.leave(lab.now, out);
  // The first frames of leaving were not delivered: they are not repeated, but the rest goes on within the second.
  lab.pass(1000);
  EXPECT_TRUE(lab.protocol.is_closed());
  lab.pass(5000);
  for (const VirtualLivox& device : lab.devices) EXPECT_FALSE(device.owner().has_value());
}

// What the host's tables say that a model can do is what the device of that model does, and every request gets an
// answer of its own command with its own number.
template <std::size_t index>
void ask_for(VirtualLivox& device, const Model& model, std::int64_t now) {
  using Request = std::variant_alternative_t<index, ControlContent>;
  if constexpr (requires { Request::command; }) {
    if constexpr (Request::type == FrameType::command) {
      const Request request = sensible<Request>();
      std::vector<DeviceFrame> answers;
      device.receive(now, {host_ip, 55501}, encode_control(request, 777), answers);
      ASSERT_EQ(answers.size(), 1U) << command_name(Request::command);
      const auto frame = parse_control_frame(answers[0].bytes);
      ASSERT_TRUE(frame.has_value());
      EXPECT_EQ(frame->seq, 777);
      EXPECT_EQ(command_of(*frame), Request::command);
      EXPECT_TRUE(decode_control(*frame).has_value());
      const bool can = can_do(model.type, {99, 0, 0, 0}, request);
      EXPECT_EQ(frame->payload[0], can ? 0 : 1) << model.code << ": " << command_name(Request::command);
    }
  }
}

template <std::size_t... index>
void ask_for_all(VirtualLivox& device, const Model& model, std::int64_t now, std::index_sequence<index...>) {
  // Going away comes last.
  ((index != disconnecting && index != rebooting ? ask_for<index>(device, model, now) : void()), ...);
  ask_for<rebooting>(device, model, now);
  ask_for<disconnecting>(device, model, now);
}

TEST(AgainstVirtual, EveryCommandIsAnsweredAsTheModelCan) {
  for (const Model& model : models) {
    VirtualLivoxOptions options;
    options.identity = {model.code, model.type, kDevicePort};
    options.ip = {192, 168, 1, model.last};
    options.spin_up_s = 0.0;
    VirtualLivox device(options, 1000 * ms);
    std::vector<DeviceFrame> frames;
    device.receive(1000 * ms, {host_ip, 55501}, make_handshake({host_ip, 56001, 55501, {}}, 1), frames);
    ask_for_all(device, model, 1001 * ms, std::make_index_sequence<std::variant_size_v<ControlContent>>());
  }
}

TEST(AgainstVirtual, TenMinutesWithoutTroubleLoseNothing) {
  Lab lab;
  lab.pass(600'000);
  EXPECT_EQ(lab.sampling(), 7);
  EXPECT_TRUE(lab.told<Lost>().empty());
}

TEST(AgainstVirtual, ABadNetworkIsLivedWith) {
  ControlFaults faults;
  faults.drop = 0.1;
  faults.duplicate = 0.1;
  faults.delay = 0.1;
  faults.wrong_number = 0.03;
  faults.wrong_checksum = 0.03;
  Lab lab(faults, 0.1);
  lab.pass(20'000);
  EXPECT_GE(lab.sampling(), 6);
  int sampling = 0;
  int looked = 0;
  for (; looked < 290; ++looked) {
    lab.pass(2000);
    sampling += lab.sampling();
  }
  // A heartbeat in four is lost; five in a row lose the device for some seconds.
  EXPECT_GT(sampling, 7 * looked * 97 / 100);
}

TEST(AgainstVirtual, FaultsOneByOneAndInPairsAreSurvived) {
  using Fault = std::function<void(Lab&, std::size_t)>;
  const std::vector<Fault> faults{
      [](Lab& lab, std::size_t i) { lab.devices[i].reboot(lab.now); },
      [](Lab& lab, std::size_t i) { lab.devices[i].fall_silent(lab.now + 10'000 * ms); },
      [](Lab& lab, std::size_t i) { lab.devices[i].fall_silent(lab.now + 2'000 * ms); },
      [](Lab& lab, std::size_t i) { lab.devices[i].set_status(0x80000020); },
      [](Lab& lab, std::size_t i) {
        ProtocolOutput out;
        lab.protocol.set_power(lab.now, i, PowerMode::standby, out);
        lab.protocol.set_power(lab.now, i, PowerMode::normal, out);
      },
      [](Lab& lab, std::size_t i) {
        // Another host has taken it.
        lab.devices[i].fall_silent(lab.now + 6'000 * ms);
        lab.devices[i].set_owned_by_other(true);
      },
  };
  Lab lab;
  lab.pass(4500);
  for (const Fault& first : faults) {
    for (const Fault& second : faults) {
      first(lab, 0);
      first(lab, 5);
      lab.pass(700);
      second(lab, 0);
      second(lab, 2);
      lab.pass(7'000);
      EXPECT_GE(lab.sampling(), 4);  // The others go on.
      for (VirtualLivox& device : lab.devices) {
        device.set_status(0);
        device.set_owned_by_other(false);
      }
      lab.pass(20'000);
      EXPECT_EQ(lab.sampling(), 7);
    }
  }
}

TEST(AgainstVirtual, ADeviceOfAnotherHostIsLeftAloneAndTakenWhenItIsFree) {
  Lab lab;
  lab.devices[0].set_owned_by_other(true);
  lab.pass(10'000);
  EXPECT_EQ(lab.sampling(), 6);
  EXPECT_EQ(lab.protocol.device(0).state, LinkState::waiting);
  lab.devices[0].set_owned_by_other(false);
  lab.pass(3'000);
  EXPECT_EQ(lab.sampling(), 7);
}

TEST(AgainstVirtual, ARefusedSettingIsToldAndDoesNotStopTheRest) {
  Lab lab;
  lab.devices[0].refuse(Command::set_return_mode);
  lab.pass(4500);
  EXPECT_EQ(lab.sampling(), 7);
  int refused = 0;
  for (const Event& event : lab.told<RequestEnded>()) {
    const auto& ended = std::get<RequestEnded>(event.content);
    if (event.device == 0 && ended.outcome == Outcome::refused) ++refused;
  }
  EXPECT_EQ(refused, 1);
}

}  // namespace
}  // namespace rigcal::livox
