#include "apps/datagram_file.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "apps/lvx_datagrams.h"

namespace rigcal {
namespace {

class PcapDatagrams final : public DatagramFile {
 public:
  PcapDatagrams(PcapReader reader, double file_bytes) : reader_(std::move(reader)), file_bytes_(file_bytes) {}

  Expected<bool> next(Datagram& datagram) override {
    Expected<bool> more = reader_.next(datagram);
    if (more && *more) read_bytes_ += static_cast<double>(datagram.bytes.size()) + 60.0;  // headers of frame and file
    return more;
  }
  [[nodiscard]] std::string truncation() const override { return reader_.truncation(); }
  [[nodiscard]] FileNotes notes() const override {
    return {capture_findings(reader_.counters()), reader_.counters(), {}};
  }
  [[nodiscard]] double fraction() const override { return std::min(1.0, read_bytes_ / file_bytes_); }

 private:
  PcapReader reader_;
  double file_bytes_;
  double read_bytes_ = 0.0;
};

}  // namespace

Expected<std::unique_ptr<DatagramFile>> open_datagrams(const std::string& path) {
  if (is_lvx(path)) return open_lvx_datagrams(path);
  Expected<PcapReader> reader = PcapReader::open(path);
  if (!reader) return reader.error();
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  const double file_bytes = error || bytes == 0 ? 1.0 : static_cast<double>(bytes);
  return std::unique_ptr<DatagramFile>(std::make_unique<PcapDatagrams>(std::move(*reader), file_bytes));
}

}  // namespace rigcal
