#include "tests/support/headless_browser.h"

#include <fstream>

#include "tests/support/page_harness.h"
#include "tests/support/run_program.h"

namespace rigcal {

std::optional<HeadlessBrowser> HeadlessBrowser::find(const std::filesystem::path& scratch) {
  for (const char* name : {"chromium", "chromium-headless-shell", "google-chrome"}) {
    if (run_program(std::string("command -v ") + name, scratch).code == 0) return HeadlessBrowser(name, scratch);
  }
  return std::nullopt;
}

nlohmann::json HeadlessBrowser::seen(const std::string& page, int width, int height, bool views) const {
  std::ofstream(scratch_ / "page.html") << with_harness(page);
  std::ofstream(scratch_ / "frame.html") << frame_of("page.html", width, height);
  const std::string graphics = views ? "--use-angle=swiftshader --enable-unsafe-swiftshader" : "--disable-3d-apis";
  const ProgramRun run = run_program(
      name_ + " --headless --no-sandbox --hide-scrollbars --dump-dom --virtual-time-budget=1000 " + graphics +
          " --window-size=" + std::to_string(width + 200) + "," + std::to_string(height + 400) + " --user-data-dir='" +
          (scratch_ / "profile").string() + "' 'file://" + (scratch_ / "frame.html").string() + "'",
      scratch_);
  const std::string mark = "<pre id=\"harness\">";
  const std::size_t begin = run.out.find(mark);
  if (begin == std::string::npos) return {{"problems", {"no harness: " + run.err}}};
  std::string text = run.out.substr(begin + mark.size(), run.out.find("</pre>", begin) - begin - mark.size());
  for (const auto& [entity, plain] : {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&amp;", "&"}}) {
    for (std::size_t at = text.find(entity); at != std::string::npos; at = text.find(entity, at + 1)) {
      text.replace(at, std::string(entity).size(), plain);
    }
  }
  return try_json(text);
}

std::string HeadlessBrowser::dom_of(const std::string& url, int ms, const std::string& more) const {
  return run_program(name_ + " --headless --no-sandbox --disable-3d-apis --dump-dom --virtual-time-budget=" +
                         std::to_string(ms) + " " + more + " --user-data-dir='" + (scratch_ / "profile").string() +
                         "' '" + url + "'",
                     scratch_)
      .out;
}

}  // namespace rigcal
