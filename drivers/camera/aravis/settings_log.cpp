#include "drivers/camera/aravis/settings_log.h"

#include <filesystem>
#include <string_view>

#include "core/io/csv_table.h"
#include "core/rig/text_file.h"

namespace rigcal::camera {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view header = "selector,entry,feature,value";
constexpr std::size_t max_bytes = std::size_t{1} << 20U;

bool fits_a_table(const OldSetting& setting) {
  for (const std::string* text : {&setting.selector, &setting.entry, &setting.feature, &setting.value}) {
    if (text->find_first_of(",\r\n") != std::string::npos) return false;
  }
  return true;
}

}  // namespace

void SettingsLog::add(OldSetting setting) {
  if (!file_.empty() && !trouble_ && fits_a_table(setting)) {
    if (!out_) {
      std::error_code error;
      fs::create_directories(fs::path(file_).parent_path(), error);
      Expected<OutputFile> made = OutputFile::create(file_);
      if (made) {
        out_ = *std::move(made);
        out_->write(std::string(header) + "\n");
      } else {
        trouble_ = made.error();
      }
    }
    if (out_) {
      out_->write(setting.selector + "," + setting.entry + "," + setting.feature + "," + setting.value + "\n");
      if (const auto written = out_->flush(); !written) trouble_ = written.error();
    }
  }
  settings_.push_back(std::move(setting));
}

void SettingsLog::clear() {
  settings_.clear();
  out_.reset();
  if (file_.empty()) return;
  std::error_code error;
  fs::remove(file_, error);
}

Expected<std::vector<OldSetting>> SettingsLog::read_left(const std::string& file) {
  std::error_code error;
  std::vector<OldSetting> settings;
  if (file.empty() || !fs::exists(file, error)) return settings;
  Expected<std::string> text = read_text_file(file, max_bytes);
  if (!text) return text.error();
  text->resize(text->rfind('\n') + 1);  // npos + 1 is 0.
  if (text->empty()) return settings;
  const Expected<std::vector<CsvRow>> rows = parse_csv(*text, header, file);
  if (!rows) return rows.error();
  for (const CsvRow& row : *rows) {
    const auto value = [&row](std::size_t column) { return std::string(row.values[column]); };
    settings.push_back({value(0), value(1), value(2), value(3)});
  }
  return settings;
}

std::string settings_file(const std::string& folder, const std::string& camera_id) {
  if (folder.empty()) return {};
  std::string name = camera_id;
  for (char& c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    if (!is_plain) c = '_';
  }
  return (fs::path(folder) / (name + ".csv")).string();
}

}  // namespace rigcal::camera
