#pragma once

#include <string>
#include <string_view>

namespace rigcal::web {

extern const std::string_view page_css;
extern const std::string_view page_js;
extern const std::string_view page_body;

/// The page of a running capture; needs nothing but what WebServer serves beside it.
[[nodiscard]] std::string page_html();

}  // namespace rigcal::web
