#include "tests/support/json.h"

#include <ostream>

#include "tests/support/files.h"

namespace rigcal {

nlohmann::json parse_json(const std::string& text) { return nlohmann::json::parse(text); }

nlohmann::json json_of_file(const std::filesystem::path& file) { return parse_json(text_of(file)); }

nlohmann::json try_json(const std::string& text) { return nlohmann::json::parse(text, nullptr, false); }

std::string json_text(const nlohmann::json& value) { return value.dump(); }

}  // namespace rigcal

namespace nlohmann {
void PrintTo(const json& value, std::ostream* out) { *out << rigcal::json_text(value); }
}  // namespace nlohmann
