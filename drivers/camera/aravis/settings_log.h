#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/output_file.h"

namespace rigcal::camera {

/// A setting of a camera as it was before it was changed. Where it belongs to a selector, that has to be set first.
struct OldSetting {
  std::string selector;
  std::string entry;
  std::string feature;
  std::string value;
  auto operator<=>(const OldSetting&) const = default;
};

/// What was changed on a camera, so that it can be put back: in the order of the changes, also in a file, so that a
/// program that comes after a crash can do it (docs/decisions/019). A change is written down before it is made.
class SettingsLog {
 public:
  /// `file`: empty for none. It is made with the first change.
  explicit SettingsLog(std::string file = {}) : file_(std::move(file)) {}

  void add(OldSetting setting);
  /// From the first to the last change.
  [[nodiscard]] const std::vector<OldSetting>& settings() const { return settings_; }
  /// All is put back: nothing is left to be done, and the file is gone.
  void clear();
  /// Why there is no file, if there should be one.
  [[nodiscard]] const std::optional<Error>& trouble() const { return trouble_; }

  /// What a program left that did not end as it should; nothing where there is no such file. A line that was cut short
  /// is left out. Errors: no such table.
  [[nodiscard]] static Expected<std::vector<OldSetting>> read_left(const std::string& file);

 private:
  std::string file_;
  std::optional<OutputFile> out_;
  std::vector<OldSetting> settings_;
  std::optional<Error> trouble_;
};

/// Where the log of a camera lies; empty where `folder` is.
[[nodiscard]] std::string settings_file(const std::string& folder, const std::string& camera_id);

}  // namespace rigcal::camera
