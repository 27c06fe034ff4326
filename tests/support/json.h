#pragma once

#include <filesystem>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <string>

namespace rigcal {

/// What the library makes of a text or a file; throws where that is no JSON. Tests call these and not the library
/// itself: its parser and its writer take three seconds to compile in each file that uses them.
[[nodiscard]] nlohmann::json parse_json(const std::string& text);
[[nodiscard]] nlohmann::json json_of_file(const std::filesystem::path& file);
/// The same; `is_discarded()` where the text is no JSON.
[[nodiscard]] nlohmann::json try_json(const std::string& text);

/// As text, for messages.
[[nodiscard]] std::string json_text(const nlohmann::json& value);

}  // namespace rigcal

namespace nlohmann {
/// For GoogleTest.
void PrintTo(const json& value, std::ostream* out);
}  // namespace nlohmann
