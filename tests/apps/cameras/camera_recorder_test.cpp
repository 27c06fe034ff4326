// Cameras of a rig on the loopback network, taken and recorded.
#include "apps/cameras/camera_recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <functional>
#include <limits>
#include <mutex>
#include <thread>

#include "apps/capture/camera_checks.h"
#include "apps/capture/trigger_recorder.h"
#include "core/io/image_file.h"
#include "tests/drivers/camera/virtual_camera.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::AnyOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;
namespace fs = std::filesystem;

Rig rig_with(const std::string& camera, const std::string& trigger = "") {
  auto rig = parse_rig(
      "rigcal: 1\nname: lab\nbase: avia\nsensors:\n"
      "  avia: {type: livox_avia, broadcast_code: \"3JEDHC900100791\"}\n"
      "  left: {type: camera, " +
          camera + "}\n" + trigger,
      "lab.yaml");
  EXPECT_TRUE(rig.has_value()) << (rig ? "" : rig.error().message());
  return *std::move(rig);
}

TEST(RigCameras, TakeTheirSettingsFromTheRigFile) {
  const Rig rig = rig_with(
      "driver: aravis, device: \"00F1\", pixel_format: BayerRG8, exposure_us: 5000, gain: 3, frame_rate: 20, "
      "packet_size: 1500, packet_delay: 100, ptp: true, strobe: Line1, "
      "trigger: {source: Line0, activation: falling, delay_us: 10}");
  const auto cameras = rig_cameras(rig);
  ASSERT_EQ(cameras.size(), 1U);
  const camera::CameraConfig& config = cameras[0].config;
  EXPECT_EQ(cameras[0].sensor, "left");
  EXPECT_EQ(cameras[0].device, "00F1");
  EXPECT_EQ(config.pixel_format, "BayerRG8");
  EXPECT_EQ(config.exposure_us, 5000.0);
  EXPECT_EQ(config.packet_bytes, 1500);
  EXPECT_EQ(config.packet_delay_ns, 100);
  EXPECT_TRUE(config.ptp);
  EXPECT_EQ(config.strobe, "Line1");
  EXPECT_TRUE(config.trigger->on_falling_edge);
  EXPECT_FALSE(cameras[0].is_told);
  EXPECT_TRUE(rig_cameras(rig_with("driver: aravis, trigger: {source: Software}"))[0].is_told);
  EXPECT_TRUE(rig_cameras(rig_with("driver: images, device: folder")).empty());
}

