#include "apps/recording/lvx_datagrams.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "core/clocks/leading_clock.h"
#include "core/io/input_file.h"
#include "core/rig/text_file.h"
#include "drivers/livox_codec/discovery.h"
#include "drivers/livox_codec/sample_packet.h"
#include "drivers/livox_codec/wire_fields.h"

namespace rigcal {
namespace {

/// Where the datagrams go; only the port tells what they are.
constexpr std::array<std::uint8_t, 4> host{127, 0, 0, 1};
constexpr std::uint16_t data_port = 56001;

class LvxDatagrams final : public DatagramFile {
 public:
  LvxDatagrams(LvxReader reader, std::string path, double file_bytes)
      : reader_(std::move(reader)), path_(std::move(path)), file_bytes_(file_bytes), clock_(reader_.frame_ns()) {}

  Expected<bool> next(Datagram& datagram) override {
    if (!started_) {  // the first package gives the time at which the devices tell who they are
      started_ = true;
      pending_ = read();
      if (!pending_ && !reader_.failure().empty()) return read_failure(path_, reader_.failure());
    }
    while (introduced_ < reader_.devices().size()) {
      if (introduce(introduced_++, datagram)) return true;
    }
    if (!pending_ && !read()) {
      if (!reader_.failure().empty()) return read_failure(path_, reader_.failure());
      return false;
    }
    pending_ = false;
    datagram = current_;
    return true;
  }
  [[nodiscard]] std::string truncation() const override { return reader_.truncation(); }
  [[nodiscard]] FileNotes notes() const override {
    return {lvx_findings(reader_.counters()), std::nullopt, reader_.devices()};
  }
  [[nodiscard]] double fraction() const override {
    return std::min(1.0, static_cast<double>(reader_.offset()) / file_bytes_);
  }

 private:
  static Endpoint source(std::size_t device, std::uint16_t port) {
    return {{0, 0, 0, static_cast<std::uint8_t>(device + 1)}, port};
  }

  bool introduce(std::size_t device, Datagram& datagram) {
    const LvxDevice& info = reader_.devices()[device];
    if (info.broadcast_code.size() != livox::kBroadcastCodeLength) return false;
    broadcast_ = livox::make_broadcast({info.broadcast_code, static_cast<livox::DeviceType>(info.type), 0}, 0);
    datagram = {clock_.now_ns(), source(device, livox::kDevicePort), {host, livox::kDiscoveryPort}, broadcast_};
    return true;
  }

  bool read() {
    LvxPackage package;
    if (!reader_.next(package)) return false;
    std::uint16_t port = livox::kPointSourcePort;
    if (const Expected<livox::SamplePacket> packet = livox::parse_sample_packet(package.packet)) {
      const livox::SampleHeader& header = packet->header;
      const bool pulses = header.timestamp_type == livox::TimestampType::pps_only;
      clock_.add(static_cast<int>(package.device), header.device_stamp_ns, pulses, package.frame);
      if (header.data_type == livox::DataType::imu) port = livox::kImuSourcePort;
    }
    current_ = {clock_.now_ns(), source(package.device, port), {host, data_port}, package.packet};
    return true;
  }

  LvxReader reader_;
  std::string path_;
  double file_bytes_;
  LeadingClock clock_;
  bool started_ = false;
  bool pending_ = false;  ///< `current_` was read and not yet delivered.
  Datagram current_;
  std::size_t introduced_ = 0;
  std::vector<std::uint8_t> broadcast_;
};

}  // namespace

bool is_lvx(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;  // What a pipe has given it does not give again.
  Expected<InputFile> file = InputFile::open(path);
  if (!file) return false;
  constexpr std::string_view begin = "livox_tech";
  const ByteView bytes = file->peek(begin.size());
  return std::equal(bytes.begin(), bytes.end(), begin.begin(), begin.end());
}

Expected<std::unique_ptr<DatagramFile>> open_lvx_datagrams(const std::string& path) {
  Expected<LvxReader> reader = LvxReader::open(path);
  if (!reader) return reader.error();
  const double bytes = std::max(1.0, static_cast<double>(reader->size().value_or(0)));
  return std::unique_ptr<DatagramFile>(std::make_unique<LvxDatagrams>(std::move(*reader), path, bytes));
}

}  // namespace rigcal
