// What all cameras do when they get lost: see camera.h.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "drivers/camera/camera.h"

namespace rigcal::camera {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Kind = Delivery::Kind;

constexpr std::int64_t ms = 1'000'000;

/// Gets lost when it is told to, and notes what it is asked for.
class LosableCamera final : public Camera {
 public:
  explicit LosableCamera(std::int64_t search_pause_ns) : Camera(search_pause_ns) {}
  ~LosableCamera() override { close(); }

  bool loses = false;
  std::optional<Error> trouble;  ///< Of its start.
  std::vector<std::string> calls;

 private:
  Expected<CameraIdentity> do_open(const std::string& name) override {
    CameraIdentity identity;
    identity.id = name;
    return identity;
  }
  Expected<CameraSetup> do_configure(const CameraConfig& /*config*/) override { return CameraSetup{}; }
  Expected<void> do_start() override {
    calls.emplace_back("start");
    if (trouble) return *trouble;
    return {};
  }
  Expected<Delivery> do_next(std::int64_t /*timeout_ns*/) override {
    calls.emplace_back("next");
    if (loses) return lose("it was unplugged");
    return Delivery{};
  }
  Expected<void> do_trigger() override {
    calls.emplace_back("trigger");
    return {};
  }
  Expected<void> do_stop() override { return {}; }
  void do_let_go() override { calls.emplace_back("let go"); }
  void do_close() override {}
};

class LostCamera : public testing::Test {
 protected:
  void SetUp() override { begin(ms); }
  /// A camera that was noticed to be gone.
  void begin(std::int64_t search_pause_ns) {
    camera = std::make_unique<LosableCamera>(search_pause_ns);
    CameraConfig config;
    config.trigger.emplace();
    config.trigger->source = "Software";
    ASSERT_TRUE(camera->open("cam"));
    ASSERT_TRUE(camera->configure(config));
    ASSERT_TRUE(camera->start());
    camera->loses = true;
    const Delivery lost = next(0);
    ASSERT_EQ(lost.kind, Kind::lost);
    EXPECT_EQ(lost.text, "cam: the camera is gone: it was unplugged");
    camera->loses = false;
    camera->calls.clear();
  }
  Delivery next(std::int64_t timeout_ns) {
    Expected<Delivery> delivery = camera->next(timeout_ns);
    EXPECT_TRUE(delivery);
    return delivery ? *std::move(delivery) : Delivery{};
  }

  std::unique_ptr<LosableCamera> camera;
};

TEST_F(LostCamera, IsLookedForUntilItIsBack) {
  camera->trouble = system_error(no_such_camera, "cam");
  EXPECT_EQ(next(0).kind, Kind::nothing);
  EXPECT_THAT(camera->calls, ElementsAre("let go", "start", "let go"));
  camera->trouble.reset();
  EXPECT_EQ(next(1000 * ms).kind, Kind::back);
  EXPECT_EQ(next(0).kind, Kind::nothing);
  EXPECT_THAT(camera->calls, ElementsAre("let go", "start", "let go", "let go", "start", "next"));
  EXPECT_EQ(camera->counters().losses, 1U);
  EXPECT_EQ(camera->counters().returns, 1U);
}

TEST_F(LostCamera, SaysOnceOfALossWhyItCannotBeHad) {
  camera->trouble = system_error("another program holds it", "cam");
  const Delivery refused = next(0);
  EXPECT_EQ(refused.kind, Kind::refused);
  EXPECT_EQ(refused.text.substr(0, 5), "cam: ");
  EXPECT_THAT(refused.text, HasSubstr("another program holds it"));
  EXPECT_EQ(next(20 * ms).kind, Kind::nothing);
  camera->trouble = system_error("this user may not open it", "cam");
  EXPECT_EQ(next(1000 * ms).kind, Kind::refused);
}

TEST_F(LostCamera, IsNotLookedForWithoutAPause) {
  const auto from = std::chrono::steady_clock::now();
  begin(50 * ms);
  camera->trouble = system_error(no_such_camera, "cam");
  for (int k = 0; k < 20; ++k) EXPECT_EQ(next(10 * ms).kind, Kind::nothing);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - from;
  const auto tries = std::count(camera->calls.begin(), camera->calls.end(), "start");
  EXPECT_GE(tries, 3);
  EXPECT_LE(tries, 1 + took.count() / 50.0);
}

TEST_F(LostCamera, TakesNoTriggerUntilItIsBack) {
  const Expected<void> triggered = camera->trigger();
  ASSERT_FALSE(triggered);
  EXPECT_EQ(triggered.error().what, camera_is_gone);
  EXPECT_EQ(next(1000 * ms).kind, Kind::back);
  EXPECT_TRUE(camera->trigger());
  EXPECT_THAT(camera->calls, ElementsAre("let go", "start", "trigger"));
}

TEST_F(LostCamera, IsThereAgainWhereItStartsAnew) {
  ASSERT_TRUE(camera->stop());
  ASSERT_TRUE(camera->start());
  EXPECT_EQ(next(0).kind, Kind::nothing);
  EXPECT_THAT(camera->calls, ElementsAre("start", "next"));
}

}  // namespace
}  // namespace rigcal::camera