class CameraRecorderLive : public testing::Test {
 protected:
  void SetUp() override {
    device.device.width = 320;
    device.device.height = 240;
    serve();
  }
  void serve() {
    server.reset();
    auto started = sim::CameraServer::start({device});
    ASSERT_TRUE(started.has_value()) << started.error().message();
    server = *std::move(started);
  }
  Rig rig(const std::string& more = "frame_rate: 20") {
    return rig_with("driver: aravis, device: \"" + camera::address_of(device) + "\", exposure_us: 1000, " + more);
  }
  std::shared_ptr<CameraRecorder> record(const Rig& of) {
    auto recorder = CameraRecorder::start(rig_cameras(of)[0], drivers, session.string(), start);
    EXPECT_TRUE(recorder.has_value()) << recorder.error().message();
    return *std::move(recorder);
  }
  /// Of a camera that waits for pulses.
  std::shared_ptr<CameraRecorder> record_triggered(const std::string& trigger) {
    auto recorder = record(rig_with("driver: aravis, device: \"" + camera::address_of(device) +
                                        "\", exposure_us: 1000, trigger: {source: Line0" + trigger + "}",
                                    "trigger: {gpiochip: gpiochip0, line: 17}\n"));
    EXPECT_TRUE(wait_for([&] { return recorder->status().state == "waits"; }));
    return recorder;
  }
  /// Once so many are written and it is finished.
  std::vector<FrameRecord> frames_of(CameraRecorder& recorder, std::uint64_t count) {
    EXPECT_TRUE(wait_for([&] { return recorder.status().written >= count; }));
    recorder.finish();
    const auto frames = read_frames((session / "images" / "left" / "frames.csv").string());
    EXPECT_TRUE(frames.has_value()) << frames.error().message();
    EXPECT_TRUE(recorder.status().matching.has_value());
    return frames ? *frames : std::vector<FrameRecord>{};
  }
  static bool wait_for(const std::function<bool()>& condition, int seconds = 30) {
    for (int i = 0; i < 20 * seconds; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return condition();
  }

  sim::ServedCamera device = camera::virtual_camera(51, "00CA9751");
  std::unique_ptr<sim::CameraServer> server;
  fs::path session = scratch_folder("camera_recorder");
  net::ClockReading start = net::read_clocks();
  CameraDrivers drivers{(session / "state").string()};
};

TEST_F(CameraRecorderLive, WritesImagesThatAreWhatTheCameraSent) {
  const std::int64_t before_ns = net::read_clocks().realtime_ns;
  auto recorder = record(rig("frame_rate: 20, pixel_format: BayerRG12"));
  ASSERT_TRUE(wait_for([&] { return recorder->status().written >= 5; }));
  recorder->finish();
  EXPECT_FALSE(recorder->status().failure.has_value());
  const CaptureCamera status = recorder->status();
  EXPECT_EQ(status.state, "ended");
  EXPECT_EQ(status.pixel_format, "BayerRG12");
  EXPECT_EQ(status.written + status.dropped_by_queue, status.counters.whole());
  const fs::path folder = session / "images" / "left";
  const auto frames = read_frames((folder / "frames.csv").string());
  ASSERT_TRUE(frames.has_value()) << frames.error().message();
  ASSERT_EQ(frames->size(), status.written);
  for (std::size_t i = 0; i < frames->size(); ++i) {
    const FrameRecord& frame = (*frames)[i];
    EXPECT_GT(frame.stamp_ns, before_ns);
    EXPECT_LT(frame.stamp_ns, net::read_clocks().realtime_ns);
    if (i > 0) {
      EXPECT_GT(frame.stamp_ns, (*frames)[i - 1].stamp_ns);
    }
    EXPECT_NEAR(frame.exposure_us.value_or(0.0), 1000.0, 0.1);
    EXPECT_TRUE(frame.device_stamp.has_value());
  }
  const auto image = read_image((folder / "000002.png").string());
  ASSERT_TRUE(image.has_value()) << image.error().message();
  EXPECT_EQ(image->width, 320);
  EXPECT_EQ(image->bits, 16);
  // The pattern goes on by 1 from pixel to pixel, in 12 bits.
  EXPECT_EQ((image->at(1, 0) - image->at(0, 0) + 4096) % 4096, 1);
  EXPECT_EQ((image->at(0, 1) - image->at(0, 0) + 4096) % 4096, 3);
}

TEST_F(CameraRecorderLive, ImagesGetThePulsesThatReleasedThem) {
  const auto recorder = record_triggered(", delay_us: 10");
  const net::SessionClock clock(start);
  std::vector<std::int64_t> pulses;
  // Unevenly, so that no pulse can be mistaken for another.
  for (int i = 0; i < 24; ++i) {
    const std::int64_t now = net::read_clocks().monotonic_ns;
    server->pulse({0, now, now + 500'000, i});
    pulses.push_back(clock.from_monotonic(now));
    recorder->add_pulse({i, pulses.back()});
    std::this_thread::sleep_for(std::chrono::milliseconds(60 + 25 * (i % 3)));
  }
  const std::vector<FrameRecord> frames = frames_of(*recorder, 20);
  const CaptureCamera status = recorder->status();
  ASSERT_TRUE(status.matching.has_value());
  EXPECT_EQ(frames.size(), status.written);
  EXPECT_EQ(status.matching->frames, status.written);
  EXPECT_GE(status.matching->matched + 2, status.written);
  std::uint64_t matched = 0;
  for (const FrameRecord& frame : frames) {
    if (!frame.trigger) continue;
    ++matched;
    EXPECT_EQ(frame.stamp_ns, pulses[static_cast<std::size_t>(*frame.trigger)] + 10'000 + 500'000);
  }
  EXPECT_EQ(matched, status.matching->matched);
}

TEST_F(CameraRecorderLive, ImagesGetTheirPulsesFromACameraWithoutAClock) {
  device.device.clock_drift = -1.0;
  serve();
  const auto recorder = record_triggered("");
  const net::SessionClock clock(start);
  for (int i = 0; i < 12; ++i) {
    const std::int64_t now = net::read_clocks().monotonic_ns;
    server->pulse({0, now, now + 500'000, i});
    recorder->add_pulse({i, clock.from_monotonic(now)});
    std::this_thread::sleep_for(std::chrono::milliseconds(250 + 50 * (i % 3)));
  }
  const std::vector<FrameRecord> frames = frames_of(*recorder, 12);
  const CaptureCamera status = recorder->status();
  ASSERT_TRUE(status.matching.has_value());
  EXPECT_EQ(status.matching->strays, 0U);
  // How many are clear is a matter of how evenly a busy machine lets them arrive; which pulse they get is not.
  EXPECT_GE(status.matching->matched, 4U);
  ASSERT_EQ(frames.size(), 12U);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].trigger) {
      EXPECT_EQ(*frames[i].trigger, static_cast<std::int64_t>(i));
    }
  }
}

TEST_F(CameraRecorderLive, ImagesOfFallingEdgesHaveTheStampsOfThese) {
  const auto recorder = record_triggered(", activation: falling, delay_us: 10");
  const net::SessionClock clock(start);
  std::vector<std::int64_t> ends;
  for (int i = 0; i < 24; ++i) {
    const std::int64_t now = net::read_clocks().monotonic_ns;
    const std::int64_t end = now + 4'000'000 + 200'000 * (i % 5);
    server->pulse({0, now, end, i});
    recorder->add_pulse({i, clock.from_monotonic(now)});
    ends.push_back(clock.from_monotonic(end));
    recorder->end_pulse({i, ends.back()});
    std::this_thread::sleep_for(std::chrono::milliseconds(60 + 25 * (i % 3)));
  }
  const std::vector<FrameRecord> frames = frames_of(*recorder, 20);
  const CaptureCamera status = recorder->status();
  ASSERT_TRUE(status.matching.has_value());
  EXPECT_EQ(status.matching->pulses, 24U);
  EXPECT_GE(status.matching->matched + 2, status.written);
  for (const FrameRecord& frame : frames) {
    if (!frame.trigger) continue;
    EXPECT_EQ(frame.stamp_ns, ends[static_cast<std::size_t>(*frame.trigger)] + 10'000 + 500'000);
  }
}

/// A camera that does not start the first time.
class LateStarter final : public camera::Camera {
 public:
  explicit LateStarter(std::function<void()> when_set_up) : when_set_up_(std::move(when_set_up)) {}
  ~LateStarter() override { close(); }
  [[nodiscard]] camera::CameraCounters counters() const override { return {}; }

 private:
  Expected<camera::CameraIdentity> do_open(const std::string& name) override {
    return camera::CameraIdentity{name, name, {}, {}, "late starter", "none"};
  }
  Expected<camera::CameraSetup> do_configure(const camera::CameraConfig& /*config*/) override {
    when_set_up_();
    return camera::CameraSetup{};
  }
  Expected<void> do_start() override {
    return ++starts_ > 1 ? Expected<void>() : Expected<void>(system_error("it does not start yet"));
  }
  Expected<camera::Delivery> do_next(std::int64_t timeout_ns) override {
    std::this_thread::sleep_for(std::chrono::nanoseconds(timeout_ns));
    return camera::Delivery{};
  }
  Expected<void> do_trigger() override { return {}; }
  Expected<void> do_stop() override { return {}; }
  void do_close() override {}

  std::function<void()> when_set_up_;
  int starts_ = 0;
};

/// A camera that brings what it is told to bring, and nothing after that.
class ToldCamera final : public camera::Camera {
 public:
  ToldCamera(camera::CameraSetup setup, std::vector<camera::Delivery> brings)
      : setup_(std::move(setup)), brings_(std::move(brings)) {}
  ~ToldCamera() override { close(); }
  [[nodiscard]] camera::CameraCounters counters() const override { return {}; }

 private:
  Expected<camera::CameraIdentity> do_open(const std::string& name) override {
    return camera::CameraIdentity{name, name, {}, {}, "told", "none"};
  }
  Expected<camera::CameraSetup> do_configure(const camera::CameraConfig& /*config*/) override { return setup_; }
  Expected<void> do_start() override { return {}; }
  Expected<camera::Delivery> do_next(std::int64_t timeout_ns) override {
    if (next_ < brings_.size()) return std::move(brings_[next_++]);
    std::this_thread::sleep_for(std::chrono::nanoseconds(timeout_ns));
    return camera::Delivery{};
  }
  Expected<void> do_trigger() override { return {}; }
  Expected<void> do_stop() override { return {}; }
  void do_close() override {}

  camera::CameraSetup setup_;
  std::vector<camera::Delivery> brings_;
  std::size_t next_ = 0;
};

/// A camera that brings a frame 3 ms after each pulse.
class PulsedCamera final : public camera::Camera {
 public:
  explicit PulsedCamera(camera::CameraSetup setup) : setup_(std::move(setup)) {}
  ~PulsedCamera() override { close(); }
  [[nodiscard]] camera::CameraCounters counters() const override { return {}; }
  void pulse(std::int64_t monotonic_ns) {
    const std::lock_guard lock(mutex_);
    pulses_.push_back(monotonic_ns);
  }

 private:
  Expected<camera::CameraIdentity> do_open(const std::string& name) override {
    return camera::CameraIdentity{name, name, {}, {}, "pulsed", "none"};
  }
  Expected<camera::CameraSetup> do_configure(const camera::CameraConfig& /*config*/) override { return setup_; }
  Expected<void> do_start() override { return {}; }
  Expected<camera::Delivery> do_next(std::int64_t /*timeout_ns*/) override;
  Expected<void> do_trigger() override { return {}; }
  Expected<void> do_stop() override { return {}; }
  void do_close() override {}

  camera::CameraSetup setup_;
  std::mutex mutex_;
  std::vector<std::int64_t> pulses_;
  std::size_t next_ = 0;
};

/// The driver "one", which has one camera to give.
class OneCamera final : public camera::CameraBackend {
 public:
  explicit OneCamera(std::unique_ptr<camera::Camera> camera) : camera_(std::move(camera)) {}
  [[nodiscard]] std::string_view name() const override { return "one"; }
  [[nodiscard]] Expected<std::vector<camera::CameraIdentity>> enumerate() override {
    return std::vector<camera::CameraIdentity>{};
  }
  [[nodiscard]] std::unique_ptr<camera::Camera> make() override { return std::move(camera_); }

 private:
  std::unique_ptr<camera::Camera> camera_;
};

CameraDrivers driver_of(std::unique_ptr<camera::Camera> camera) {
  std::vector<std::unique_ptr<camera::CameraBackend>> backends;
  backends.push_back(std::make_unique<OneCamera>(std::move(camera)));
  return CameraDrivers(std::move(backends));
}

RigCamera left_camera() {
  RigCamera wanted;
  wanted.sensor = "left";
  wanted.driver = "one";
  wanted.device = "it";
  return wanted;
}

/// Frames of 2 x 2 pixels; nobody wants their memory back.
camera::Delivery small_frame(std::int64_t host_stamp_ns, std::uint64_t id = 0) {
  struct NoStore final : camera::FrameStore {
    void give_back(std::size_t /*buffer*/) noexcept override {}
  };
  static const std::array<std::uint8_t, 4> pixels{};
  camera::FrameFacts facts;
  facts.host_stamp_ns = host_stamp_ns;
  facts.frame_id = id;
  facts.width = 2;
  facts.height = 2;
  facts.row_bytes = 2;
  facts.pixel_format = "Mono8";
  camera::Delivery delivery;
  delivery.kind = camera::Delivery::Kind::frame;
  delivery.frame = camera::Frame(facts, pixels, std::make_shared<NoStore>(), 0);
  return delivery;
}

Expected<camera::Delivery> PulsedCamera::do_next(std::int64_t /*timeout_ns*/) {
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const std::lock_guard lock(mutex_);
  if (next_ == pulses_.size()) return camera::Delivery{};
  const std::size_t id = next_++;
  return small_frame(pulses_[id] + 3'000'000, id);
}

TEST(CameraRecorderStamps, AreOfTheMiddleOfTheExposureWhateverTheHostStamps) {
  using camera::HostStamp;
  for (const HostStamp moment : {HostStamp::exposure_start, HostStamp::arrival_start, HostStamp::arrival_end}) {
    const fs::path session = scratch_folder("camera_stamps");
    const net::ClockReading start = net::read_clocks();
    camera::CameraSetup setup;
    setup.pixel_format = "Mono8";
    setup.exposure_us = 40'000.0;
    setup.host_stamp = moment;
    std::vector<camera::Delivery> frames;
    frames.push_back(small_frame(start.monotonic_ns + 1'000'000));
    CameraDrivers drivers = driver_of(std::make_unique<ToldCamera>(setup, std::move(frames)));
    auto recorder = CameraRecorder::start(left_camera(), drivers, session.string(), start);
    ASSERT_TRUE(recorder.has_value());
    for (int i = 0; i < 400 && (*recorder)->status().written == 0; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    (*recorder)->finish();
    const auto listed = read_frames((session / "images" / "left" / "frames.csv").string());
    ASSERT_TRUE(listed.has_value()) << listed.error().message();
    ASSERT_EQ(listed->size(), 1U);
    const std::int64_t half_ns = moment == HostStamp::exposure_start ? 20'000'000 : -20'000'000;
    EXPECT_EQ((*listed)[0].stamp_ns, net::SessionClock(start).from_monotonic(start.monotonic_ns + 1'000'000) + half_ns);
  }
}

TEST(CameraRecorderEvents, TellWhyALostCameraIsNotTakenAgain) {
  const fs::path session = scratch_folder("camera_events");
  std::vector<camera::Delivery> news(2);
  news[0].kind = camera::Delivery::Kind::lost;
  news[0].text = "it is gone";
  news[1].kind = camera::Delivery::Kind::refused;
  news[1].text = "another program has it";
  CameraDrivers drivers = driver_of(std::make_unique<ToldCamera>(camera::CameraSetup{}, std::move(news)));
  auto recorder = CameraRecorder::start(left_camera(), drivers, session.string(), net::read_clocks());
  ASSERT_TRUE(recorder.has_value());
  std::vector<CaptureEvent> events;
  for (int i = 0; i < 400 && (events.empty() || events.back().text != "another program has it"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    for (CaptureEvent& event : (*recorder)->take_events()) events.push_back(std::move(event));
  }
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().text, "another program has it");
  EXPECT_TRUE(events.back().is_gap);
  EXPECT_EQ((*recorder)->status().state, "lost");
  (*recorder)->finish();
}

// In the sun it exposes for less than when it was set up: its images come sooner after their pulses.
TEST(CameraRecorderPulses, OfAnExposureThatVariesMayComeSoonerThanItWasAtFirst) {
  const fs::path session = scratch_folder("camera_exposure");
  const net::ClockReading start = net::read_clocks();
  const net::SessionClock clock(start);
  camera::CameraSetup setup;
  setup.pixel_format = "Mono8";
  setup.exposure_us = 15'000.0;
  setup.exposure_varies = true;
  auto made = std::make_unique<PulsedCamera>(setup);
  PulsedCamera& pulsed = *made;
  CameraDrivers drivers = driver_of(std::move(made));
  RigCamera wanted = left_camera();
  wanted.config.trigger = camera::TriggerConfig{"Line0", false, 0.0};
  wanted.has_pulses = true;
  auto recorder = CameraRecorder::start(wanted, drivers, session.string(), start);
  ASSERT_TRUE(recorder.has_value());
  for (int i = 0; i < 400 && (*recorder)->status().state != "waits"; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  constexpr int pulses = 20;
  for (int i = 0; i < pulses; ++i) {
    const std::int64_t now_ns = net::read_clocks().monotonic_ns;
    (*recorder)->add_pulse({i, clock.from_monotonic(now_ns)});
    pulsed.pulse(now_ns);
    std::this_thread::sleep_for(std::chrono::milliseconds(60 + 25 * (i % 3)));
  }
  for (int i = 0; i < 400 && (*recorder)->status().written < pulses; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  (*recorder)->finish();
  const auto frames = read_frames((session / "images" / "left" / "frames.csv").string());
  ASSERT_TRUE(frames.has_value()) << frames.error().message();
  ASSERT_EQ(frames->size(), static_cast<std::size_t>(pulses));
  for (std::size_t i = 0; i < frames->size(); ++i) {
    ASSERT_TRUE((*frames)[i].trigger.has_value()) << i;
    EXPECT_EQ(*(*frames)[i].trigger, static_cast<std::int64_t>(i));
  }
}

// Pulses come all the time, also while the camera is set up anew: none of them can have released an image.
TEST(CameraRecorderPulses, AreOfTheCameraAsItWasSetUpLast) {
  const fs::path session = scratch_folder("camera_pulses");
  const net::ClockReading start = net::read_clocks();
  std::atomic<CameraRecorder*> there = nullptr;
  std::atomic<std::int64_t> pulses = 0;
  const auto pulse = [&] {
    const std::int64_t now_ns = net::SessionClock(start).from_monotonic(net::read_clocks().monotonic_ns);
    if (CameraRecorder* recorder = there) recorder->add_pulse({pulses++, now_ns});
  };
  CameraDrivers drivers = driver_of(std::make_unique<LateStarter>(pulse));
  RigCamera wanted = left_camera();
  wanted.config.trigger = camera::TriggerConfig{"Line0", false, 0.0};
  wanted.has_pulses = true;
  auto recorder = CameraRecorder::start(wanted, drivers, session.string(), start);
  ASSERT_TRUE(recorder.has_value());
  std::vector<CaptureEvent> events;
  for (int i = 0; i < 200 && events.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    events = (*recorder)->take_events();
  }
  EXPECT_THAT(events, Contains(Field(&CaptureEvent::text, HasSubstr("does not start yet"))));
  there = recorder->get();
  for (int i = 0; i < 800 && (*recorder)->status().state != "waits"; ++i) {
    if (i < 100) pulse();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ((*recorder)->status().state, "waits");
  EXPECT_GT(pulses, 100) << "one more while it was set up the second time";
  (*recorder)->finish();
  ASSERT_TRUE((*recorder)->status().matching.has_value());
  EXPECT_EQ((*recorder)->status().matching->pulses, 0U);
}

TEST(TriggerLines, PulseAsOftenAsTheSlowestCameraIsToSend) {
  const std::string camera = "driver: aravis, trigger: {source: Line0}";
  EXPECT_FALSE(trigger_options(rig_with(camera)).has_value());
  const auto usual = trigger_options(rig_with(camera, "trigger: {gpiochip: gpiochip0, line: 17, pulse_us: 500}\n"));
  ASSERT_TRUE(usual.has_value());
  EXPECT_EQ(usual->output->line, 17U);
  EXPECT_EQ(usual->pattern.period_ns, 500'000'000);
  EXPECT_EQ(usual->pattern.width_ns, 500'000);
  const auto fast =
      trigger_options(rig_with(camera + ", frame_rate: 20", "trigger: {gpiochip: gpiochip0, line: 17}\n"));
  EXPECT_EQ(fast->pattern.period_ns, 50'000'000);
  const auto listens = trigger_options(rig_with(camera, "trigger: {gpiochip: gpiochip0, pps: /dev/pps0}\n"));
  ASSERT_TRUE(listens.has_value());
  EXPECT_FALSE(listens->output.has_value());
  EXPECT_EQ(listens->pps, "/dev/pps0");
}

TEST_F(CameraRecorderLive, ACameraThatIsTriggeredBySoftwareIsToldWhereImagesAreWanted) {
  auto recorder = record(rig("trigger: {source: Software}, frame_rate: 10"));
  ASSERT_TRUE(wait_for([&] { return recorder->status().state == "waits"; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(recorder->status().counters.whole(), 0U);
  recorder->want_images(true);
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_TRUE(wait_for([&] { return recorder->status().written >= 5; }));
  EXPECT_GE(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(350)) << "ten a second, not more";
  recorder->want_images(false);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const std::uint64_t so_far = recorder->status().counters.whole();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(recorder->status().counters.whole(), so_far);
  recorder->finish();
}

TEST_F(CameraRecorderLive, ImagesThatCannotBeWrittenAreSaidAtOnceAndTheCameraIsGivenFree) {
  auto recorder = record(rig());
  ASSERT_TRUE(wait_for([&] { return recorder->status().written >= 2; }));
  fs::remove_all(session / "images");
  ASSERT_TRUE(wait_for([&] { return recorder->status().failure.has_value(); }));
  EXPECT_EQ(recorder->status().state, "failed");
  EXPECT_THAT(recorder->status().failure->message(), HasSubstr("images/left"));
  std::vector<CaptureEvent> events;
  ASSERT_TRUE(wait_for([&] {
    for (CaptureEvent& event : recorder->take_events()) events.push_back(std::move(event));
    return !events.empty() && events.back().is_gap;
  }));
  EXPECT_THAT(events.back().text, HasSubstr("its images cannot be written"));
  const std::uint64_t written = recorder->status().written;
  recorder->finish();
  EXPECT_EQ(recorder->status().state, "failed");
  EXPECT_EQ(recorder->status().written, written);
  EXPECT_EQ(recorder->status().dropped_by_queue, 0U);
}

TEST_F(CameraRecorderLive, ACameraThatComesLateIsTakenThen) {
  server.reset();
  auto recorder = record(rig());
  std::vector<CaptureEvent> events;
  ASSERT_TRUE(wait_for([&] {
    events = recorder->take_events();
    return !events.empty();
  }));
  EXPECT_THAT(events, Contains(Field(&CaptureEvent::text, HasSubstr("there is no such camera"))));
  EXPECT_TRUE(events[0].is_gap);
  serve();
  EXPECT_TRUE(wait_for([&] { return recorder->status().written > 0; }));
  recorder->finish();
}

TEST_F(CameraRecorderLive, StopsWhileItSearches) {
  server.reset();
  auto recorder = record(rig());
  recorder.reset();
  const auto frames = read_frames((session / "images" / "left" / "frames.csv").string());
  ASSERT_TRUE(frames.has_value());
  EXPECT_TRUE(frames->empty());
}

TEST_F(CameraRecorderLive, ACameraThatFellSilentHoldsNobodyUp) {
  auto recorder = record(rig());
  ASSERT_TRUE(wait_for([&] { return recorder->status().written >= 2; }));
  server->fall_silent(0, std::numeric_limits<std::int64_t>::max());
  const auto stopped = std::chrono::steady_clock::now();
  recorder->finish();
  // It would take three questions of 2.5 s each to be sure that the camera is gone.
  EXPECT_LT(std::chrono::steady_clock::now() - stopped, CameraRecorder::kMostClosing + std::chrono::seconds(3));
  EXPECT_THAT(recorder->take_events(), Contains(Field(&CaptureEvent::text, HasSubstr("does not answer"))));
  EXPECT_TRUE(CameraRecorder::has_left_a_camera());
  const auto frames = read_frames((session / "images" / "left" / "frames.csv").string());
  ASSERT_TRUE(frames.has_value());
  EXPECT_EQ(frames->size(), recorder->status().written);
  EXPECT_TRUE(wait_for([&] { return recorder->status().state == "ended"; })) << "what was left behind ends, too";
}

TEST_F(CameraRecorderLive, TheDoctorTakesItAndSaysWhatItSees) {
  const Rig of = rig();
  const auto findings = survey_cameras(rig_cameras(of), drivers, 3.0, {});
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_FALSE(findings[0].trouble.has_value());
  EXPECT_GE(findings[0].counters.whole(), 5U);
  const Rig wrong = rig("pixel_format: Mono16");
  const auto refused = survey_cameras(rig_cameras(wrong), drivers, 3.0, {});
  ASSERT_TRUE(refused[0].trouble.has_value());
  EXPECT_THAT(refused[0].trouble->message(), HasSubstr("left"));
  EXPECT_THAT(refused[0].trouble->mend, HasSubstr("BayerRG8"));
  const Rig small =
      rig("intrinsics: {model: radtan, width: 640, height: 480, fx: 400, fy: 400, cx: 320, cy: 240, "
          "distortion: [0, 0, 0, 0, 0]}");
  const auto checks = check_cameras(survey_cameras(rig_cameras(small), drivers, 3.0, {}), {}, {});
  EXPECT_THAT(checks, Contains(Field(&Check::what, HasSubstr("it sends 320 x 240 pixels"))));
}

}  // namespace
}  // namespace rigcal
