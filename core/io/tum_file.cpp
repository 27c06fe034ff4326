#include "core/io/tum_file.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "core/base/parse_number.h"
#include "core/base/seconds.h"
#include "core/base/text.h"
#include "core/io/output_file.h"
#include "core/rig/text_file.h"
#include "core/rig/yaml_tree.h"

namespace rigcal {
namespace {

constexpr std::size_t max_bytes = std::size_t{256} << 20;
constexpr double quaternion_tolerance = 0.01;

std::optional<double> parse_decimal(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  return parse_number<double>(word);
}

/// Seconds as nanoseconds. Plain decimals are read digit by digit: a double holds a UTC stamp only to 0.2 us.
std::optional<std::int64_t> parse_stamp(std::string_view word) {
  const bool negative = word.starts_with('-');
  const std::string_view digits = negative ? word.substr(1) : word;
  const std::size_t point = std::min(digits.find('.'), digits.size());
  const std::string_view whole = digits.substr(0, point);
  const std::string_view part = point < digits.size() ? digits.substr(point + 1) : std::string_view{};
  const auto seconds = parse_number<std::int64_t>(whole);
  const bool plain = !whole.empty() && whole.size() <= 10 && whole.find_first_not_of("0123456789") == whole.npos &&
                     part.find_first_not_of("0123456789") == part.npos;
  if (!plain || !seconds || *seconds >= 9'223'372'036) {
    const std::optional<double> value = parse_decimal(word);
    if (!value || std::abs(*value) >= 9e9) return std::nullopt;
    return ns_of_seconds(*value);
  }
  std::int64_t nanoseconds = 0;
  for (std::size_t i = 0; i < 9; ++i) nanoseconds = 10 * nanoseconds + (i < part.size() ? part[i] - '0' : 0);
  if (part.size() > 9 && part[9] >= '5') ++nanoseconds;
  const std::int64_t stamp = *seconds * ns_per_second + nanoseconds;
  return negative ? -stamp : stamp;
}

/// The words of a line, at most nine: more than a pose has.
std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while (words.size() < 9) {
    at = line.find_first_not_of(" \t\r", at);
    if (at == std::string_view::npos) break;
    const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

Expected<TumPose> parse_pose(const std::vector<std::string_view>& words, const std::string& where) {
  const Error wrong = input_error("is not a pose", where, "write stamp tx ty tz qx qy qz qw");
  if (words.size() != 8) return wrong;
  TumPose pose;
  const std::optional<std::int64_t> stamp = parse_stamp(words[0]);
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < 7; ++i) {
    const std::optional<double> value = parse_decimal(words[i + 1]);
    if (!value) return wrong;
    values[i] = *value;
  }
  if (!stamp) return wrong;
  const Eigen::Vector4d xyzw(values[3], values[4], values[5], values[6]);
  if (!(std::abs(xyzw.norm() - 1.0) <= quaternion_tolerance)) {
    return input_error("has a quaternion of the length " + number_text(xyzw.norm()), where,
                       "give a unit quaternion in the order qx qy qz qw");
  }
  pose.stamp_ns = *stamp;
  pose.pose = {rotation_from_xyzw(xyzw), Vector3d(values[0], values[1], values[2])};
  return pose;
}

}  // namespace

Expected<std::vector<TumPose>> parse_tum(const std::string& text, const std::string& name) {
  std::vector<TumPose> poses;
  std::string_view rest = text;
  for (int line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::vector<std::string_view> words = split(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (words.empty() || words[0].front() == '#') continue;
    Expected<TumPose> pose = parse_pose(words, name + ":" + std::to_string(line));
    if (!pose) return pose.error();
    pose->line = line;
    poses.push_back(*pose);
  }
  return poses;
}

Expected<std::vector<TumPose>> read_tum(const std::string& path) {
  const Expected<std::string> text = read_text_file(path, max_bytes);
  if (!text) return text.error();
  return parse_tum(*text, path);
}

std::string tum_stamp(std::int64_t stamp_ns) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%s%lld.%09lld", stamp_ns < 0 ? "-" : "",
                static_cast<long long>(std::llabs(stamp_ns / ns_per_second)),
                static_cast<long long>(std::llabs(stamp_ns % ns_per_second)));
  return text.data();
}

std::string tum_line(std::string_view stamp, const SE3& pose) {
  std::string text(stamp);
  for (const double value : pose.t) text.append(" ").append(number_text(value));
  for (const double value : xyzw_from_rotation(pose.R)) text.append(" ").append(number_text(value));
  return text.append("\n");
}

Expected<void> write_tum(const std::string& path, std::span<const TumPose> poses, const std::string& remark) {
  std::string text;
  if (!remark.empty()) text.append("# ").append(remark).append("\n");
  for (const TumPose& pose : poses) text += tum_line(tum_stamp(pose.stamp_ns), pose.pose);
  return replace_file(path, text);
}

}  // namespace rigcal
