#include "core/report/html/page.h"

#include "core/base/version.h"
#include "core/report/html/parts.h"
#include "core/report/html/resources.h"
#include "core/report/html_text.h"
#include "core/report/palette.h"

namespace rigcal {
namespace {

constexpr const char* three_licence =
    "<!-- The 3-D view is three.js, Copyright 2010-2019 three.js authors, under the MIT licence: Permission is hereby "
    "granted, free of charge, to any person obtaining a copy of this software and associated documentation files (the "
    "\"Software\"), to deal in the Software without restriction, including without limitation the rights to use, copy, "
    "modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit persons to whom "
    "the Software is furnished to do so, subject to the following conditions: The above copyright notice and this "
    "permission notice shall be included in all copies or substantial portions of the Software. THE SOFTWARE IS "
    "PROVIDED \"AS IS\", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES "
    "OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR "
    "COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR "
    "OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE. "
    "-->\n";

// Nothing from anywhere else, whatever a name or a message holds.
constexpr const char* policy =
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data: blob:; style-src "
    "'unsafe-inline'; script-src 'unsafe-inline'\">\n";

std::string series_css() {
  std::string css;
  for (std::size_t k = 0; k < series_rgb.size(); ++k) {
    const auto& rgb = series_rgb[k];
    css += ".s" + std::to_string(k) + "{--c:rgb(" + std::to_string(rgb[0]) + "," + std::to_string(rgb[1]) + "," +
           std::to_string(rgb[2]) + ")}";
  }
  return css;
}

struct Part {
  const char* id;
  const char* title;
  std::string content;
};

std::string navigation(const std::vector<Part>& parts) {
  std::string out = "<nav>";
  for (const Part& part : parts) {
    if (!part.content.empty()) out += std::string("<a href=\"#") + part.id + "\">" + part.title + "</a> ";
  }
  return out + "</nav>\n";
}

std::string script(std::string_view text) { return "<script>" + std::string(text) + "</script>\n"; }

}  // namespace

std::string report_html(const CalibrationResult& result, const Rig* rig) {
  const std::vector<Part> parts{{"numbers", "Numbers", html::numbers_part(result)},
                                {"cameras", "Cameras", html::cameras_part(result)},
                                {"map", "Map", html::view_part(result, rig)},
                                {"maps", "Before and after", html::maps_part(result)},
                                {"surfaces", "Walls", html::surfaces_part(result)},
                                {"hold-out", "Hold-out", html::hold_out_part(result)},
                                {"convergence", "Convergence", html::convergence_part(result)},
                                {"recording", "Recording", html::recording_part(result)},
                                {"run", "Run", html::run_part(result)}};
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n";
  page += policy;
  page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  page += "<meta name=\"color-scheme\" content=\"light dark\">\n";
  page += std::string("<title>") + to_string(result.status) + ": calibration" +
          (rig == nullptr || rig->name.empty() ? std::string() : " of " + html_text(rig->name)) + "</title>\n";
  page += "<style>" + std::string(html::page_css) + series_css() + "</style></head><body>\n<main>\n";
  page += html::status_part(result, rig) + navigation(parts);
  for (const Part& part : parts) page += part.content;
  page += "<footer>Written by rigcal " + html_text(version()) +
          ". This page holds everything it shows and loads nothing.</footer>\n</main>\n";
  page += three_licence;
  page += script(html::three_js) + script(html::orbit_controls_js) + script(html::view3d_js);
  return page + "</body></html>\n";
}

}  // namespace rigcal
