#include "drivers/livox_codec/control_payload.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "tests/drivers/livox_codec/random_payload.h"
#include "tests/drivers/livox_codec/worked_examples.h"
#include "tests/support/files.h"
#include "tests/support/hex.h"

namespace rigcal::livox {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Reads what a payload of these bytes says.
Expected<ControlPayload> decode(Command command, FrameType type, const Bytes& payload) {
  return decode_control(frame_of(command, type, 1, payload));
}

std::string mistake_in(Command command, FrameType type, const Bytes& payload) {
  const Expected<ControlPayload> content = decode(command, type, payload);
  return content ? "" : content.error().message();
}

TEST(ControlPayload, ReadsAndWritesEveryWorkedExampleToTheByte) {
  for (const WorkedExample& example : worked_examples()) {
    const Bytes bytes = from_hex(example.hex);
    const Expected<ControlFrame> frame = parse_control_frame(bytes);
    ASSERT_TRUE(frame) << example.hex;
    const Expected<ControlPayload> content = decode_control(*frame);
    ASSERT_TRUE(content) << example.hex << ": " << content.error().message();
    EXPECT_TRUE(*content == example.payload) << example.hex;
    const auto* handshake = std::get_if<Handshake>(&example.payload);
    const Bytes back = handshake != nullptr ? make_handshake(*handshake, frame->seq, frame->type)
                                            : encode_control(example.payload, frame->seq);
    EXPECT_EQ(back, bytes) << example.hex;
  }
}

// Shorter payloads that say something in themselves: the old forms, lists of parameters and refusals.
bool may_be_cut(const ControlPayload& payload, FrameType type, std::size_t size) {
  // As the vendor's software sends it, a handshake of one byte is the answer to one.
  if (std::holds_alternative<Handshake>(payload)) return size == 8 || (type == FrameType::ack && size == 1);
  if (std::holds_alternative<SetIpModeRequest>(payload)) return size == 5;
  if (std::holds_alternative<GetIpModeAck>(payload)) return size == 6;
  if (std::holds_alternative<ReadParametersAck>(payload)) return size == 4;
  if (payload == ControlPayload(ResetParametersRequest::all())) return size == 2;
  if (const auto* ack = std::get_if<WriteParametersAck>(&payload)) return ack->ret != ReturnCode::success && size == 1;
  return false;
}

TEST(ControlPayload, RefusesEveryTruncationOfEveryWorkedExample) {
  std::size_t refused = 0;
  for (const WorkedExample& example : worked_examples()) {
    const Bytes bytes = from_hex(example.hex);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(parse_control_frame(ByteView(bytes).first(size))) << example.hex;
    }
    // A payload that is too short in a frame that is right.
    const ControlFrame whole = *parse_control_frame(bytes);
    for (std::size_t size = 0; size < whole.payload.size(); ++size) {
      const Bytes kept(whole.payload.begin(), whole.payload.begin() + static_cast<std::ptrdiff_t>(size));
      ControlFrame cut = whole;
      cut.payload = kept;
      const Bytes framed = make_control_frame(cut);
      const Expected<ControlPayload> content = decode_control(*parse_control_frame(framed));
      EXPECT_EQ(content.has_value(), may_be_cut(example.payload, whole.type, size))
          << example.hex << " cut to " << size;
      if (!content) ++refused;
    }
  }
  EXPECT_GT(refused, 300U);
}

TEST(ControlPayload, RefusesBytesBehindTheEnd) {
  for (const WorkedExample& example : worked_examples()) {
    const Bytes bytes = from_hex(example.hex);
    ControlFrame frame = *parse_control_frame(bytes);
    Bytes longer(frame.payload.begin(), frame.payload.end());
    longer.insert(longer.end(), 3, 0x5A);
    frame.payload = longer;
    EXPECT_FALSE(decode_control(frame)) << example.hex;
  }
}

template <std::size_t... index>
void check_round_trips(RandomPayload& random, std::index_sequence<index...>) {
  const auto check = [](const ControlPayload& payload) {
    const Bytes bytes = encode_control(payload, 77);
    const Expected<ControlFrame> frame = parse_control_frame(bytes);
    ASSERT_TRUE(frame) << frame.error().message();
    EXPECT_EQ(frame->seq, 77);
    const Expected<ControlPayload> back = decode_control(*frame);
    ASSERT_TRUE(back) << frame_name(*frame) << ": " << back.error().message();
    EXPECT_EQ(back->index(), payload.index()) << frame_name(*frame);
    EXPECT_TRUE(*back == payload) << frame_name(*frame);
    EXPECT_EQ(encode_control(*back, 77), bytes);
  };
  (check(random.make<std::variant_alternative_t<index, ControlContent>>()), ...);
}

