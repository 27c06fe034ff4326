// The whole chain on the kernel's interfaces, in the virtual machine: the trigger's pulses on a GPIO line, a USB3
// Vision camera that exposes for each, and each frame given the pulse that released it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/frames/frame_matcher.h"
#include "drivers/camera/aravis/aravis_backend.h"
#include "drivers/trigger/trigger.h"
#include "tests/drivers/trigger/gpio_sim.h"

namespace rigcal {
namespace {

using camera::Delivery;
using trigger::GpioSim;
using trigger::Trigger;
using trigger::TriggerEventKind;

constexpr std::int64_t ms = 1'000'000;
constexpr unsigned line = 1;
constexpr std::uint64_t pulse_count = 60;
const std::string serial = "00F12345678";

/// The program that is the camera; ending it unplugs it.
class GadgetProgram {
 public:
  explicit GadgetProgram(const std::string& line_value) : process_(fork()) {
    if (process_ == 0) {
      execl(RIGCAL_USB3_GADGET, RIGCAL_USB3_GADGET, line_value.c_str(), nullptr);
      _exit(127);
    }
  }
  ~GadgetProgram() {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  GadgetProgram(const GadgetProgram&) = delete;
  GadgetProgram& operator=(const GadgetProgram&) = delete;

 private:
  pid_t process_;
};

class Chain : public testing::Test {
 protected:
  void SetUp() override {
    if (!GpioSim::is_available()) GTEST_SKIP() << "SKIP: this kernel has no gpio-sim; tests/hil/run has one";
    chip = std::make_unique<GpioSim>("rigcal-chain");
    plug_in();
    ASSERT_TRUE(open_camera());
  }
  void plug_in() { gadget = std::make_unique<GadgetProgram>((chip->line(line) / "value").string()); }
  bool open_camera() {
    taken = backend.make();
    for (int i = 0; i < 50; ++i) {
      if (taken->open(serial)) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    camera::CameraConfig config;
    config.pixel_format = "Mono8";
    config.region = camera::Region{0, 0, 256, 128};
    config.exposure_us = 1000.0;
    config.trigger = camera::TriggerConfig{"Line0", false, 0.0};
    const auto setup = taken->configure(config);
    EXPECT_TRUE(setup.has_value()) << (setup ? "" : setup.error().message());
    const auto started = setup ? taken->start() : Expected<void>(setup.error());
    EXPECT_TRUE(started.has_value());
    return started.has_value();
  }

  std::unique_ptr<GpioSim> chip;
  std::unique_ptr<GadgetProgram> gadget;
  camera::AravisBackend backend;
  std::unique_ptr<camera::Camera> taken;
};

TEST_F(Chain, GivesEachFrameThePulseThatReleasedIt) {
  const net::ClockReading start = net::read_clocks();
  const net::SessionClock clock(start);
  trigger::TriggerOptions options;
  options.output = trigger::LineAddress{"rigcal-chain", line};
  options.pattern.period_ns = 200 * ms;
  options.pattern.width_ns = 80 * ms;
  options.pattern.count = pulse_count;
  const auto line_driver = Trigger::start(options, start);
  ASSERT_TRUE(line_driver.has_value()) << line_driver.error().message();

  FrameMatcherOptions matching;
  matching.ids = usb3_block_ids;
  matching.least_lag_ns = ms;
  matching.most_lag_ns = 150 * ms;
  FrameMatcher matcher(matching);
  std::vector<FrameMatch> matches;
  const auto take = [&] {
    while (const auto match = matcher.next()) matches.push_back(*match);
  };
  bool is_finished = false;
  std::size_t silent = 0;
  while (!is_finished || silent < 3) {
    Expected<Delivery> delivery = taken->next(100 * ms);
    ASSERT_TRUE(delivery.has_value()) << delivery.error().message();
    trigger::TriggerEvent event;
    while ((*line_driver)->next(event, 0)) {
      is_finished = is_finished || event.kind == TriggerEventKind::finished;
      if (event.kind == TriggerEventKind::pulse) matcher.add_pulse({event.number, event.stamp_ns});
    }
    silent = delivery->kind == Delivery::Kind::frame ? 0 : silent + 1;
    if (delivery->kind != Delivery::Kind::frame) continue;
    const camera::FrameFacts facts = delivery->frame.facts();
    ASSERT_TRUE(facts.device_stamp_ns.has_value());
    matcher.add_frame({facts.frame_id, *facts.device_stamp_ns, clock.from_monotonic(facts.host_stamp_ns)});
    take();
  }
  matcher.finish();
  take();

  // The camera numbers its exposures: where it has seen every pulse, its numbers are theirs.
  const MatchLedger& ledger = matcher.ledger();
  std::printf("%llu pulses, %zu frames, %llu matched, %llu doubtful, %llu without a pulse; stamps +-%.0f us\n",
              static_cast<unsigned long long>(ledger.pulses), matches.size(),
              static_cast<unsigned long long>(ledger.matched), static_cast<unsigned long long>(ledger.doubtful),
              static_cast<unsigned long long>(ledger.without_pulse),
              matcher.clock() ? matcher.clock()->jitter_ns / 1e3 : 0.0);
  EXPECT_EQ(ledger.pulses, pulse_count);
  EXPECT_GE(matches.size(), pulse_count * 9 / 10);
  // The camera looks at its line twice a millisecond, and here now and then much later: such stamps match no pulse.
  EXPECT_GE(ledger.matched, matches.size() * 8 / 10);
  std::int64_t unseen = 0;
  for (const FrameMatch& match : matches) {
    if (!match.pulse) continue;
    const std::int64_t ahead = *match.pulse - static_cast<std::int64_t>(match.frame.id);
    EXPECT_GE(ahead, unseen) << "frame " << match.frame.id << " was given a pulse before its own";
    unseen = ahead;
  }
  if (matches.size() == pulse_count) {
    EXPECT_EQ(unseen, 0);
  }
  (*line_driver)->stop();
  EXPECT_FALSE(chip->is_high(line));
}

TEST_F(Chain, ACameraThatIsUnpluggedIsAnEventWithinASecondAndComesBack) {
  const auto unplugged = std::chrono::steady_clock::now();
  gadget.reset();
  Delivery::Kind kind = Delivery::Kind::nothing;
  while (kind != Delivery::Kind::lost && std::chrono::steady_clock::now() < unplugged + std::chrono::seconds(10)) {
    Expected<Delivery> delivery = taken->next(100 * ms);
    ASSERT_TRUE(delivery.has_value()) << delivery.error().message();
    kind = delivery->kind;
  }
  ASSERT_EQ(kind, Delivery::Kind::lost);
  // A second on a machine; emulation takes ten times as long for everything but the waiting.
  EXPECT_LT(std::chrono::steady_clock::now() - unplugged, std::chrono::seconds(3));
  plug_in();
  const auto plugged_in = std::chrono::steady_clock::now();
  while (kind != Delivery::Kind::back && std::chrono::steady_clock::now() < plugged_in + std::chrono::seconds(40)) {
    Expected<Delivery> delivery = taken->next(100 * ms);
    ASSERT_TRUE(delivery.has_value()) << delivery.error().message();
    kind = delivery->kind;
  }
  EXPECT_EQ(kind, Delivery::Kind::back);
}

}  // namespace
}  // namespace rigcal
