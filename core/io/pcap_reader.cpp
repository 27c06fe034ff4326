#include "core/io/pcap_reader.h"

#include <optional>
#include <utility>

#include "core/io/capture_file.h"
#include "core/rig/text_file.h"

namespace rigcal {

struct PcapReader::State {
  explicit State(CaptureFile capture) : file(std::move(capture)) {}

  std::string path;
  CaptureFile file;
  IpReassembler reassembler;
  PcapCounters counters;
  std::uint32_t other_link_type = 0;  ///< The first that is not read.
  bool ended = false;
  std::string truncation;

  bool deliver(const CapturedFrame& frame, Datagram& datagram);
};

namespace {

std::string link_name(std::uint32_t link_type) {
  switch (link_type) {
    case 105:
    case 127:
      return "Wi-Fi in monitor mode";
    case 189:
    case 220:
    case 249:
      return "USB";
    case 9:
      return "PPP";
    default:
      return "unknown here";
  }
}

std::string count_of(std::uint64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace

/// True where the frame gave a datagram; otherwise it is counted.
bool PcapReader::State::deliver(const CapturedFrame& frame, Datagram& datagram) {
  const std::optional<LinkLayer> link = link_layer_of(frame.link_type);
  if (!frame.broken && !link) {
    if (++counters.other_link == 1) other_link_type = frame.link_type;
    return false;
  }
  IpPart part;
  const FrameKind kind = frame.broken ? FrameKind::malformed : find_udp(*link, frame.bytes, part);
  if (kind == FrameKind::ipv6) ++counters.ipv6;
  if (kind == FrameKind::not_udp) ++counters.not_udp;
  if (kind == FrameKind::malformed) {
    const bool cut = !frame.broken && frame.bytes.size() < frame.wire_bytes;
    ++(cut ? counters.cut : counters.malformed);
  }
  if (kind != FrameKind::udp_part) return false;
  if (!frame.stamp_ns) {
    ++counters.malformed;
    return false;
  }
  if (part.is_fragment()) {
    const std::optional<IpPart> whole = reassembler.add(part, *frame.stamp_ns);
    counters.parts = reassembler.counters();
    if (!whole) return false;
    part = *whole;
  }
  if (!parse_udp(part, datagram)) {
    ++counters.malformed;
    return false;
  }
  ++counters.datagrams;
  datagram.stamp_ns = *frame.stamp_ns;
  return true;
}

PcapReader::PcapReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
PcapReader::PcapReader(PcapReader&&) noexcept = default;
PcapReader& PcapReader::operator=(PcapReader&&) noexcept = default;
PcapReader::~PcapReader() = default;

Expected<PcapReader> PcapReader::open(const std::string& path) { return follow(path, {}); }

Expected<PcapReader> PcapReader::follow(const std::string& path, AwaitGrowth await_growth) {
  Expected<CaptureFile> file = CaptureFile::open(path, std::move(await_growth));
  if (!file) return file.error();
  auto state = std::make_unique<State>(std::move(*file));
  state->path = path;
  return PcapReader(std::move(state));
}

Expected<bool> PcapReader::next(Datagram& datagram) {
  State& state = *state_;
  if (state.ended) return false;
  for (CapturedFrame frame; state.file.next(frame);) {
    ++state.counters.frames;
    if (state.deliver(frame, datagram)) return true;
  }
  return end();
}

Expected<bool> PcapReader::end() {
  State& state = *state_;
  state.ended = true;
  state.reassembler.finish();
  state.counters.parts = state.reassembler.counters();
  const PcapCounters& counters = state.counters;
  if (!state.file.failure().empty()) return read_failure(state.path, state.file.failure());
  if (!state.file.damage().empty()) {
    state.truncation = "after frame " + std::to_string(counters.frames) + ": " + state.file.damage();
    if (counters.frames == 0) {
      return input_error("has no whole packet (" + state.file.damage() + ")", state.path, "record it again");
    }
  }
  if (counters.other_link > 0 && counters.other_link == counters.frames) {
    return input_error("has packets of the link type " + std::to_string(state.other_link_type) + " only (" +
                           link_name(state.other_link_type) + "), which is not read",
                       state.path, "record on an Ethernet, loopback or 'any' interface");
  }
  return false;
}

bool PcapReader::truncated() const { return !state_->truncation.empty(); }
const std::string& PcapReader::truncation() const { return state_->truncation; }
const PcapCounters& PcapReader::counters() const { return state_->counters; }

PcapCounters& PcapCounters::operator+=(const PcapCounters& more) {
  frames += more.frames;
  datagrams += more.datagrams;
  ipv6 += more.ipv6;
  not_udp += more.not_udp;
  cut += more.cut;
  other_link += more.other_link;
  malformed += more.malformed;
  parts += more.parts;
  return *this;
}

std::vector<std::string> capture_findings(const PcapCounters& counters) {
  std::vector<std::string> findings;
  if (counters.cut > 0) {
    findings.push_back(count_of(counters.cut, "packet was", "packets were") +
                       " cut short by the snapshot length of the recording; record with tcpdump -s 0");
  }
  if (counters.malformed > 0) {
    findings.push_back(count_of(counters.malformed, "packet was", "packets were") +
                       " left out, whose headers or stamps contradict themselves");
  }
  if (counters.other_link > 0) {
    findings.push_back(count_of(counters.other_link, "packet was", "packets were") +
                       " left out, from an interface of a link type that is not read");
  }
  const FragmentCounters& parts = counters.parts;
  if (parts.lost() > 0) {
    std::string text =
        count_of(parts.lost(), "fragmented packet", "fragmented packets") + " could not be put together:";
    if (parts.incomplete > 0) text += " " + std::to_string(parts.incomplete) + " for want of parts,";
    if (parts.contradictory > 0) {
      text += " " + std::to_string(parts.contradictory) + " with parts that contradict each other,";
    }
    if (parts.crowded_out > 0) text += " " + std::to_string(parts.crowded_out) + " because too many came at a time,";
    text.pop_back();
    findings.push_back(text);
  }
  return findings;
}

}  // namespace rigcal
