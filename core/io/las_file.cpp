#include "core/io/las_file.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/seconds.h"
#include "core/base/version.h"

namespace rigcal {
namespace {

constexpr std::uint16_t header_bytes = 375;
constexpr std::uint16_t plain_point_bytes = 20;
constexpr std::uint16_t timed_point_bytes = 28;
constexpr std::uint8_t one_return = 1 | 1 << 3;  // return number 1, number of returns 1
constexpr std::uint16_t standard_gps_time = 1;   // global encoding, bit 0

// From 1970 to 6 January 1980, when GPS time began; less the leap seconds since, more what "adjusted" takes off.
constexpr std::int64_t utc_less_adjusted_gps_s = 315'964'800 - 18 + 1'000'000'000;

double adjusted_gps_s(std::int64_t utc_ns) {
  // The small difference first: a double holds it to a fraction of a microsecond.
  return seconds_of_ns(utc_ns - utc_less_adjusted_gps_s * ns_per_second);
}

struct Day {
  std::uint16_t of_year = 0;
  std::uint16_t year = 0;
};

Day day_of(std::int64_t utc_ns) {
  namespace chr = std::chrono;
  const chr::sys_days day = chr::floor<chr::days>(chr::sys_time<chr::nanoseconds>(chr::nanoseconds(utc_ns)));
  const chr::year year = chr::year_month_day(day).year();
  const auto before = day - chr::sys_days(year / chr::January / 1);
  return {static_cast<std::uint16_t>(before.count() + 1), static_cast<std::uint16_t>(int{year})};
}

}  // namespace

Expected<LasWriter> LasWriter::create(const std::string& path, const Options& options) {
  Expected<OutputFile> file = OutputFile::create(path);
  if (!file) return file.error();
  LasWriter writer(std::move(*file), options);
  writer.file_.write(writer.header());
  return writer;
}

void LasWriter::write(std::span<const Point> points, std::int64_t stamp_ns, double shot_interval_ns) {
  const std::uint16_t size = options_.timed ? timed_point_bytes : plain_point_bytes;
  for (const Point& point : points) {
    const std::array<float, 3> position{point.x, point.y, point.z};
    std::array<std::int32_t, 3> whole{};
    bool fits = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double steps = std::round(static_cast<double>(position[axis]) / scale_m);
      fits = fits && std::abs(steps) <= static_cast<double>(std::numeric_limits<std::int32_t>::max());
      if (fits) whole[axis] = static_cast<std::int32_t>(steps);
    }
    if (!fits) {
      ++left_out_;
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least_[axis] = points_ == 0 ? whole[axis] : std::min(least_[axis], whole[axis]);
      most_[axis] = points_ == 0 ? whole[axis] : std::max(most_[axis], whole[axis]);
    }
    const auto intensity = static_cast<std::uint16_t>(point.reflectivity * 256);
    std::uint8_t* room = file_.reserve(size);
    std::memset(room, 0, size);  // class 0 (never classified), scan angle 0
    std::memcpy(room, whole.data(), sizeof(whole));
    std::memcpy(room + 12, &intensity, sizeof(intensity));
    room[14] = one_return;
    room[17] = point.tag;
    std::memcpy(room + 18, &options_.source_id, sizeof(options_.source_id));
    if (options_.timed) {
      const std::int64_t utc_ns = stamp_ns + static_cast<std::int64_t>(point.shot * shot_interval_ns);
      if (!first_ns_) first_ns_ = utc_ns;
      const double time = adjusted_gps_s(utc_ns);
      std::memcpy(room + 20, &time, sizeof(time));
    }
    ++points_;
  }
}

// What is not put stays 0: no project, no variable length records, no waveforms, no offset, no second returns.
std::string LasWriter::header() const {
  std::string bytes(header_bytes, '\0');
  const auto put = [&bytes](std::size_t at, auto value) { std::memcpy(bytes.data() + at, &value, sizeof(value)); };
  const auto put_text = [&bytes](std::size_t at, const std::string& text) { bytes.replace(at, text.size(), text); };
  const Day day = first_ns_ ? day_of(*first_ns_) : Day{};
  // Readers of older versions look at counts of 32 bits, which are to be 0 where the points are too many.
  const bool fits = points_ <= std::numeric_limits<std::uint32_t>::max();
  const auto old_count = static_cast<std::uint32_t>(fits ? points_ : 0);
  put_text(0, "LASF");
  put(4, options_.source_id);
  put(6, options_.timed ? standard_gps_time : std::uint16_t{0});
  put(24, std::array<std::uint8_t, 2>{1, 4});
  put_text(26, "OTHER");
  put_text(58, (std::string("rigcal ") + version()).substr(0, 32));
  put(90, day.of_year);
  put(92, day.year);
  put(94, header_bytes);
  put(96, std::uint32_t{header_bytes});  // where the points begin
  put(104, static_cast<std::uint8_t>(options_.timed ? 1 : 0));
  put(105, options_.timed ? timed_point_bytes : plain_point_bytes);
  put(107, old_count);
  put(111, old_count);  // of the first return
  put(131, std::array<double, 3>{scale_m, scale_m, scale_m});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(179 + 16 * axis, most_[axis] * scale_m);
    put(187 + 16 * axis, least_[axis] * scale_m);
  }
  put(247, points_);
  put(255, points_);  // of the first return
  return bytes;
}

Expected<void> LasWriter::finish() {
  file_.overwrite(0, header());
  return file_.close();
}

}  // namespace rigcal