TEST(ControlPayload, EveryPayloadComesBackFromARoundTripOfRandomValues) {
  RandomPayload random(11);
  for (int i = 0; i < 100; ++i) {
    check_round_trips(random, std::make_index_sequence<std::variant_size_v<ControlContent>>());
  }
}

template <std::size_t... index>
std::set<std::string> frame_names(RandomPayload& random, std::index_sequence<index...>) {
  std::set<std::string> names;
  const auto add = [&names](const ControlPayload& payload) {
    const Bytes bytes = encode_control(payload, 0);
    names.insert(frame_name(*parse_control_frame(bytes)));
  };
  (add(random.make<std::variant_alternative_t<index, ControlContent>>()), ...);
  return names;
}

TEST(ControlPayload, EveryCommandOfTheProtocolHasItsRequestAndItsAck) {
  RandomPayload random(1);
  const auto names = frame_names(random, std::make_index_sequence<std::variant_size_v<ControlContent>>());
  const auto first_to_last = [](Command first, Command last) {
    std::vector<Command> commands;
    for (auto code = static_cast<std::uint16_t>(first); code <= static_cast<std::uint16_t>(last); ++code) {
      commands.push_back(static_cast<Command>(code));
    }
    return commands;
  };
  std::vector<Command> commands = first_to_last(Command::broadcast, Command::reset_parameters);
  for (const auto& [first, last] : {std::pair{Command::set_power_mode, Command::set_utc_time},
                                    std::pair{Command::hub_list_lidars, Command::hub_get_imu_rate}}) {
    const auto more = first_to_last(first, last);
    commands.insert(commands.end(), more.begin(), more.end());
  }
  ASSERT_EQ(commands.size(), 14U + 11U + 15U);
  for (const Command command : commands) {
    const std::string name = command_name(command);
    EXPECT_EQ(name.find("0x"), std::string::npos) << name;
    EXPECT_EQ(names.count(name), 1U) << name;
    const bool message = command == Command::broadcast || command == Command::abnormal_status;
    EXPECT_EQ(names.count(name + "_ack"), message ? 0U : 1U) << name;
  }
  // Beside them there are only raw frames.
  EXPECT_LE(names.size(), 2U * 40U - 2U + 1U);
}

TEST(ControlPayload, WhatTheProtocolDoesNotKnowStaysAsItCame) {
  const Bytes payload{1, 2, 3};
  const Expected<ControlPayload> content = decode_control({FrameType::command, 9, CommandSet::lidar, 0x1F, payload});
  ASSERT_TRUE(content);
  EXPECT_TRUE(*content == ControlPayload(RawControl{FrameType::command, CommandSet::lidar, 0x1F, payload}));
  // A known command in a frame of a type that it never has.
  const Expected<ControlPayload> message = decode(Command::heartbeat, FrameType::message, {});
  ASSERT_TRUE(message);
  EXPECT_TRUE(std::holds_alternative<RawControl>(*message));
}

TEST(ControlPayload, RefusesAValueThatARequestCannotHave) {
  EXPECT_THAT(mistake_in(Command::sampling, FrameType::command, {2}), testing::HasSubstr("value 2 is not known"));
  EXPECT_FALSE(decode(Command::set_power_mode, FrameType::command, {0}));
  EXPECT_FALSE(decode(Command::set_power_mode, FrameType::command, {4}));
  EXPECT_TRUE(decode(Command::set_return_mode, FrameType::command, {3}));
  EXPECT_FALSE(decode(Command::set_return_mode, FrameType::command, {4}));
  EXPECT_THAT(mistake_in(Command::set_utc_time, FrameType::command, from_hex("14020a1e00e9a435")),
              testing::HasSubstr("no date"));
  EXPECT_FALSE(decode(Command::handshake, FrameType::command, Bytes(9)));
  EXPECT_FALSE(decode(Command::write_extrinsics, FrameType::command,
                      from_hex("0000c07f 00000000 00000000 00000000 00000000 00000000")))
      << "not a number";
}

