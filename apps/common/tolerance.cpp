#include "apps/common/tolerance.h"

#include <cmath>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/parse_number.h"
#include "core/geometry/se3.h"

namespace rigcal {
namespace {

using Unit = std::pair<std::string_view, double>;

enum class Zero { taken, refused };

// A number with one of the units behind it, in the unit's own measure times `scale`; none below zero.
std::optional<double> read_quantity(std::string_view text, std::initializer_list<Unit> units, Zero zero) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  const std::optional<double> value = take_number<double>(text);
  if (!value || std::signbit(*value)) return std::nullopt;
  if (*value == 0.0 && zero == Zero::refused) return std::nullopt;
  for (const auto& [name, scale] : units) {
    if (text == name) return *value * scale;
  }
  return std::nullopt;
}

std::optional<Tolerance> parse(const std::string& text, Zero zero) {
  const std::string_view whole = text;
  const std::size_t comma = whole.find(',');
  if (comma != std::string_view::npos) {
    const auto length = read_quantity(whole.substr(0, comma), {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}}, zero);
    const auto angle = read_quantity(whole.substr(comma + 1), {{"deg", to_rad(1.0)}, {"rad", 1.0}}, zero);
    if (length && angle) return Tolerance{*length, *angle};
  }
  return std::nullopt;
}

}  // namespace

Expected<Tolerance> parse_tolerance(const std::string& text) {
  if (const std::optional<Tolerance> bound = parse(text, Zero::refused)) return *bound;
  return input_error("\"" + text + "\" is no bound", {}, "write a length and an angle, for example 10mm,0.1deg");
}

Expected<Tolerance> parse_distance(const std::string& text) {
  if (const std::optional<Tolerance> distance = parse(text, Zero::taken)) return *distance;
  return input_error("\"" + text + "\" is no length and angle", {}, "write them like 10mm,0.1deg");
}

std::string check_tolerance(const std::string& text) {
  const Expected<Tolerance> tolerance = parse_tolerance(text);
  return tolerance ? std::string() : tolerance.error().message();
}

}  // namespace rigcal
