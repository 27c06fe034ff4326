#include "drivers/gige_codec/command.h"

#include <algorithm>
#include <optional>
#include <string>

#include "core/base/network_order.h"
#include "drivers/gige_codec/frame.h"
#include "drivers/gige_codec/stream_packet.h"

namespace rigcal::gige {
namespace {

constexpr std::uint8_t key = 0x42;
constexpr std::uint8_t ack_flag = 0x01;
constexpr std::uint8_t extended_flag = 0x10;  // Of a discovery: the ack may be a broadcast.

Error wrong(const std::string& what, std::size_t offset) {
  return input_error(what, "byte " + std::to_string(offset) + " of a GigE Vision command");
}

Expected<Request> decode_force_ip(ByteReader& reader) {
  ForceIpRequest request;
  const auto take = [&reader](auto& bytes) {
    const ByteView view = reader.take(bytes.size());
    std::copy(view.begin(), view.end(), bytes.begin());
  };
  static_cast<void>(reader.take(2));
  take(request.mac);
  for (Ipv4* ip : {&request.ip, &request.mask, &request.gateway}) {
    static_cast<void>(reader.take(12));
    take(*ip);
  }
  return Request(request);
}

Expected<Request> decode_resend(const CommandFrame& frame, ByteReader& reader) {
  if (frame.extended_ids) return wrong("block ids of 64 bits are not spoken here", 1);
  ResendRequest request;
  request.channel = read_network<std::uint16_t>(reader);
  request.block = read_network<std::uint16_t>(reader);
  request.first = read_network<std::uint32_t>(reader) & kPacketIdBits;
  request.last = read_network<std::uint32_t>(reader) & kPacketIdBits;
  if (request.first > request.last) return wrong("the packets to send again run backwards", kHeaderBytes + 4);
  return Request(request);
}

Expected<Request> decode_read_registers(ByteReader& reader) {
  ReadRegistersRequest request;
  while (reader.left() >= 4) request.addresses.push_back(read_network<std::uint32_t>(reader));
  return Request(std::move(request));
}

Expected<Request> decode_write_registers(ByteReader& reader) {
  WriteRegistersRequest request;
  while (reader.left() >= 8) {
    RegisterWrite& write = request.writes.emplace_back();
    write.address = read_network<std::uint32_t>(reader);
    write.value = read_network<std::uint32_t>(reader);
  }
  return Request(std::move(request));
}

// Payloads of one command are of one length, or of a multiple of a unit.
struct Shape {
  std::size_t shortest = 0;
  std::size_t longest = 0;
  std::size_t unit = 1;
};

std::optional<Shape> shape_of(Command command) {
  switch (command) {
    case Command::discovery:
      return Shape{0, 0};
    case Command::force_ip:
      return Shape{56, 56};
    case Command::packet_resend:
      return Shape{12, 12};
    case Command::read_registers:
      return Shape{4, kMaxControlPayload, 4};
    case Command::write_registers:
      return Shape{8, kMaxControlPayload, 8};
    case Command::read_memory:
      return Shape{8, 8};
    case Command::write_memory:
      return Shape{4, kMaxControlPayload};
    case Command::pending:
      break;
  }
  return std::nullopt;
}

struct Encoder {
  ByteWriter& writer;

