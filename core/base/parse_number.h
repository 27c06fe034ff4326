#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace rigcal {

/// The number that `text` begins with, which is cut off it; nothing, and `text` as it was, where there is none, where
/// it does not fit, or where it is not finite. Spaces and a plus sign in front are no part of a number. Independent of
/// the locale.
template <class Number>
[[nodiscard]] std::optional<Number> take_number(std::string_view& text, int base = 10) {
  const char* const end = text.data() + text.size();
  Number value{};
  std::from_chars_result read{};
  if constexpr (std::is_floating_point_v<Number>) {
    read = std::from_chars(text.data(), end, value);
    if (!std::isfinite(value)) return std::nullopt;
  } else {
    read = std::from_chars(text.data(), end, value, base);
  }
  if (read.ec != std::errc{}) return std::nullopt;
  text = {read.ptr, static_cast<std::size_t>(end - read.ptr)};
  return value;
}

/// The number that is all of `text`.
template <class Number>
[[nodiscard]] std::optional<Number> parse_number(std::string_view text, int base = 10) {
  const std::optional<Number> value = take_number<Number>(text, base);
  return text.empty() ? value : std::nullopt;
}

}  // namespace rigcal
