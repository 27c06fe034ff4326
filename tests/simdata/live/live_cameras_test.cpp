// The cameras of a simulated run on the network, with Aravis as their host.
#include <gmock/gmock.h>

#include <thread>

#include "core/io/frame_files.h"
#include "core/io/image_file.h"
#include "simdata/live/camera_units.h"
#include "simdata/live/live_run.h"
#include "simdata/scene/scene_file.h"
#include "simdata/session/session_images.h"
#include "tests/simdata/gige/aravis_host.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::sim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Rig camera_rig() {
  auto rig = parse_rig(R"(rigcal: 1
name: cameras
base: left
sensors:
  left:
    type: camera
    driver: aravis
    device: "Hikrobot-MV-CA013-21UC-00F12345678"
    pixel_format: BayerRG8
    exposure_us: 4000
    trigger: {source: Line0, activation: rising, delay_us: 250}
    intrinsics: {model: radtan, width: 160, height: 128, fx: 110.0, fy: 110.0, cx: 79.5, cy: 63.5,
                 distortion: [0.0, 0.0, 0.0, 0.0, 0.0]}
  right:
    type: camera
    driver: aravis
    device: 127.0.9.77
    pixel_format: Mono12
    intrinsics: {model: radtan, width: 96, height: 64, fx: 80.0, fy: 80.0, cx: 47.5, cy: 31.5,
                 distortion: [0.0, 0.0, 0.0, 0.0, 0.0]}
  other:
    type: camera
    driver: images
initial_extrinsics:
  right: {translation: [0.1, 0.0, 0.0], rotation_xyzw: [0.0, 0.0, 0.0, 1.0]}
lidar: {interface: lo, host_ip: 127.0.9.1}
)",
                       "cameras.yaml");
  EXPECT_TRUE(rig.has_value()) << rig.error().message();
  return *std::move(rig);
}

LiveOptions short_run() {
  LiveOptions live;
  live.run.seed = 5;
  live.run.images_per_stop = 2;
  live.run.turntable.stops = 2;
  live.run.turntable.dwell_s = 0.6;
  live.run.turntable.initial_still_s = 0.6;
  live.run.turntable.turn_s = 0.4;
  live.run.turntable.final_still_s = 0.3;
  return live;
}

/// Serves a rig in a thread until the run is over or the test is.
class Served {
 public:
  Served(const Rig& rig, const LiveOptions& options)
      : thread_([this, rig, options](const std::stop_token& stop) {
          const auto scene = load_scene("room");
          SilentReporter silent;
          auto done = serve_live(*scene, rig, options, {silent, stop});
          EXPECT_TRUE(done.has_value()) << done.error().message();
          if (done) summary_ = *done;
        }) {}
  LiveSummary finish() {
    thread_.join();
    return summary_;
  }

 private:
  LiveSummary summary_;
  std::jthread thread_;
};

