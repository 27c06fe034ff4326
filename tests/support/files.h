#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace rigcal {

/// All that a file holds; nothing where it cannot be read.
[[nodiscard]] std::string text_of(const std::filesystem::path& file);
[[nodiscard]] std::vector<std::uint8_t> read_bytes(const std::filesystem::path& file);

/// A file that holds these bytes and no others.
void save_bytes(const std::filesystem::path& file, const std::vector<std::uint8_t>& bytes);

}  // namespace rigcal
