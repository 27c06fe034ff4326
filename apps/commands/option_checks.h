#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <string>

#include "core/base/parse_number.h"

namespace rigcal {

/// For values of options: finite numbers from `low` to `high`. CLI11's own check lets NaN pass, which is neither below
/// nor above any bound.
inline CLI::Validator number_range(double low, double high) {
  return CLI::Validator(
      [low, high](const std::string& text) -> std::string {
        double value = 0.0;
        if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high) return {};
        return fmt::format("{} is no number from {} to {}", text, low, high);
      },
      "");
}

/// For seeds. CLI11 itself makes some seed or other of negative numbers and of those that are too large.
inline CLI::Validator seed_range() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        if (parse_number<std::uint64_t>(text)) return {};
        return fmt::format("{} is no whole number from 0 to {}", text, std::numeric_limits<std::uint64_t>::max());
      },
      "");
}

/// For what is to be made: `--out ""`, as of a shell's variable that is not set, names nothing.
inline CLI::Validator named_path() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        return text.empty() ? "is empty: name the file or folder to make" : std::string();
      },
      "");
}

}  // namespace rigcal
