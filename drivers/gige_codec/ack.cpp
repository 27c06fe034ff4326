#include "drivers/gige_codec/ack.h"

#include <string>

#include "core/base/network_order.h"
#include "drivers/gige_codec/frame.h"

namespace rigcal::gige {
namespace {

constexpr std::uint16_t ack_of(Command command) {
  return static_cast<std::uint16_t>(static_cast<unsigned>(command) + 1U);
}

Error wrong(const std::string& what, std::size_t offset) {
  return input_error(what, "byte " + std::to_string(offset) + " of a GigE Vision ack");
}

struct Encoder {
  std::vector<std::uint8_t>& out;

  void operator()(const DeviceIdentity& identity) const { out = encode_identity(identity); }
  void operator()(const ForceIpAck&) const {}
  void operator()(const ReadRegistersAck& ack) const {
    ByteWriter writer(out);
    for (const std::uint32_t value : ack.values) write_network(writer, value);
  }
  void operator()(const WriteRegistersAck& ack) const { write_count(ack.written); }
  void operator()(const ReadMemoryAck& ack) const {
    ByteWriter writer(out);
    write_network(writer, ack.address);
    writer.write_bytes(ack.bytes);
  }
  void operator()(const WriteMemoryAck& ack) const { write_count(ack.written); }
  void operator()(const PendingAck& ack) const { write_count(ack.milliseconds); }
  void write_count(std::uint16_t count) const {
    ByteWriter writer(out);
    write_network(writer, std::uint16_t{0});
    write_network(writer, count);
  }
};

Command command_of(const Ack& ack) {
  constexpr std::array commands{Command::discovery,       Command::force_ip,    Command::read_registers,
                                Command::write_registers, Command::read_memory, Command::write_memory,
                                Command::pending};
  static_assert(commands.size() == std::variant_size_v<Ack>);
  return commands[ack.index()];
}

}  // namespace

Expected<AckFrame> parse_ack(ByteView datagram) {
  ByteReader reader(datagram);
  AckFrame frame;
  frame.status = static_cast<Status>(read_network<std::uint16_t>(reader));
  frame.ack = read_network<std::uint16_t>(reader);
  const auto length = read_network<std::uint16_t>(reader);
  frame.id = read_network<std::uint16_t>(reader);
  if (!reader.ok()) return wrong("it is shorter than a header", reader.offset());
  if (length > reader.left()) return wrong("its payload is longer than the datagram", 4);
  frame.payload = reader.take(length);
  return frame;
}

Expected<Ack> decode_ack(const AckFrame& frame) {
  ByteReader reader(frame.payload);
  const auto fits = [&frame](bool fit) { return fit && frame.payload.size() <= kMaxControlPayload; };
  const std::size_t size = frame.payload.size();
  const Error misfit = wrong("a payload of " + std::to_string(size) + " bytes does not fit the ack", 4);
  const auto read_count = [&reader] {
    static_cast<void>(reader.take(2));
    return read_network<std::uint16_t>(reader);
  };
  switch (frame.ack) {
    case ack_of(Command::discovery): {
      auto identity = decode_identity(frame.payload);
      if (!identity) return identity.error();
      return Ack(*std::move(identity));
    }
    case ack_of(Command::force_ip):
      return Ack(ForceIpAck{});
    case ack_of(Command::read_registers): {
      if (!fits(size % 4 == 0)) return misfit;
      ReadRegistersAck ack;
      while (reader.left() >= 4) ack.values.push_back(read_network<std::uint32_t>(reader));
      return Ack(std::move(ack));
    }
    case ack_of(Command::write_registers):
      if (!fits(size == 4)) return misfit;
      return Ack(WriteRegistersAck{read_count()});
    case ack_of(Command::read_memory): {
      if (!fits(size >= 4)) return misfit;
      ReadMemoryAck ack;
      ack.address = read_network<std::uint32_t>(reader);
      const ByteView bytes = reader.take(reader.left());
      ack.bytes.assign(bytes.begin(), bytes.end());
      return Ack(std::move(ack));
    }
    case ack_of(Command::write_memory):
      if (!fits(size == 4)) return misfit;
      return Ack(WriteMemoryAck{read_count()});
    case ack_of(Command::pending):
      if (!fits(size == 4)) return misfit;
      return Ack(PendingAck{read_count()});
    default:
      return wrong("the ack " + std::to_string(frame.ack) + " is not known", 2);
  }
}

std::vector<std::uint8_t> encode_ack(const Ack& ack, std::uint16_t id, Status status) {
  std::vector<std::uint8_t> payload;
  std::visit(Encoder{payload}, ack);
  return make_frame(static_cast<std::uint16_t>(status), ack_of(command_of(ack)), id, payload);
}

std::vector<std::uint8_t> make_refusal(const CommandFrame& frame, Status status) {
  return make_frame(static_cast<std::uint16_t>(status), static_cast<std::uint16_t>(frame.command + 1U), frame.id, {});
}

}  // namespace rigcal::gige
