#include "apps/recording/table_angles.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "core/base/text.h"
#include "core/io/frame_files.h"
#include "core/io/recorded_table.h"

namespace rigcal {
namespace {

constexpr double most_off_rad = to_rad(2.0);

/// How long the rig sways after a table has arrived.
constexpr std::int64_t settling_ns = 3'000'000'000;
/// A table that turns is heard ten times a second.
constexpr std::int64_t turning_ns = 1'000'000'000;
constexpr double same_angle_deg = 0.1;

// Of a table that cannot be asked, which says where it is once: when it arrives, and the rig rests only after that.
// What was said before the rig left the stop before, or on the way, is none.
std::optional<double> angle_on_arrival(const std::vector<TableAngle>& angles, std::int64_t left_ns, const Stop& stop) {
  const auto before = std::lower_bound(angles.begin(), angles.end(), stop.start_ns,
                                       [](const TableAngle& angle, std::int64_t ns) { return angle.stamp_ns < ns; });
  if (before == angles.begin()) return std::nullopt;
  const TableAngle& last = *std::prev(before);
  if (last.stamp_ns <= left_ns || stop.start_ns - last.stamp_ns > settling_ns) return std::nullopt;
  const bool turned = std::any_of(angles.begin(), before, [&last](const TableAngle& angle) {
    const double off_deg = std::remainder(angle.angle_deg - last.angle_deg, 360.0);
    return last.stamp_ns - angle.stamp_ns < turning_ns && std::abs(off_deg) > same_angle_deg;
  });
  return turned ? std::nullopt : std::optional<double>(last.angle_deg);
}

}  // namespace

std::vector<TableAngle> session_table_angles(const std::string& session, Reporter& reporter) {
  const std::string path = (std::filesystem::path(session) / "turntable.csv").string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return {};
  const Expected<RecordedTable> table = read_recorded_table(path, session);
  if (table && !table->torn.empty()) reporter.warn(table->torn);
  Expected<std::vector<TableAngle>> angles = table ? parse_turntable(table->text, path) : table.error();
  if (angles) return *std::move(angles);
  reporter.warn("the table's angles are not used: " + angles.error().message());
  return {};
}

std::optional<double> angle_in_stop(const std::vector<TableAngle>& angles, const Stop& stop) {
  const auto first = std::lower_bound(angles.begin(), angles.end(), stop.start_ns,
                                      [](const TableAngle& angle, std::int64_t ns) { return angle.stamp_ns < ns; });
  // Of a table that counts within a turn 0.00 and 359.99 are neighbours.
  double beyond_first = 0.0;
  int count = 0;
  for (auto angle = first; angle != angles.end() && angle->stamp_ns <= stop.end_ns; ++angle) {
    beyond_first += std::remainder(angle->angle_deg - first->angle_deg, 360.0);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return first->angle_deg + beyond_first / count;
}

TableTurns table_turns(const Rig& rig, const std::vector<TableAngle>& angles, const std::vector<Stop>& stops) {
  TableTurns turns;
  turns.R_previous_this.resize(stops.size());
  if (!rig.turntable || !rig.turntable->axis || angles.empty()) return turns;
  std::optional<double> before;
  std::int64_t left_ns = std::numeric_limits<std::int64_t>::min();
  for (std::size_t j = 0; j < stops.size(); ++j) {
    std::optional<double> angle = angle_in_stop(angles, stops[j]);
    if (!angle) angle = angle_on_arrival(angles, left_ns, stops[j]);
    left_ns = stops[j].end_ns;
    if (before && angle) turns.R_previous_this[j] = exp_so3(to_rad(*angle - *before) * *rig.turntable->axis);
    before = angle;
  }
  return turns;
}

std::string merge_table_turns(const TableTurns& table, std::vector<std::optional<Matrix3d>>& R_previous_this) {
  int doubtful = 0;
  double worst_rad = 0.0;
  for (std::size_t j = 1; j < R_previous_this.size() && j < table.R_previous_this.size(); ++j) {
    const std::optional<Matrix3d>& told = table.R_previous_this[j];
    if (!told) continue;
    if (!R_previous_this[j]) {
      R_previous_this[j] = told;
      continue;
    }
    const double off = rotation_distance(*told, *R_previous_this[j]);
    if (off > most_off_rad) ++doubtful;
    worst_rad = std::max(worst_rad, off);
  }
  if (doubtful == 0) return {};
  return "the table's angles and the gyro disagree about " + std::to_string(doubtful) + " turns, by up to " +
         fixed_text(to_deg(worst_rad), 1) +
         " degrees: the gyro is believed; does the table slip, or does the rig file want turntable.reverse or another "
         "axis?";
}

}  // namespace rigcal
