#include "core/io/lvx_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "core/rig/text_file.h"

namespace rigcal {
namespace {

constexpr std::string_view signature("livox_tech\0\0\0\0\0\0", 16);
constexpr std::size_t code_bytes = 16;
constexpr std::size_t sample_header_bytes = 18;
constexpr std::size_t data_type_at = 9;  ///< In a sample header.
constexpr std::size_t points_1_0 = 100;
constexpr std::size_t point_bytes = 13;  ///< Of version 1.0 and, by chance, of data type 0 on the wire.

/// Length of a sample packet by its data type; types 7 and 8 are not in the specification but are recorded.
constexpr std::array<std::size_t, 9> packet_bytes{1318, 918, 1362, 978, 1362, 786, 42, 1278, 678};

std::string printable(ByteView bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    if (byte == 0) break;
    text += byte > 0x20 && byte < 0x7F ? static_cast<char>(byte) : '?';
  }
  return text;
}

/// What cannot be a coordinate becomes 0: three of them are a slot without a return.
std::int32_t millimetres(float metres) {
  const double value = std::round(1000.0 * static_cast<double>(metres));
  constexpr double most = std::numeric_limits<std::int32_t>::max();
  return std::abs(value) <= most ? static_cast<std::int32_t>(value) : 0;
}

/// Floats in metres to whole millimetres, in place.
void to_wire(std::vector<std::uint8_t>& packet) {
  for (std::size_t i = 0; i < points_1_0; ++i) {
    std::uint8_t* const point = packet.data() + sample_header_bytes + i * point_bytes;
    std::array<float, 3> metres{};
    std::memcpy(metres.data(), point, sizeof(metres));
    const bool finite = std::all_of(metres.begin(), metres.end(), [](float value) { return std::isfinite(value); });
    std::array<std::int32_t, 3> whole{};
    for (std::size_t axis = 0; finite && axis < 3; ++axis) whole[axis] = millimetres(metres[axis]);
    std::memcpy(point, whole.data(), sizeof(whole));
  }
}

}  // namespace

Expected<LvxReader> LvxReader::open(const std::string& path) {
  Expected<InputFile> file = InputFile::open(path);
  if (!file) return file.error();
  LvxReader reader(std::move(*file));
  if (const Expected<void> head = reader.read_head(); !head) return head.error();
  return reader;
}

Expected<void> LvxReader::read_head() {
  const std::string path = file_.path();
  const auto cut = [&] {
    if (!file_.failure().empty()) return read_failure(path, file_.failure());
    return input_error("ends within the header of the .lvx file", path, "record it again");
  };
  const ByteView start = file_.take(signature.size());
  if (!file_.failure().empty()) return read_failure(path, file_.failure());
  if (start.empty() || !std::equal(start.begin(), start.end(), signature.begin(),
                                   [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); })) {
    return input_error("is no .lvx file", path, "give a recording of Livox Viewer or the Livox SDK");
  }
  const ByteView versions = file_.take(8);  // and a magic number that only viewers look at
  if (versions.size() < 8) return cut();
  minor_ = versions[1];
  if (versions[0] != 1 || versions[1] > 1) {
    return input_error(
        "has version " + std::to_string(versions[0]) + "." + std::to_string(versions[1]) + " of the .lvx format", path,
        "versions 1.0 and 1.1 are read: record the packets with tcpdump instead");
  }
  const ByteView own = file_.take(minor_ == 0 ? 1 : 5);
  if (own.size() < (minor_ == 0 ? 1U : 5U)) return cut();
  if (minor_ == 1) {
    const auto frame_ms = ByteReader(own).read<std::uint32_t>();
    if (frame_ms == 0 || frame_ms > 10'000) {
      return input_error("says that a frame lasts " + std::to_string(frame_ms) + " ms", path + ", at byte 24",
                         "record it again");
    }
    frame_ns_ = std::int64_t{frame_ms} * 1'000'000;
  }
  const std::size_t count = own.back();
  if (count == 0) return input_error("lists no devices", path, "record it again with the LiDARs connected");
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t size = minor_ == 0 ? 58 : 59;
    const ByteView info = file_.take(size);
    if (info.size() < size) return cut();
    read_device(info);
  }
  return {};
}

