#include "core/report/html/parts.h"

#include "core/report/html_text.h"
#include "core/report/palette.h"

namespace rigcal::html {

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                  const std::string& remark) {
  std::string out = "<div class=\"wide\"><table><thead><tr>";
  for (const std::string& text : head) out += "<th scope=\"col\">" + html_text(text) + "</th>";
  out += "</tr></thead><tbody>";
  for (const std::vector<std::string>& row : rows) {
    out += "<tr>";
    for (std::size_t k = 0; k < row.size(); ++k) {
      out += (k == 0 ? "<th scope=\"row\">" : "<td>") + html_text(row[k]) + (k == 0 ? "</th>" : "</td>");
    }
    out += "</tr>";
  }
  return out + "</tbody></table></div>" + (remark.empty() ? "" : paragraph(remark));
}

std::string section(const std::string& id, const std::string& title, const std::string& content) {
  if (content.empty()) return {};
  return "<section id=\"" + id + "\"><h2>" + html_text(title) + "</h2>" + content + "</section>\n";
}

std::string figure(const std::string& picture, const std::string& words) {
  return "<figure>" + picture + "<figcaption>" + words + "</figcaption></figure>";
}

std::string paragraph(const std::string& words) { return "<p>" + words + "</p>"; }

std::string badge(Status status) {
  const char* mark = status == Status::good ? "✓" : status == Status::weak ? "!" : "✕";
  return std::string("<span class=\"badge ") + to_string(status) + "\">" + mark + " " + to_string(status) + "</span>";
}

std::string colour_key(const CalibrationResult& result, const std::vector<char>& shown) {
  std::string out;
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    if (i >= shown.size() || !shown[i]) continue;
    out += "<span class=\"key\"><i class=\"swatch s" + std::to_string(i % series_rgb.size()) + "\"></i>" +
           html_text(result.sensors[i].name) + "</span> ";
  }
  return out;
}

}  // namespace rigcal::html
