// Every event in every state of a link.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <functional>
#include <set>
#include <string>

#include "tests/drivers/livox/protocol/desk.h"

namespace rigcal::livox {
namespace {

constexpr std::array<LinkState, 10> all_states{
    LinkState::waiting, LinkState::handshaking, LinkState::identifying, LinkState::preparing, LinkState::configuring,
    LinkState::resting, LinkState::idle,        LinkState::sampling,    LinkState::leaving,   LinkState::closed};

static_assert(all_states.size() == static_cast<std::size_t>(LinkState::closed) + 1, "a state without a column");

// w(aiting) h(andshaking) i(dentifying) p(reparing) c(onfiguring) r(esting) d (idle) s(ampling) l(eaving) x (closed)
char letter(LinkState state) { return std::string("whipcrdslx")[static_cast<std::size_t>(state)]; }

bool is_connected(LinkState state) {
  return state != LinkState::waiting && state != LinkState::handshaking && state != LinkState::closed;
}

void bring_to(Desk& desk, LinkState state) {
  switch (state) {
    case LinkState::waiting:
      break;
    case LinkState::handshaking:
      desk.hear_broadcast();
      break;
    case LinkState::identifying:
      desk.shake_hands();
      break;
    case LinkState::preparing:
      desk.identify();
      break;
    case LinkState::configuring:
      desk.identify();
      desk.beat();
      break;
    case LinkState::resting:
    case LinkState::idle:
      desk.identify();
      desk.beat(state == LinkState::idle ? WorkState::normal : WorkState::standby);
      if (state == LinkState::idle) desk.answer(CoordinatesAck{});
      break;
    case LinkState::sampling:
      desk.sample();
      break;
    case LinkState::leaving:
      desk.sample();
      desk.protocol.leave(desk.now_ns, desk.out);
      break;
    case LinkState::closed:
      desk.protocol.leave(desk.now_ns, desk.out);
      break;
  }
}

WantedDevice wanted_for(LinkState state) {
  WantedDevice wanted = wanted_avia();
  if (state == LinkState::resting) wanted.power = PowerMode::standby;
  if (state == LinkState::idle) wanted.sampling = false;
  return wanted;
}

// An answer with this return code to what was asked last.
void answer_last(Desk& desk, ReturnCode ret, int seq_error = 0, bool other_command = false) {
  const auto asked = desk.asked();
  if (!asked) return;
  std::vector<std::uint8_t> payload{static_cast<std::uint8_t>(ret)};
  if (ret == ReturnCode::success && command_of(*asked) == Command::device_information)
    payload.insert(payload.end(), {11, 9, 0, 0});
  desk.hear(make_control_frame({FrameType::ack, static_cast<std::uint16_t>(asked->seq + seq_error), asked->set,
                                static_cast<std::uint8_t>(other_command ? asked->id ^ 0x10U : asked->id), payload}));
}

void beat_with(Desk& desk, WorkState state, ReturnCode ret = ReturnCode::success) {
  // Also where none was sent: then the number is one that fits nothing.
  if (is_connected(desk.state())) desk.pass_to_next_heartbeat();
  if (desk.sent(Command::heartbeat)) return desk.beat(state, 0, ret);
  desk.hear(encode_control(HeartbeatAck{ret, state, 0, 0}, 7));
}

constexpr std::int64_t kNoon = 1'600'000'000'000'000'000;
constexpr std::uint32_t kPulses = 1U << 9U;
constexpr std::array<std::uint8_t, 1> success{0};

// Calls it with an empty one of every payload.
template <class Call, std::size_t... index>
void for_each_payload(const Call& call, std::index_sequence<index...>) {
  (call(ControlPayload(std::variant_alternative_t<index, ControlContent>{})), ...);
}
template <class Call>
void for_each_payload(const Call& call) {
  for_each_payload(call, std::make_index_sequence<std::variant_size_v<ControlContent>>());
}

struct Row {
  const char* event;
  const char* after;  // A letter for each of `all_states`.
  std::function<void(Desk&)> happen;
};

const std::vector<Row>& table() {
  static const std::vector<Row> rows{
      {"a broadcast", "hhipcrdslx", [](Desk& d) { d.hear_broadcast(); }},
      {"a broadcast after silence", "hhhhhhhhxx",
       [](Desk& d) {
         d.pass(1300);
         d.hear_broadcast();
       }},
      {"a broadcast from another address", "hhipcrdslx",
       [](Desk& d) {
         d.hear({{192, 168, 1, 77}, kDevicePort}, make_broadcast(d.broadcast, 1));
       }},
      {"a broadcast of another device", "whipcrdslx",
       [](Desk& d) {
         d.hear({{192, 168, 1, 78}, kDevicePort}, make_broadcast({"3JEDK380010Z999", DeviceType::avia, 0}, 1));
       }},
      {"the handshake is taken", "wiipcrdslx",
       [](Desk& d) {
         if (d.sent(Command::handshake)) return d.answer(HandshakeAck{});
         d.hear(encode_control(HandshakeAck{}, 1));
       }},
      {"the handshake is refused", "wwipcrdslx",
       [](Desk& d) {
         if (d.sent(Command::handshake)) return d.answer(HandshakeAck{ReturnCode::failure});
         d.hear(encode_control(HandshakeAck{ReturnCode::failure}, 1));
       }},
      {"an answer to another handshake", "whipcrdslx", [](Desk& d) { d.hear(encode_control(HandshakeAck{}, 999)); }},
      // The last answer again, where nothing is open. A refused handshake ends it like any other.
      {"the answer: done", "wippdrdslx", [](Desk& d) { answer_last(d, ReturnCode::success); }},
      {"the answer: refused", "wwipdrdslx", [](Desk& d) { answer_last(d, ReturnCode::failure); }},
      {"the answer: switching", "wwipdrdslx", [](Desk& d) { answer_last(d, ReturnCode::switching); }},
      {"the answer: done, twice", "wippdrdslx",
       [](Desk& d) {
         const auto asked = d.asked();
         answer_last(d, ReturnCode::success);
         if (asked) d.hear(make_control_frame({FrameType::ack, asked->seq, asked->set, asked->id, success}));
       }},
      {"an answer that nobody can read", "whipcrdslx",
       [](Desk& d) {
         const std::vector<std::uint8_t> payload(200, 0xFF);
         if (const auto asked = d.asked())
           d.hear(make_control_frame({FrameType::ack, asked->seq, asked->set, asked->id, payload}));
       }},
      {"a stray answer to every command", "whipcrdslx",
       [](Desk& d) {
         for (unsigned set = 0; set < 3; ++set)
           for (unsigned id = 0; id < 16; ++id)
             d.hear(make_control_frame(frame_of(static_cast<Command>(set << 8U | id), FrameType::ack, 54321, success)));
       }},
      {"an answer with a wrong number", "whipcrdslx", [](Desk& d) { answer_last(d, ReturnCode::success, 1); }},
      {"an answer to another command", "whipcrdslx", [](Desk& d) { answer_last(d, ReturnCode::success, 0, true); }},
      {"heartbeat: initialising", "whipppppLX", [](Desk& d) { beat_with(d, WorkState::initialising); }},
      {"heartbeat: normal", "whiccpdslx", [](Desk& d) { beat_with(d, WorkState::normal); }},
      {"heartbeat: power saving", "whipppppLX", [](Desk& d) { beat_with(d, WorkState::power_saving); }},
      {"heartbeat: standby", "whipprppLX", [](Desk& d) { beat_with(d, WorkState::standby); }},
      {"heartbeat: error", "whipppppLX", [](Desk& d) { beat_with(d, WorkState::error); }},
      {"heartbeat: a state nobody knows", "whipppppLX", [](Desk& d) { beat_with(d, static_cast<WorkState>(99)); }},
      {"heartbeat: normal, twice", "whiccpdslx",
       [](Desk& d) {
         beat_with(d, WorkState::normal);
         if (const auto beat = d.sent(Command::heartbeat))
           d.hear(encode_control(HeartbeatAck{ReturnCode::success, WorkState::standby, 0, 0}, beat->seq));
       }},
      {"heartbeat refused", "whipcrdslx", [](Desk& d) { beat_with(d, WorkState::initialising, ReturnCode::failure); }},
      {"abnormal status", "whipcrdslx", [](Desk& d) { d.hear(encode_control(AbnormalStatus{0x40006840}, 9)); }},
      {"a damaged abnormal status", "whipcrdslx",
       [](Desk& d) { d.hear(make_control_frame(frame_of(Command::abnormal_status, FrameType::message, 9, {}))); }},
      {"a command from the device", "whipcrdslx", [](Desk& d) { d.hear(encode_control(GetIpModeRequest{}, 9)); }},
      {"bytes that are no frame", "whipcrdslx",
       [](Desk& d) {
         const std::vector<std::uint8_t> bytes(30, 0xAA);
         d.hear(bytes);
       }},
      {"a frame from a stranger", "whipcrdslx",
       [](Desk& d) {
         d.hear({{192, 168, 1, 9}, kDevicePort}, encode_control(HandshakeAck{}, 1));
       }},
      {"the clock jumps back", "whipcrdslx", [](Desk& d) { d.protocol.tick(d.now_ns - 3'600'000 * kMs, d.out); }},
      {"half a second", "wwipcrdslx", [](Desk& d) { d.pass(500); }},
      {"three seconds of silence", "wwwwwwwwxx", [](Desk& d) { d.pass(3000); }},
      {"three seconds in one step", "wwwwwwwwxx", [](Desk& d) { d.protocol.tick(d.now_ns + 3000 * kMs, d.out); }},
      {"the time of day", "whipcrdslx", [](Desk& d) { d.protocol.tell_utc(kNoon, d.out); }},
      {"the time of day, with pulses", "whipcrdslx",
       [](Desk& d) {
         d.hear(encode_control(AbnormalStatus{kPulses}, 9));
         d.protocol.tell_utc(kNoon, d.out);
         if (d.sent(Command::set_utc_time)) d.answer(SetUtcTimeAck{});
       }},
      {"another device at its address", "whipcrdslx",
       [](Desk& d) {
         d.hear(make_broadcast({"3JEDK380010Z999", DeviceType::avia, 0}, 1));
       }},
      {"a broadcast from another subnet", "whipcrdslx",
       [](Desk& d) {
         d.hear({{10, 0, 0, 139}, kDevicePort}, make_broadcast(d.broadcast, 1));
       }},
      {"a broadcast where nobody listens", "whipcrdslx",
       [](Desk& d) {
         d.protocol.receive_elsewhere(d.now_ns, "eth3", d.device, make_broadcast(d.broadcast, 1), d.out);
       }},
      {"a user's requests of every kind, not answered", "whipcrdslx",
       [](Desk& d) {
         for_each_payload([&d](const ControlPayload& payload) {
           static_cast<void>(d.protocol.request(d.now_ns, 0, payload, d.out));
         });
       }},
      {"a reboot that the device takes", "whiwcwwwlx",
       [](Desk& d) {
         static_cast<void>(d.protocol.request(d.now_ns, 0, RebootRequest{100}, d.out));
         const auto asked = d.asked();
         if (asked && command_of(*asked) == Command::reboot) d.answer(RebootAck{});
       }},
      {"a disconnection that the device takes", "whiwcwwwlx",
       [](Desk& d) {
         static_cast<void>(d.protocol.request(d.now_ns, 0, DisconnectRequest{}, d.out));
         const auto asked = d.asked();
         if (asked && command_of(*asked) == Command::disconnect && d.state() != LinkState::leaving)
           d.answer(DisconnectAck{});
       }},
      {"a user's request", "whipcrdslx",
       [](Desk& d) { static_cast<void>(d.protocol.request(d.now_ns, 0, GetIpModeRequest{}, d.out)); }},
      {"sampling is not wanted", "whipcrdslx", [](Desk& d) { d.protocol.set_sampling(d.now_ns, 0, false, d.out); }},
      {"sampling is wanted", "whipcrdslx", [](Desk& d) { d.protocol.set_sampling(d.now_ns, 0, true, d.out); }},
      {"standby is wanted", "whipprppLX",
       [](Desk& d) { d.protocol.set_power(d.now_ns, 0, PowerMode::standby, d.out); }},
      {"normal power is wanted", "whipcpdslx",
       [](Desk& d) { d.protocol.set_power(d.now_ns, 0, PowerMode::normal, d.out); }},
      {"leave", "xxllllllLX", [](Desk& d) { d.protocol.leave(d.now_ns, d.out); }},
  };
  return rows;
}

TEST(StateTable, EveryEventInEveryState) {
  std::set<std::size_t> told;  // Kinds of events, over the whole table.
  for (const Row& row : table()) {
    ASSERT_EQ(std::string(row.after).size(), all_states.size()) << row.event;
    for (std::size_t i = 0; i < all_states.size(); ++i) {
      Desk desk(wanted_for(all_states[i]));
      bring_to(desk, all_states[i]);
      ASSERT_EQ(letter(desk.state()), letter(all_states[i]));
      desk.out.events.clear();
      row.happen(desk);
      EXPECT_EQ(letter(desk.state()), std::tolower(row.after[i])) << row.event << ", " << to_string(all_states[i]);
      for (const Event& event : desk.out.events) told.insert(event.content.index());
    }
  }
  EXPECT_EQ(told.size(), std::variant_size_v<EventContent>) << "a kind of event that no row brings about";
}

TEST(StateTable, TellsAndCountsInEveryState) {
  for (const LinkState state : all_states) {
    const auto desk_after = [&](const std::function<void(Desk&)>& happen) {
      Desk desk(wanted_for(state));
      bring_to(desk, state);
      desk.out.clear();
      happen(desk);
      return desk;
    };
    const bool connected = is_connected(state);
    const Desk abnormal = desk_after([](Desk& d) { d.hear(encode_control(AbnormalStatus{0x40006840}, 9)); });
    EXPECT_EQ(abnormal.told<StatusChanged>().size(), connected ? 1U : 0U) << to_string(state);
    const Desk noise = desk_after([](Desk& d) { d.hear(ByteView{}); });
    EXPECT_EQ(noise.protocol.counters().malformed, 1U);
    EXPECT_TRUE(noise.out.events.empty() && noise.out.frames.empty());
    const Desk stray = desk_after([](Desk& d) { d.hear(encode_control(SetFanAck{}, 4321)); });
    EXPECT_EQ(stray.info().counters.stray_acks + stray.protocol.counters().strangers, 1U) << to_string(state);
    EXPECT_TRUE(stray.out.events.empty() && stray.out.frames.empty());
    const Desk silent = desk_after([](Desk& d) { d.pass(3000); });
    EXPECT_EQ(silent.told<Lost>().size(), connected && state != LinkState::leaving ? 1U : 0U) << to_string(state);
    EXPECT_EQ(silent.told<Closed>().size(), state == LinkState::leaving ? 1U : 0U);
    EXPECT_EQ(silent.told<HandshakeUnanswered>().size(), state == LinkState::handshaking ? 1U : 0U);
    const std::uint64_t repeated = desk_after([](Desk& d) { d.pass(600); }).info().counters.repeated;
    const bool has_asked = state == LinkState::identifying || state == LinkState::configuring;
    EXPECT_EQ(repeated, has_asked ? 1U : 0U) << to_string(state);
    const Desk pulses = desk_after([](Desk& d) {
      d.hear(encode_control(AbnormalStatus{kPulses}, 9));
      d.protocol.tell_utc(kNoon, d.out);
    });
    const bool takes_time = connected && state != LinkState::identifying && state != LinkState::leaving;
    EXPECT_EQ(pulses.count_sent(Command::set_utc_time), takes_time ? 1U : 0U) << to_string(state);
    const bool takes_requests = connected && state != LinkState::identifying && state != LinkState::leaving;
    Desk asking = desk_after([](Desk&) {});
    EXPECT_EQ(asking.protocol.request(asking.now_ns, 0, GetIpModeRequest{}, asking.out).has_value(), takes_requests)
        << to_string(state);
  }
}

}  // namespace
}  // namespace rigcal::livox