void LvxReader::read_device(ByteView info) {
  ByteReader reader(info);
  LvxDevice& device = devices_.emplace_back();
  device.broadcast_code = printable(reader.take(code_bytes));
  static_cast<void>(reader.take(code_bytes));  // of the Hub that it is behind
  device.index = reader.read<std::uint8_t>();
  device.type = reader.read<std::uint8_t>();
  device.has_extrinsics = minor_ == 0 || reader.read<std::uint8_t>() != 0;
  for (float& value : device.roll_pitch_yaw_deg) value = reader.read<float>();
  for (float& value : device.translation_m) value = reader.read<float>();
}

bool LvxReader::end(std::uint64_t offset, const char* reason) {
  ended_ = true;
  truncation_ =
      "after frame " + std::to_string(counters_.frames) + ", at byte " + std::to_string(offset) + ": " + reason;
  return false;
}

bool LvxReader::begin_frame() {
  const std::uint64_t offset = file_.offset();
  const std::size_t size = minor_ == 0 ? 32 : 24;
  const ByteView head = file_.take(size);
  if (head.empty() && file_.failure().empty()) {
    ended_ = true;
    return false;
  }
  if (head.size() < size) return end(offset, "the header of a frame is cut");
  ByteReader reader(head);
  if (reader.read<std::uint64_t>() != offset) return end(offset, "no frame begins where one should");
  frame_end_ = reader.read<std::uint64_t>();
  if (frame_end_ < offset + size) return end(offset, "a frame ends before it begins");
  if (file_.size() && frame_end_ > *file_.size()) return end(offset, "a frame is cut");
  ++counters_.frames;
  return true;
}

/// Past a package that does not fit.
bool LvxReader::leave_frame() {
  ++counters_.damaged_frames;
  return file_.skip(frame_end_ - file_.offset()) || end(file_.offset(), "a frame is cut");
}

bool LvxReader::read_package(LvxPackage& package) {
  const std::uint64_t left = frame_end_ - file_.offset();
  const ByteView head = file_.peek(1 + sample_header_bytes);
  if (left < 1 + sample_header_bytes || head.size() < 1 + sample_header_bytes) return false;
  const std::uint8_t index = head[0];
  const std::uint8_t type = head[1 + data_type_at];
  if (type >= packet_bytes.size() || (minor_ == 0 && type != 0)) return false;
  const std::size_t size = packet_bytes[type];
  if (left < 1 + size) return false;
  const ByteView whole = file_.take(1 + size);
  if (whole.size() < 1 + size) return false;
  const auto device =
      std::find_if(devices_.begin(), devices_.end(), [index](const LvxDevice& each) { return each.index == index; });
  package.device = static_cast<std::size_t>(device - devices_.begin());
  package.frame = counters_.frames - 1;
  package.packet = whole.subspan(1);
  return true;
}

bool LvxReader::next(LvxPackage& package) {
  while (!ended_) {
    if (file_.offset() >= frame_end_) {
      if (!begin_frame()) return false;
      continue;
    }
    if (!read_package(package)) {
      if (!leave_frame()) return false;
      continue;
    }
    if (package.device >= devices_.size()) {
      ++counters_.unknown_devices;
      continue;
    }
    ++counters_.packages;
    if (minor_ == 0) {
      packet_.assign(package.packet.begin(), package.packet.end());
      to_wire(packet_);
      package.packet = packet_;
    }
    return true;
  }
  return false;
}

std::vector<std::string> lvx_findings(const LvxCounters& counters) {
  std::vector<std::string> findings;
  if (counters.damaged_frames > 0) {
    findings.push_back(std::to_string(counters.damaged_frames) + " of " + std::to_string(counters.frames) +
                       " frames are damaged and were used up to the damage only");
  }
  if (counters.unknown_devices > 0) {
    findings.push_back(std::to_string(counters.unknown_devices) +
                       " packages of devices that the file does not list were left out");
  }
  return findings;
}

}  // namespace rigcal
