#include "apps/web/web_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "core/io/image_file.h"
#include "tests/apps/web/web_client.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

std::uint16_t port_of(const std::string& url) {
  return static_cast<std::uint16_t>(std::stoi(url.substr(url.find(':', url.find("//")) + 1)));
}

// Cameras that run free have a new image each time that the page looks.
TEST(WebView, PaintsEveryCameraAlsoWhereAllSendAllTheTime) {
  const auto session = scratch_folder("web_view");
  Image grey{640, 512, 1, 8, "", std::vector<std::uint8_t>(640 * 512)};
  for (std::size_t i = 0; i < grey.bytes.size(); ++i) grey.bytes[i] = i % 640 < 320 ? 40 : 200;
  CaptureStatus status;
  for (const char* name : {"left", "right"}) {
    std::filesystem::create_directories(session / "images" / name);
    ASSERT_TRUE(write_image((session / "images" / name / "0.png").string(), grey));
    status.cameras.emplace_back().sensor = name;
  }
  const Rig rig = *parse_rig(small_rig(small_camera("left", "Mono8") + small_camera("right", "Mono8")), "rig.yaml");
  auto view = WebView::start({"127.0.0.1", 0}, rig, session.string(), nullptr);
  ASSERT_TRUE(view) << view.error().message();
  const std::uint16_t port = port_of((*view)->url());
  const auto is_painted = [&](const std::string& name) {
    return get(port, "/picture/" + name).starts_with("HTTP/1.1 200");
  };
  bool are_painted = false;
  for (int i = 0; i < 200 && !are_painted; ++i) {
    for (CaptureCamera& camera : status.cameras) ++camera.written;
    (*view)->show(status);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    are_painted = is_painted("left") && is_painted("right");
  }
  EXPECT_TRUE(are_painted);
}

}  // namespace
}  // namespace rigcal
