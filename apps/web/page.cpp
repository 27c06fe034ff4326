#include "apps/web/page.h"

namespace rigcal::web {

std::string page_html() {
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>rigcal capture</title>\n<style>\n";
  page += page_css;
  page += "</style>\n</head>\n<body>\n";
  page += page_body;
  page += "<script>\n";
  page += page_js;
  page += "</script>\n</body>\n</html>\n";
  return page;
}

}  // namespace rigcal::web
