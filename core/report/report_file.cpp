#include "core/report/report_file.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/version.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

using SortedJson = nlohmann::json;

constexpr std::size_t most_bytes = std::size_t{256} << 20U;
constexpr double most_pixels = 1e6;  // along a side

/// The elements of a list that are texts, or of which `key` is one.
std::vector<std::string> texts_of(const SortedJson& report, const char* list, const char* key = nullptr) {
  std::vector<std::string> texts;
  const auto found = report.find(list);
  if (found == report.end() || !found->is_array()) return texts;
  for (const SortedJson& element : *found) {
    const SortedJson text =
        key == nullptr ? element : (element.is_object() ? element.value(key, SortedJson()) : SortedJson());
    if (text.is_string()) texts.push_back(text.get<std::string>());
  }
  return texts;
}

std::optional<CameraIntrinsics> intrinsics_of(const SortedJson& camera) {
  const auto found = camera.find("intrinsics");
  if (found == camera.end() || !found->is_object()) return std::nullopt;
  const auto value = [&](const char* key) {
    const auto at = found->find(key);
    return at != found->end() && at->is_number() ? at->get<double>() : 0.0;
  };
  CameraIntrinsics out;
  if (found->value("model", SortedJson()) == "equidistant") out.model = DistortionModel::equidistant;
  out.width = static_cast<int>(std::clamp(value("width"), 0.0, most_pixels));
  out.height = static_cast<int>(std::clamp(value("height"), 0.0, most_pixels));
  out.fx = value("fx");
  out.fy = value("fy");
  out.cx = value("cx");
  out.cy = value("cy");
  const auto distortion = found->find("distortion");
  if (distortion == found->end() || !distortion->is_array()) return std::nullopt;
  for (const SortedJson& element : *distortion) {
    if (!element.is_number()) return std::nullopt;
    out.distortion.push_back(element.get<double>());
  }
  const bool is_whole = out.width > 0 && out.height > 0 && out.fx > 0.0 && out.fy > 0.0 &&
                        out.distortion.size() == static_cast<std::size_t>(distortion_count(out.model));
  return is_whole ? std::optional(out) : std::nullopt;
}

std::map<std::string, CameraIntrinsics> all_intrinsics(const SortedJson& report) {
  std::map<std::string, CameraIntrinsics> out;
  const auto cameras = report.find("cameras");
  if (cameras == report.end() || !cameras->is_array()) return out;
  for (const SortedJson& camera : *cameras) {
    if (!camera.is_object()) continue;
    const SortedJson name = camera.value("name", SortedJson());
    if (const auto found = intrinsics_of(camera); found && name.is_string()) out[name.get<std::string>()] = *found;
  }
  return out;
}

}  // namespace

Expected<std::optional<ReportFile>> read_report(const std::string& folder) {
  const std::string path = (std::filesystem::path(folder) / "report.json").string();
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::optional<ReportFile>();
  const Expected<std::string> text = read_text_file(path, most_bytes);
  if (!text) return text.error();
  const SortedJson report = SortedJson::parse(*text, nullptr, false);
  if (report.is_discarded()) {
    return input_error("is no JSON, or was cut or damaged", path,
                       "calibrate anew, or move the file away: what else is in the folder can be used without it");
  }
  if (!report.is_object()) return std::optional<ReportFile>();
  const auto version = report.find("rigcal");
  if (version != report.end() && version->is_number_integer() && version->get<std::int64_t>() > format_version) {
    return input_error(
        "has the format " + version->dump() + ", but this release reads format " + std::to_string(format_version), path,
        "use rigcal " + version->dump() + ".0 or newer");
  }
  return std::optional<ReportFile>(
      {texts_of(report, "warnings"), texts_of(report, "cameras", "name"), all_intrinsics(report)});
}

}  // namespace rigcal
