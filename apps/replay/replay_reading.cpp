#include "apps/replay/replay_reading.h"

#include <algorithm>
#include <utility>

namespace rigcal {

Expected<ReplayReading> ReplayReading::open(const std::string& file, const RunContext& context) {
  ReplayReading reading;
  reading.path_ = file;
  if (const auto opened = reading.rewind(); !opened) return opened.error();
  Datagram datagram;
  bool any = false;
  std::uint64_t count = 0;
  while (!context.cancelled()) {
    const Expected<bool> more = reading.read(datagram);
    if (!more) return more.error();
    if (!*more) break;
    if (++count % 4096 == 0) context.reporter.progress("look through", reading.file_->fraction());
    if (!reading.devices_.add(datagram)) {
      ++reading.left_out_;
    } else if (!any) {
      any = true;
      reading.first_ns_ = datagram.stamp_ns;
    }
  }
  reading.truncation_ = reading.file_->truncation();
  if (!reading.devices_.first_sample_ns())
    return input_error("no points of a Livox LiDAR are in it", file, "replay a recording of LiDARs");
  if (reading.devices_.has_overflowed())
    return input_error("packets come from more than " + std::to_string(RecordedDevices::kMost) + " addresses", file,
                       "keep the LiDARs only, for example with a filter of tcpdump");
  if (const auto opened = reading.rewind(); !opened) return opened.error();
  return reading;
}

Expected<void> ReplayReading::rewind() {
  auto file = open_datagrams(path_);
  if (!file) return file.error();
  file_ = *std::move(file);
  heard_ = {};
  return {};
}

Expected<bool> ReplayReading::read(Datagram& datagram) {
  Expected<bool> more = file_->next(datagram);
  datagram.stamp_ns = std::max<std::int64_t>(0, datagram.stamp_ns);  // Whatever the file says: differences must fit.
  return more;
}

Expected<bool> ReplayReading::next(Datagram& datagram) {
  while (true) {
    const Expected<bool> more = read(datagram);
    if (!more || !*more) return more;
    if (heard_.add(datagram)) return true;
  }
}

}  // namespace rigcal
