#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace rigcal {

/// Bytes from "4GB", "500 MB", "1.5GiB"; nothing where it is no size, or less than one byte.
[[nodiscard]] std::optional<std::uint64_t> parse_bytes(const std::string& text);

/// What is wrong with such a text on the command line; empty: nothing.
[[nodiscard]] std::string check_bytes(const std::string& text);

}  // namespace rigcal