  void operator()(const DiscoveryRequest&) const {}
  void operator()(const ForceIpRequest& request) const {
    writer.write_text({}, 2);
    writer.write_bytes(request.mac);
    for (const Ipv4& ip : {request.ip, request.mask, request.gateway}) {
      writer.write_text({}, 12);
      writer.write_bytes(ip);
    }
  }
  void operator()(const ResendRequest& request) const {
    write_network(writer, request.channel);
    write_network(writer, request.block);
    write_network(writer, request.first);
    write_network(writer, request.last);
  }
  void operator()(const ReadRegistersRequest& request) const {
    for (const std::uint32_t address : request.addresses) write_network(writer, address);
  }
  void operator()(const WriteRegistersRequest& request) const {
    for (const RegisterWrite& write : request.writes) {
      write_network(writer, write.address);
      write_network(writer, write.value);
    }
  }
  void operator()(const ReadMemoryRequest& request) const {
    write_network(writer, request.address);
    write_network(writer, std::uint16_t{0});
    write_network(writer, request.count);
  }
  void operator()(const WriteMemoryRequest& request) const {
    write_network(writer, request.address);
    writer.write_bytes(request.bytes);
  }
};

Command command_of(const Request& request) {
  constexpr std::array commands{Command::discovery,      Command::force_ip,        Command::packet_resend,
                                Command::read_registers, Command::write_registers, Command::read_memory,
                                Command::write_memory};
  static_assert(commands.size() == std::variant_size_v<Request>);
  return commands[request.index()];
}

}  // namespace

Expected<CommandFrame> parse_command(ByteView datagram) {
  ByteReader reader(datagram);
  const auto first = reader.read<std::uint8_t>();
  const auto flags = reader.read<std::uint8_t>();
  CommandFrame frame;
  frame.command = read_network<std::uint16_t>(reader);
  const auto length = read_network<std::uint16_t>(reader);
  frame.id = read_network<std::uint16_t>(reader);
  if (!reader.ok()) return wrong("it is shorter than a header", reader.offset());
  if (first != key) return wrong("it does not begin as a command", 0);
  if (frame.id == 0) return wrong("a command with the id 0", 6);
  if (length > reader.left()) return wrong("its payload is longer than the datagram", 4);
  frame.wants_ack = (flags & ack_flag) != 0;
  frame.extended_ids =
      (flags & extended_flag) != 0 && frame.command == static_cast<std::uint16_t>(Command::packet_resend);
  frame.payload = reader.take(length);
  return frame;
}

Expected<Request> decode_request(const CommandFrame& frame) {
  const auto command = static_cast<Command>(frame.command);
  const std::optional<Shape> shape = shape_of(command);
  if (!shape) return wrong("the command " + std::to_string(frame.command) + " is not known", 2);
  const std::size_t size = frame.payload.size();
  const bool longer_ids = command == Command::packet_resend && frame.extended_ids;
  if (!longer_ids && (size < shape->shortest || size > shape->longest || size % shape->unit != 0))
    return wrong("a payload of " + std::to_string(size) + " bytes does not fit the command", 4);
  ByteReader reader(frame.payload);
  switch (command) {
    case Command::force_ip:
      return decode_force_ip(reader);
    case Command::packet_resend:
      return decode_resend(frame, reader);
    case Command::read_registers:
      return decode_read_registers(reader);
    case Command::write_registers:
      return decode_write_registers(reader);
    case Command::read_memory: {
      ReadMemoryRequest request;
      request.address = read_network<std::uint32_t>(reader);
      static_cast<void>(reader.take(2));
      request.count = read_network<std::uint16_t>(reader);
      return Request(request);
    }
    case Command::write_memory: {
      WriteMemoryRequest request;
      request.address = read_network<std::uint32_t>(reader);
      const ByteView bytes = reader.take(reader.left());
      request.bytes.assign(bytes.begin(), bytes.end());
      return Request(std::move(request));
    }
    default:
      return Request(DiscoveryRequest{});
  }
}

std::vector<std::uint8_t> encode_request(const Request& request, std::uint16_t id) {
  std::vector<std::uint8_t> payload;
  ByteWriter writer(payload);
  std::visit(Encoder{writer}, request);
  const Command command = command_of(request);
  // A resend is answered by packets; a discovery may be answered by a broadcast.
  unsigned flags = command == Command::packet_resend ? 0U : ack_flag;
  if (command == Command::discovery) flags |= extended_flag;
  return make_frame(static_cast<std::uint16_t>(unsigned{key} << 8U | flags), static_cast<std::uint16_t>(command), id,
                    payload);
}

}  // namespace rigcal::gige
