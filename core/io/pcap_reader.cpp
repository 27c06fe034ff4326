#include "core/io/pcap_reader.h"

#include <pcap/pcap.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

#include "core/io/link_layer.h"
#include "core/rig/text_file.h"

namespace rigcal {

struct PcapReader::State {
  std::string path;
  std::vector<char> file_buffer;
  std::FILE* file = nullptr;  ///< Owned by `capture`.
  pcap_t* capture = nullptr;
  LinkLayer link = LinkLayer::raw_ip;
  PcapCounters counters;
  bool ended = false;
  std::string truncation;

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (capture != nullptr) pcap_close(capture);
  }
};

namespace {

/// libpcap reads frame by frame; a large buffer below it keeps the system calls few.
constexpr std::size_t file_buffer_bytes = std::size_t{1} << 20;
/// Seconds that fit into int64 nanoseconds.
constexpr std::int64_t max_seconds = 9'223'372'035;

std::optional<LinkLayer> link_layer_of(int link_type) {
  switch (link_type) {
    case DLT_EN10MB:
      return LinkLayer::ethernet;
    case DLT_RAW:
    case 101:  // LINKTYPE_RAW where it differs from the system's DLT_RAW
    case DLT_IPV4:
      return LinkLayer::raw_ip;
    case DLT_LINUX_SLL:
      return LinkLayer::cooked_v1;
    case DLT_LINUX_SLL2:
      return LinkLayer::cooked_v2;
    case DLT_NULL:
    case DLT_LOOP:
      return LinkLayer::null;
    default:
      return std::nullopt;
  }
}

Error open_error(const std::string& path, const std::string& reason) {
  if (reason.find("truncated") != std::string::npos) {
    return input_error("ends within the header of the capture file", path, "record it again");
  }
  return input_error("is no packet dump that can be read (" + reason + ")", path, "give a pcap or pcapng file");
}

}  // namespace

PcapReader::PcapReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
PcapReader::PcapReader(PcapReader&&) noexcept = default;
PcapReader& PcapReader::operator=(PcapReader&&) noexcept = default;
PcapReader::~PcapReader() = default;

Expected<PcapReader> PcapReader::open(const std::string& path) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->file_buffer.resize(file_buffer_bytes);
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return cannot_read(path, errno);
  struct stat status = {};
  const bool known = fstat(fileno(file), &status) == 0;
  if (known && (S_ISDIR(status.st_mode) || (S_ISREG(status.st_mode) && status.st_size == 0))) {
    std::fclose(file);
    if (S_ISDIR(status.st_mode)) return cannot_read(path, EISDIR);
    return input_error("is empty", path, "give a packet dump (pcap or pcapng)");
  }
  std::setvbuf(file, state->file_buffer.data(), _IOFBF, file_buffer_bytes);
  char reason[PCAP_ERRBUF_SIZE] = {};
  state->capture = pcap_fopen_offline_with_tstamp_precision(file, PCAP_TSTAMP_PRECISION_NANO, reason);
  if (state->capture == nullptr) {
    std::fclose(file);
    return open_error(path, reason);
  }
  state->file = file;
  const int link_type = pcap_datalink(state->capture);
  const std::optional<LinkLayer> link = link_layer_of(link_type);
  if (!link) {
    const char* name = pcap_datalink_val_to_name(link_type);
    return input_error(std::string("has packets of the link type ") + (name != nullptr ? name : "?") + " (" +
                           std::to_string(link_type) + "), which is not read",
                       path, "record on an Ethernet, loopback or 'any' interface");
  }
  state->link = *link;
  return PcapReader(std::move(state));
}

Expected<bool> PcapReader::next(Datagram& datagram) {
  State& state = *state_;
  while (!state.ended) {
    pcap_pkthdr* header = nullptr;
    const u_char* bytes = nullptr;
    const int got = pcap_next_ex(state.capture, &header, &bytes);
    if (got == PCAP_ERROR_BREAK) {
      state.ended = true;
      break;
    }
    if (got != 1) {
      state.ended = true;
      state.truncation = "after frame " + std::to_string(state.counters.frames) + ": " + pcap_geterr(state.capture);
      if (state.counters.frames > 0) break;
      return input_error("has no whole packet (" + std::string(pcap_geterr(state.capture)) + ")", state.path,
                         "record it again");
    }
    ++state.counters.frames;
    const std::int64_t seconds = header->ts.tv_sec;
    const std::int64_t nanoseconds = header->ts.tv_usec;  // nanoseconds, as asked for
    if (seconds < 0 || seconds > max_seconds || nanoseconds < 0 || nanoseconds >= 1'000'000'000) {
      ++state.counters.malformed;
      continue;
    }
    switch (parse_udp(state.link, ByteView(bytes, header->caplen), datagram)) {
      case FrameKind::udp:
        ++state.counters.datagrams;
        datagram.stamp_ns = seconds * 1'000'000'000 + nanoseconds;
        return true;
      case FrameKind::not_udp:
        ++state.counters.not_udp;
        break;
      case FrameKind::fragment:
        ++state.counters.fragments;
        break;
      case FrameKind::malformed:
        ++state.counters.malformed;
        break;
    }
  }
  return false;
}

bool PcapReader::truncated() const { return !state_->truncation.empty(); }
const std::string& PcapReader::truncation() const { return state_->truncation; }
const PcapCounters& PcapReader::counters() const { return state_->counters; }

}  // namespace rigcal
