#include "apps/capture/growing_datagrams.h"

#include <chrono>
#include <filesystem>
#include <thread>

#include "core/io/session_folder.h"

namespace rigcal {
namespace {

constexpr std::chrono::milliseconds growth_period{20};

}  // namespace

bool GrowingDatagrams::await_growth() const {
  if (heartbeat_ != nullptr) heartbeat_->beat();
  if (stop_.stop_requested() || progress_->has_ended() || progress_->parts() > part_) return false;
  std::this_thread::sleep_for(growth_period);
  return true;
}

// The part that is to be read next, or a later one where it is gone already.
Expected<void> GrowingDatagrams::open_part() {
  while (true) {
    const int newest = progress_->parts();
    const bool is_newest = part_ >= newest;
    const std::string path = is_newest ? progress_->path() : session_packets_part_path(progress_->path(), part_);
    Expected<PcapReader> opened = PcapReader::follow(path, [this] { return await_growth(); });
    const std::lock_guard switching(progress_->switching());
    if (is_newest && progress_->parts() != newest) continue;  // It may have got another name before it was opened.
    if (opened) {
      reader_ = *std::move(opened);
      return {};
    }
    std::error_code error;
    if (is_newest || std::filesystem::exists(path, error)) return opened.error();
    ++part_;
  }
}

Expected<bool> GrowingDatagrams::next(Datagram& datagram) {
  while (true) {
    if (!reader_) {
      const Expected<void> opened = open_part();
      if (stop_.stop_requested()) return false;
      if (!opened) return opened.error();
    }
    const Expected<bool> more = reader_->next(datagram);
    if (stop_.stop_requested()) return false;
    if (!more || *more) return more;
    if (part_ >= progress_->parts()) return false;
    earlier_ += reader_->counters();
    reader_.reset();
    ++part_;
  }
}

FileNotes GrowingDatagrams::notes() const {
  PcapCounters all = earlier_;
  if (reader_) all += reader_->counters();
  return {capture_findings(all), all, {}};
}

}  // namespace rigcal
