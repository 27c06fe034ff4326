#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "tests/support/json.h"

namespace rigcal {

/// A Chromium without a screen, its graphics in software.
class HeadlessBrowser {
 public:
  static constexpr const char* missing = "there is no Chromium: apt-get install chromium";

  /// `scratch` is a folder of its own for what it leaves behind.
  [[nodiscard]] static std::optional<HeadlessBrowser> find(const std::filesystem::path& scratch);

  /// What a page looks like to the harness on a screen of this size. Browsers have no windows as narrow as phones: the
  /// page stands in a frame of that size. Without `views` nothing is drawn in 3-D, which is quicker.
  [[nodiscard]] nlohmann::json seen(const std::string& page, int width, int height, bool views = true) const;

  /// The page at an address as it stands after `ms` of the browser's time, as HTML.
  [[nodiscard]] std::string dom_of(const std::string& url, int ms, const std::string& more = {}) const;

 private:
  HeadlessBrowser(std::string name, std::filesystem::path scratch)
      : name_(std::move(name)), scratch_(std::move(scratch)) {}

  std::string name_;
  std::filesystem::path scratch_;
};

}  // namespace rigcal