Held<ArvCamera> wait_for(const std::string& address) {
  Problem problem;
  for (int i = 0; i < 50; ++i) {
    if (auto camera = open_camera(address, problem)) return camera;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ADD_FAILURE() << problem.text();
  return nullptr;
}

TEST(LiveCameras, TriggeredTheySendTheImagesOfTheSession) {
  const Rig rig = camera_rig();
  const LiveOptions options = short_run();
  // What the same run has on disk.
  const auto folder = scratch_folder("live_cameras");
  const auto scene = load_scene("room");
  const auto simulated =
      make_simulated_rig(rig, scene->T_scene_table, options.run.turntable, options.run.mount_error, options.run.seed);
  ASSERT_TRUE(simulated.has_value()) << simulated.error().message();
  SilentReporter silent;
  GroundTruth truth;
  const auto count =
      write_session_images(*scene, rig, *simulated, options.run.seed, {}, 2, folder.string(), {silent}, truth);
  ASSERT_TRUE(count.has_value()) << count.error().message();
  ASSERT_EQ(*count, 8U);

  Served served(rig, options);
  {
    const auto left = wait_for("127.0.9.31");
    const auto right = wait_for("127.0.9.77");
    ASSERT_TRUE(left && right);
    Problem problem;
    for (ArvCamera* camera : {left.get(), right.get()}) {
      arv_camera_set_trigger(camera, "Line0", &problem);
      ASSERT_TRUE(problem.is_none()) << problem.text();
    }
    arv_camera_set_float(left.get(), "TriggerDelay", 250.0, &problem);
    EXPECT_STREQ(arv_camera_get_device_serial_number(left.get(), &problem), "00F12345678");
    EXPECT_STREQ(arv_camera_get_string(right.get(), "DeviceUserID", &problem), "right");
    EXPECT_EQ(arv_camera_get_exposure_time(left.get(), &problem), 4000.0);
    Stream left_stream(left.get());
    Stream right_stream(right.get());
    right_stream.start();
    left_stream.start();
    const auto expect_images = [&folder](Stream& stream, const std::string& name) {
      for (int i = 0; i < 4; ++i) {
        const Frame frame = stream.frame(std::chrono::milliseconds(10000));
        ASSERT_EQ(frame.status, ARV_BUFFER_STATUS_SUCCESS) << name << " " << i;
        const auto image = read_image((folder / "images" / name / ("00000" + std::to_string(i) + ".png")).string());
        ASSERT_TRUE(image.has_value());
        EXPECT_EQ(frame.width, image->width);
        EXPECT_TRUE(frame.bytes == image->bytes) << name << " " << i;
      }
    };
    expect_images(left_stream, "left");
    expect_images(right_stream, "right");
  }
  const LiveSummary summary = served.finish();
  EXPECT_TRUE(summary.is_complete);
  ASSERT_EQ(summary.cameras.size(), 2U);
  EXPECT_EQ(summary.cameras[0].name, "left");
  EXPECT_EQ(summary.cameras[0].counts.stream.blocks, 4U);
}

TEST(LiveCameras, RunningFreelyTheyShowWhatThereIsAsTheyAreSet) {
  LiveOptions options = short_run();
  options.loop = true;
  Served served(camera_rig(), options);
  const auto camera = wait_for("127.0.9.31");
  ASSERT_TRUE(camera);
  Problem problem;
  arv_camera_set_frame_rate(camera.get(), 20.0, &problem);
  arv_camera_set_region(camera.get(), 16, 8, 64, 48, &problem);
  arv_camera_set_exposure_time(camera.get(), 1000.0, &problem);
  ASSERT_TRUE(problem.is_none()) << problem.text();
  const auto mean_of = [&camera] {
    Stream stream(camera.get());
    stream.start();
    // On a busy machine packets may come too late for a frame.
    Frame frame;
    for (int i = 0; i < 20 && frame.bytes.empty(); ++i) frame = stream.frame(std::chrono::milliseconds(10000));
    EXPECT_EQ(frame.bytes.size(), 64U * 48);
    double sum = 0.0;
    for (const std::uint8_t value : frame.bytes) sum += value;
    return sum / static_cast<double>(frame.bytes.size());
  };
  const double dark = mean_of();
  arv_camera_set_exposure_time(camera.get(), 4000.0, &problem);
  const double bright = mean_of();
  EXPECT_GT(bright, 2.0 * dark);
}

TEST(LiveCameras, RestartAndAreTakenByOthersWhenAsked) {
  LiveOptions options = short_run();
  options.loop = true;
  options.cameras.is_test_pattern = true;
  options.incidents = {{"right", 0.0, Incident::Kind::owned_by_other, 1.0, 0}};
  Served served(camera_rig(), options);
  const auto right = wait_for("127.0.9.77");
  ASSERT_TRUE(right);  // Aravis takes it once the other one lets go.
  Problem problem;
  arv_camera_set_gain(right.get(), 3.0, &problem);
  EXPECT_TRUE(problem.is_none()) << problem.text();
}

TEST(CameraUnits, LiveWhereTheRigSaysOrFromThirtyOneOn) {
  Rig rig = camera_rig();
  auto addresses = camera_addresses(rig);
  ASSERT_TRUE(addresses.has_value());
  EXPECT_THAT(*addresses, ElementsAre(gige::Ipv4{127, 0, 9, 31}, gige::Ipv4{127, 0, 9, 77}, gige::Ipv4{}));
  rig.sensors[1].camera->device = "127.0.9.1";
  EXPECT_THAT(camera_addresses(rig).error().message(), HasSubstr("127.0.9.1"));
  rig.sensors[1].camera->device = "Basler-acA1300-60gc-22334455";
  rig.network.host_ip = "127.0.9.31";
  addresses = camera_addresses(rig);
  EXPECT_THAT(*addresses, ElementsAre(gige::Ipv4{127, 0, 9, 32}, gige::Ipv4{127, 0, 9, 33}, gige::Ipv4{}));
}

TEST(CameraUnits, SayWhoTheyAreAsTheRigHasIt) {
  const Rig rig = camera_rig();
  const auto left = camera_identity(rig.sensors[0], {127, 0, 9, 31});
  EXPECT_EQ(left.manufacturer, "Hikrobot");
  EXPECT_EQ(left.model, "MV-CA013-21UC");
  EXPECT_EQ(left.serial, "00F12345678");
  EXPECT_EQ(left.user_name, "left");
  const auto right = camera_identity(rig.sensors[1], {127, 0, 9, 77});
  EXPECT_EQ(right.serial, "right");
  EXPECT_NE(left.mac, right.mac);
  EXPECT_THAT(*camera_formats(rig.sensors[0]),
              ElementsAre("BayerRG8", "BayerRG10", "BayerRG12", "Mono8", "Mono10", "Mono12"));
  Sensor odd = rig.sensors[0];
  odd.camera->pixel_format = "BayerRG14";
  EXPECT_THAT(camera_formats(odd).error().message(), HasSubstr("BayerRG14"));
}

}  // namespace
}  // namespace rigcal::sim
