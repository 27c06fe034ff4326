#include "apps/capture/capture_dashboard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "apps/capture/capture_text.h"
#include "core/base/text.h"
#include "core/turntable/coach.h"

namespace rigcal {
namespace {

constexpr int bar_width = 24;
constexpr std::size_t shown_news = 4;

std::string bar(double share) {
  const auto done = static_cast<std::size_t>(std::lround(std::clamp(share, 0.0, 1.0) * bar_width));
  return "[" + std::string(done, '#') + std::string(bar_width - done, ' ') + "]";
}

std::string stops_line(const CaptureStatus& status) {
  const CaptureProgress& progress = status.progress;
  const bool is_capturing = progress.state == CaptureState::capturing;
  const double share = is_capturing && progress.dwell_s > 0.0 ? progress.rested_s / progress.dwell_s : 0.0;
  std::string line = bar(progress.is_full ? 1.0 : share) + " ";
  if (progress.wanted_stops > 0) line += std::to_string(progress.stops) + " of ";
  line +=
      counted(static_cast<std::uint64_t>(progress.wanted_stops > 0 ? progress.wanted_stops : progress.stops), "stop");
  if (progress.short_stops > 0) line += ", " + std::to_string(progress.short_stops) + " left early";
  if (status.table_deg) {
    std::array<char, 48> table{};
    std::snprintf(table.data(), table.size(), ", table at %.2f deg", *status.table_deg);
    line += table.data();
  }
  return line;
}

std::string duration_text(double seconds) {
  if (seconds < 600.0) return std::to_string(std::lround(seconds)) + " s";
  if (seconds < 36'000.0) return std::to_string(std::lround(seconds / 60.0)) + " min";
  return std::to_string(std::lround(std::min(seconds, 3.6e9) / 3600.0)) + " h";
}

std::string disk_line(const CaptureStatus& status) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "disk: %.1f GB free, %.1f MB/s",
                1e-9 * static_cast<double>(status.disk->free_bytes), 1e-6 * status.disk->bytes_per_s);
  std::string line = text.data();
  if (status.disk->seconds_left) line += ", full in " + duration_text(*status.disk->seconds_left);
  return line;
}

std::string delay_line(const CaptureStatus& status) {
  std::array<char, 79> text{};
  std::snprintf(text.data(), text.size(), "delays: a packet %.0f ms at most, a write %.0f ms at most",
                1e3 * status.worst_wait_s, 1e3 * status.worst_write_s);
  return text.data();
}

}  // namespace

std::vector<std::string> dashboard_lines(const CaptureStatus& status, const std::vector<std::string>& calibration) {
  std::vector<std::string> lines;
  if (status.progress.state != CaptureState::idle) {
    lines.push_back(std::string(to_string(status.progress.state)) + " | " + advice(status.progress));
    lines.push_back(stops_line(status));
  }
  const std::vector<std::string> sensors = capture_lines(status);
  lines.insert(lines.end(), sensors.begin(), sensors.end());
  if (status.disk) lines.insert(lines.end(), {disk_line(status), delay_line(status)});
  for (const std::string& thread : status.stuck_threads) lines.push_back("not moving: " + thread);
  lines.insert(lines.end(), calibration.begin(), calibration.end());
  const std::size_t shown = std::min(status.news.size(), shown_news);
  lines.insert(lines.end(), status.news.end() - static_cast<std::ptrdiff_t>(shown), status.news.end());
  for (std::string& line : lines) line.resize(std::min<std::size_t>(line.size(), 79));
  return lines;
}

std::vector<std::string> new_lines(const CaptureStatus& status, std::uint64_t told) {
  const std::uint64_t fresh = status.events - std::min(told, status.events);
  const std::size_t count = std::min<std::uint64_t>(fresh, status.news.size());
  return {status.news.end() - static_cast<std::ptrdiff_t>(count), status.news.end()};
}

}  // namespace rigcal
