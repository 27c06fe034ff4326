#pragma once

#include <string_view>

/// Files that are built into the program (CMakeLists.txt makes them).
namespace rigcal::html {

extern const std::string_view page_css;
extern const std::string_view view3d_js;
extern const std::string_view three_js;           ///< three.js, MIT licence.
extern const std::string_view orbit_controls_js;  ///< Of three.js' examples, the same licence.

}  // namespace rigcal::html
