// IP fragments of any kind: no crash, memory within its bound, and a packet comes out only where every byte of it was
// sent. The bytes are a list of fragments: id, unit offset (2), flags and size, step of time, then the data.
#include "core/base/bytes.h"
#include "core/io/ip_reassembler.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  rigcal::ByteReader reader(rigcal::ByteView(bytes, size));
  rigcal::IpReassembler reassembler;
  std::int64_t now_ns = 0;
  std::uint64_t sent = 0;
  while (reader.left() > 0) {
    rigcal::IpPart part;
    part.id = reader.read<std::uint8_t>();
    part.offset = std::size_t{8} * (reader.read<std::uint16_t>() & 0x1FFFU);
    const auto flags = reader.read<std::uint8_t>();
    part.more_to_come = (flags & 0x80U) != 0;
    now_ns += std::int64_t{reader.read<std::int8_t>()} * 10'000'000;
    part.data = reader.take(flags & 0x7FU);
    if (!reader.ok()) break;
    ++sent;
    const std::optional<rigcal::IpPart> whole = reassembler.add(part, now_ns);
    if (whole && (whole->data.size() > 65'515 || whole->is_fragment() || whole->data.empty())) __builtin_trap();
  }
  reassembler.finish();
  const rigcal::FragmentCounters& counters = reassembler.counters();
  if (counters.fragments != sent || counters.whole + counters.lost() > sent) __builtin_trap();
  return 0;
}
