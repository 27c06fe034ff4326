#include "simdata/usb3/control_packet.h"

namespace rigcal::sim::usb3 {
namespace {

constexpr std::uint32_t key = 0x43563355;  // "U3VC"
constexpr std::uint16_t answer_wanted = 1U << 14U;
constexpr std::uint16_t read_command = 0x0800;
constexpr std::uint16_t write_command = 0x0802;
constexpr std::size_t read_bytes = 12;
constexpr std::size_t address_bytes = 8;

void write_header(ByteWriter& writer, std::uint16_t flags, std::uint16_t command, std::size_t payload,
                  std::uint16_t id) {
  writer.write(key);
  writer.write(flags);
  writer.write(command);
  writer.write(static_cast<std::uint16_t>(payload));
  writer.write(id);
}

}  // namespace

Expected<ControlCommand> parse_control(ByteView packet) {
  ByteReader reader(packet);
  if (reader.read<std::uint32_t>() != key) return input_error("no packet of USB3 Vision control", "byte 0");
  const auto flags = reader.read<std::uint16_t>();
  ControlCommand command;
  command.number = reader.read<std::uint16_t>();
  const auto payload = reader.read<std::uint16_t>();
  command.id = reader.read<std::uint16_t>();
  command.wants_answer = (flags & answer_wanted) != 0;
  if (!reader.ok() || reader.left() < payload) return input_error("the packet is cut", "byte 8");
  ByteReader body(reader.take(payload));
  if (command.number == read_command && payload == read_bytes) {
    command.kind = ControlCommand::Kind::read;
    command.address = body.read<std::uint64_t>();
    static_cast<void>(body.read<std::uint16_t>());
    command.count = body.read<std::uint16_t>();
  } else if (command.number == write_command && payload >= address_bytes) {
    command.kind = ControlCommand::Kind::write;
    command.address = body.read<std::uint64_t>();
    command.bytes = body.take(body.left());
  }
  return command;
}

std::vector<std::uint8_t> encode_read_answer(std::uint16_t id, ByteView bytes) {
  std::vector<std::uint8_t> answer;
  ByteWriter writer(answer);
  write_header(writer, 0, read_command + 1, bytes.size(), id);
  writer.write_bytes(bytes);
  return answer;
}

std::vector<std::uint8_t> encode_write_answer(std::uint16_t id, std::uint16_t written) {
  std::vector<std::uint8_t> answer;
  ByteWriter writer(answer);
  write_header(writer, 0, write_command + 1, 4, id);
  writer.write(std::uint16_t{0});
  writer.write(written);
  return answer;
}

std::vector<std::uint8_t> encode_refusal(const ControlCommand& command, gige::Status status) {
  std::vector<std::uint8_t> answer;
  ByteWriter writer(answer);
  write_header(writer, static_cast<std::uint16_t>(status), static_cast<std::uint16_t>(command.number | 1U), 0,
               command.id);
  return answer;
}

std::vector<std::uint8_t> encode_read(std::uint16_t id, std::uint64_t address, std::uint16_t count) {
  std::vector<std::uint8_t> packet;
  ByteWriter writer(packet);
  write_header(writer, answer_wanted, read_command, read_bytes, id);
  writer.write(address);
  writer.write(std::uint16_t{0});
  writer.write(count);
  return packet;
}

std::vector<std::uint8_t> encode_write(std::uint16_t id, std::uint64_t address, ByteView bytes) {
  std::vector<std::uint8_t> packet;
  ByteWriter writer(packet);
  write_header(writer, answer_wanted, write_command, address_bytes + bytes.size(), id);
  writer.write(address);
  writer.write_bytes(bytes);
  return packet;
}

}  // namespace rigcal::sim::usb3