TEST(ControlPayload, KeepsAnAcksValueThatItDoesNotKnow) {
  const Expected<ControlPayload> ack = decode(Command::heartbeat, FrameType::ack, {0, 9, 0xFF, 1, 2, 3, 4});
  ASSERT_TRUE(ack);
  EXPECT_EQ(static_cast<int>(std::get<HeartbeatAck>(*ack).state), 9);
  EXPECT_EQ(std::get<HeartbeatAck>(*ack).progress_or_status, 0x04030201U);
}

TEST(ControlPayload, ARefusalAnswersEveryRequest) {
  const Bytes asked = encode_control(GetIpModeRequest{}, 321);
  const Bytes refusal = make_refusal(*parse_control_frame(asked));
  const Expected<ControlFrame> frame = parse_control_frame(refusal);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->seq, 321);
  EXPECT_EQ(frame->type, FrameType::ack);
  const Expected<ControlPayload> ack = decode_control(*frame);
  ASSERT_TRUE(ack) << ack.error().message();
  EXPECT_EQ(std::get<GetIpModeAck>(*ack).ret, ReturnCode::failure);
  // The same byte with success must have the rest behind it.
  EXPECT_FALSE(decode(Command::get_ip_mode, FrameType::ack, {0}));
}

TEST(ControlPayload, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(mistake_in(Command::heartbeat, FrameType::ack, {0, 1, 0, 0}),
              testing::HasSubstr("heartbeat_ack, offset 3 of a payload of 4 bytes: ends too soon"));
  EXPECT_THAT(mistake_in(Command::disconnect, FrameType::command, {0, 0}), testing::HasSubstr("2 bytes too many"));
  EXPECT_THAT(mistake_in(Command::write_parameters, FrameType::command, {}), testing::HasSubstr("names no parameter"));
  EXPECT_THAT(mistake_in(Command::write_parameters, FrameType::command, {2, 0, 0xFF, 0xFF, 1}),
              testing::HasSubstr("a parameter ends too soon"));
  EXPECT_THAT(mistake_in(Command::reset_parameters, FrameType::command, {1, 1, 1, 0, 2, 0}),
              testing::HasSubstr("more keys than it counts"));
  // A count of 255 with one entry behind it.
  Bytes list(25, 'A');
  list[0] = 0;
  list[1] = 0xFF;
  list[17] = 0;
  EXPECT_THAT(mistake_in(Command::hub_list_lidars, FrameType::ack, list), testing::HasSubstr("ends too soon"));
  list[5] = 0x1B;  // An escape character must not reach a terminal.
  EXPECT_THAT(mistake_in(Command::hub_list_lidars, FrameType::ack, list), testing::HasSubstr("printable"));
}

TEST(ControlPayload, TheVendorsQueryOfAllExtrinsicsHasNoList) {
  const Expected<ControlPayload> all = decode(Command::hub_read_extrinsics, FrameType::command, {});
  ASSERT_TRUE(all);
  EXPECT_FALSE(std::get<HubReadExtrinsicsRequest>(*all).value.has_value());
  const Expected<ControlPayload> none = decode(Command::hub_read_extrinsics, FrameType::command, {0});
  ASSERT_TRUE(none);
  EXPECT_TRUE(std::get<HubReadExtrinsicsRequest>(*none).value.has_value());
}

TEST(FrameName, TellsRequestsFromAnswers) {
  const Bytes vendors = from_hex("aa011900010200b0310001c0a80105c1dacdd8c1daf45d01b0");
  const ControlFrame handshake = *parse_control_frame(vendors);
  EXPECT_EQ(frame_name(handshake), "handshake");
  EXPECT_TRUE(is_request(handshake));
  const Bytes answer = from_hex("aa0110000100006453000100f1343c29");
  EXPECT_EQ(frame_name(*parse_control_frame(answer)), "handshake_ack");
  EXPECT_FALSE(is_request(*parse_control_frame(answer)));
  EXPECT_EQ(frame_name({FrameType::ack, 0, CommandSet::hub, 0x1F, {}}), "hub_0x1f_ack");
}

// The fuzzer starts from the worked examples.
TEST(ControlCorpus, IsTheWorkedExamples) {
  std::set<std::string> corpus;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(RIGCAL_SOURCE_DIR) + "/tests/fuzz/corpus/control")) {
    corpus.insert(text_of(entry.path()));
  }
  std::set<std::string> examples;
  for (const WorkedExample& example : worked_examples()) {
    const Bytes bytes = from_hex(example.hex);
    examples.emplace(bytes.begin(), bytes.end());
  }
  EXPECT_TRUE(corpus == examples);
}

}  // namespace
}  // namespace rigcal::livox
