// A packet dump of any bytes: no crash, and every payload that is delivered can be read.
#include "core/io/pcap_reader.h"
#include "tests/fuzz/scratch_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const rigcal::ScratchFile file(bytes, size);
  rigcal::Expected<rigcal::PcapReader> reader = rigcal::PcapReader::open(file.path());
  if (!reader) return 0;
  rigcal::Datagram datagram;
  while (true) {
    const rigcal::Expected<bool> more = reader->next(datagram);
    if (!more || !*more) break;
    unsigned sum = 0;
    for (const std::uint8_t byte : datagram.bytes) sum += byte;
    if (sum > 255U * 65535U) __builtin_trap();
  }
  const rigcal::PcapCounters& counters = reader->counters();
  // Each frame is told once; a packet put together is told as a datagram or as malformed beside its fragments.
  const std::uint64_t told = counters.datagrams + counters.ipv6 + counters.not_udp + counters.cut +
                             counters.other_link + counters.malformed + counters.parts.fragments;
  if (told != counters.frames + counters.parts.whole) __builtin_trap();
  return 0;
}
