#include "apps/recording/datagram_file.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "apps/recording/lvx_datagrams.h"
#include "core/base/seconds.h"
#include "core/base/text.h"
#include "core/clocks/onward_time.h"
#include "core/io/session_folder.h"

namespace rigcal {
namespace {

double bytes_of(const std::string& path) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  return error ? 0.0 : static_cast<double>(bytes);
}

/// One file, or the parts of a recording one after the other.
class PcapDatagrams final : public DatagramFile {
 public:
  PcapDatagrams(PcapReader reader, std::vector<std::string> later, double bytes)
      : reader_(std::move(reader)), later_(std::move(later)), bytes_(std::max(bytes, 1.0)) {}

  Expected<bool> next(Datagram& datagram) override {
    while (reader_) {
      Expected<bool> more = reader_->next(datagram);
      if (!more && next_part_ > 0) return end_before_part(more.error());
      if (more && *more) take(datagram);
      if (!more || *more || next_part_ == later_.size()) return more;
      add_up();
      Expected<PcapReader> opened = PcapReader::open(later_[next_part_++]);
      if (!opened) return end_before_part(opened.error());
      reader_ = *std::move(opened);
    }
    return false;
  }
  [[nodiscard]] std::string truncation() const override {
    return truncation_.empty() && reader_ ? reader_->truncation() : truncation_;
  }
  [[nodiscard]] FileNotes notes() const override {
    PcapCounters all = earlier_;
    if (reader_) all += reader_->counters();
    FileNotes notes{capture_findings(all), all, {}};
    if (const std::string step = step_text(); !step.empty()) notes.findings.push_back(step);
    return notes;
  }
  [[nodiscard]] double fraction() const override { return std::min(1.0, read_bytes_ / bytes_); }

 private:
  void take(Datagram& datagram) {
    read_bytes_ += static_cast<double>(datagram.bytes.size()) + 60.0;  // headers of frame and file
    datagram.stamp_ns = time_.add(datagram.stamp_ns, earlier_.frames + reader_->counters().frames);
  }
  // Empty where the clock of the recording machine was never set back.
  [[nodiscard]] std::string step_text() const {
    if (time_.steps() == 0) return {};
    std::string text = "the clock of the recording machine was set back by " +
                       fixed_text(seconds_of_ns(time_.first_step_ns()), 1) + " s at frame " +
                       std::to_string(time_.first_step_place());
    if (time_.steps() > 1) text += ", and " + std::to_string(time_.steps() - 1) + " more time(s)";
    return text + "; time goes on from there";
  }
  // What the part that is over has told.
  void add_up() {
    earlier_ += reader_->counters();
    if (truncation_.empty()) truncation_ = reader_->truncation();
  }
  // A power cut may leave the newest part without its head, or without a whole packet; what is before it is whole.
  Expected<bool> end_before_part(const Error& error) {
    if (error.kind == ErrorKind::system) return error;
    truncation_ = "ends before its last part: " + error.what;
    reader_.reset();
    return false;
  }

  std::optional<PcapReader> reader_;  ///< Of the part that is read; nothing where there is none to be read.
  std::vector<std::string> later_;
  std::size_t next_part_ = 0;
  PcapCounters earlier_;
  OnwardTime time_;
  std::string truncation_;
  double bytes_;
  double read_bytes_ = 0.0;
};

}  // namespace

Expected<std::unique_ptr<DatagramFile>> open_datagrams(const std::string& path) {
  if (is_lvx(path)) return open_lvx_datagrams(path);
  std::vector<std::string> parts = session_packet_parts(path);
  double bytes = 0.0;
  for (const std::string& part : parts) bytes += bytes_of(part);
  Expected<PcapReader> reader = PcapReader::open(parts.front());
  if (!reader) return reader.error();
  parts.erase(parts.begin());
  return std::unique_ptr<DatagramFile>(std::make_unique<PcapDatagrams>(*std::move(reader), std::move(parts), bytes));
}

}  // namespace rigcal
