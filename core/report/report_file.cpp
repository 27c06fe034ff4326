#include "core/report/report_file.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/version.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

using Json = nlohmann::json;

constexpr std::size_t most_bytes = std::size_t{256} << 20U;

/// The elements of a list that are texts, or of which `key` is one.
std::vector<std::string> texts_of(const Json& report, const char* list, const char* key = nullptr) {
  std::vector<std::string> texts;
  const auto found = report.find(list);
  if (found == report.end() || !found->is_array()) return texts;
  for (const Json& element : *found) {
    const Json text = key == nullptr ? element : (element.is_object() ? element.value(key, Json()) : Json());
    if (text.is_string()) texts.push_back(text.get<std::string>());
  }
  return texts;
}

}  // namespace

Expected<std::optional<ReportFile>> read_report(const std::string& folder) {
  const std::string path = (std::filesystem::path(folder) / "report.json").string();
  const Expected<std::string> text = read_text_file(path, most_bytes);
  if (!text) return std::optional<ReportFile>();
  const Json report = Json::parse(*text, nullptr, false);
  if (!report.is_object()) return std::optional<ReportFile>();
  const auto version = report.find("rigcal");
  if (version != report.end() && version->is_number_integer() && version->get<std::int64_t>() > format_version) {
    return input_error(
        "has the format " + version->dump() + ", but this release reads format " + std::to_string(format_version), path,
        "use rigcal " + version->dump() + ".0 or newer");
  }
  return std::optional<ReportFile>({texts_of(report, "warnings"), texts_of(report, "cameras", "name")});
}

}  // namespace rigcal
