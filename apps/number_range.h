#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

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

}  // namespace rigcal
