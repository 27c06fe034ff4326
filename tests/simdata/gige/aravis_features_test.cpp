// The virtual camera's control side, with Aravis as the host.
#include <gmock/gmock.h>

#include <cmath>
#include <thread>

#include "drivers/net/udp_socket.h"
#include "tests/simdata/gige/aravis_host.h"

namespace rigcal::sim {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

class AravisFeatures : public testing::Test {
 protected:
  void serve(const ServedCamera& camera) {
    auto started = CameraServer::start({camera});
    ASSERT_TRUE(started.has_value()) << started.error().message();
    server = *std::move(started);
  }
  Held<ArvCamera> open() {
    auto camera = open_camera(address_of(device), problem);
    EXPECT_TRUE(camera) << problem.text();
    return camera;
  }

  ServedCamera device = served_camera(31);
  std::unique_ptr<CameraServer> server;
  Problem problem;
};

TEST_F(AravisFeatures, CamerasAreFoundByABroadcast) {
  auto started = CameraServer::start({device, served_camera(32, "00F12345679")});
  ASSERT_TRUE(started.has_value()) << started.error().message();
  arv_update_device_list();
  std::vector<std::string> ids;
  std::vector<std::string> addresses;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    ids.emplace_back(arv_get_device_id(i));
    addresses.emplace_back(arv_get_device_address(i));
  }
  EXPECT_THAT(ids, Contains("Hikrobot-MV-CA013-21UC-00F12345678"));
  EXPECT_THAT(ids, Contains("Hikrobot-MV-CA013-21UC-00F12345679"));
  EXPECT_THAT(addresses, Contains("127.0.7.31"));
  EXPECT_THAT(addresses, Contains("127.0.7.32"));
  // And opened by that name, which is the one of the rig file.
  const auto camera = open_camera("Hikrobot-MV-CA013-21UC-00F12345679", problem);
  ASSERT_TRUE(camera) << problem.text();
  EXPECT_STREQ(arv_camera_get_device_serial_number(camera.get(), &problem), "00F12345679");
}

TEST_F(AravisFeatures, EveryFeatureOfTheDescriptionCanBeRead) {
  serve(device);
  const auto camera = open();
  ASSERT_TRUE(camera);
  ArvGc* description = arv_device_get_genicam(arv_camera_get_device(camera.get()));
  int values = 0;
  const auto visit = [&](const auto& self, const char* name) -> void {
    ArvGcNode* node = arv_gc_get_node(description, name);
    ASSERT_NE(node, nullptr) << name;
    if (ARV_IS_GC_CATEGORY(node)) {
      for (const GSList* i = arv_gc_category_get_features(ARV_GC_CATEGORY(node)); i != nullptr; i = i->next)
        self(self, static_cast<const char*>(i->data));
      return;
    }
    // Chunks are read from frames, commands not at all.
    if (ARV_IS_GC_COMMAND(node) || (std::string(name).rfind("Chunk", 0) == 0 && ARV_IS_GC_FEATURE_NODE(node) &&
                                    !ARV_IS_GC_ENUMERATION(node) && !ARV_IS_GC_BOOLEAN(node)))
      return;
    const char* text = arv_gc_feature_node_get_value_as_string(ARV_GC_FEATURE_NODE(node), &problem);
    EXPECT_TRUE(problem.is_none()) << name << ": " << problem.text();
    EXPECT_NE(text, nullptr) << name;
    ++values;
  };
  visit(visit, "Root");
  EXPECT_GT(values, 55);
}

TEST_F(AravisFeatures, SettingsAreKeptWithinTheirLimits) {
  serve(device);
  const auto opened = open();
  ASSERT_TRUE(opened);
  ArvCamera* camera = opened.get();
  EXPECT_STREQ(arv_camera_get_vendor_name(camera, &problem), "Hikrobot");
  EXPECT_STREQ(arv_camera_get_model_name(camera, &problem), "MV-CA013-21UC");

  arv_camera_set_region(camera, 8, 2, 640, 480, &problem);
  EXPECT_TRUE(problem.is_none()) << problem.text();
  gint x = 0;
  gint y = 0;
  gint width = 0;
  gint height = 0;
  arv_camera_get_region(camera, &x, &y, &width, &height, &problem);
  EXPECT_THAT((std::vector<int>{x, y, width, height}), ElementsAre(8, 2, 640, 480));
  gint least = 0;
  gint most = 0;
  arv_camera_get_x_offset_bounds(camera, &least, &most, &problem);
  EXPECT_EQ(most, 640);
  EXPECT_EQ(arv_camera_get_payload(camera, &problem), 640U * 480);

  guint count = 0;
  const char** formats = arv_camera_dup_available_pixel_formats_as_strings(camera, &count, &problem);
  EXPECT_THAT(std::vector<std::string>(formats, formats + count), ElementsAre("BayerRG8", "BayerRG12", "Mono8"));
  g_free(formats);
  arv_camera_set_pixel_format_from_string(camera, "BayerRG12", &problem);
  EXPECT_TRUE(problem.is_none()) << problem.text();
  EXPECT_EQ(arv_camera_get_pixel_format(camera, &problem), 0x01100011U);
  arv_camera_set_pixel_format_from_string(camera, "Mono16", &problem);
  EXPECT_FALSE(problem.is_none());

  arv_camera_set_exposure_time(camera, 2345.0, &problem);
  EXPECT_NEAR(arv_camera_get_exposure_time(camera, &problem), 2345.0, 0.01);
  double shortest = 0.0;
  double longest = 0.0;
  arv_camera_get_exposure_time_bounds(camera, &shortest, &longest, &problem);
  EXPECT_EQ(shortest, 15.0);
  EXPECT_EQ(longest, 1e7);
  arv_camera_set_gain(camera, 12.5, &problem);
  EXPECT_NEAR(arv_camera_get_gain(camera, &problem), 12.5, 1e-5);
  arv_camera_set_frame_rate(camera, 25.0, &problem);
  EXPECT_TRUE(problem.is_none()) << problem.text();
  EXPECT_NEAR(arv_camera_get_frame_rate(camera, &problem), 25.0, 1e-4);
  EXPECT_TRUE(arv_camera_is_software_trigger_supported(camera, &problem));

  arv_camera_set_string(camera, "DeviceUserID", "left", &problem);
  EXPECT_STREQ(arv_camera_get_string(camera, "DeviceUserID", &problem), "left");
  const double temperature = arv_camera_get_float(camera, "DeviceTemperature", &problem);
  EXPECT_GT(temperature, 25.0);
  EXPECT_LT(temperature, 50.0);
  EXPECT_TRUE(problem.is_none()) << problem.text();
}

TEST_F(AravisFeatures, SelectorsChooseAmongLinesChunksAndUserSets) {
  serve(device);
  const auto opened = open();
  ASSERT_TRUE(opened);
  ArvCamera* camera = opened.get();
  arv_camera_set_string(camera, "LineSelector", "Line2", &problem);
  arv_camera_set_string(camera, "LineMode", "Strobe", &problem);
  arv_camera_set_boolean(camera, "StrobeEnable", TRUE, &problem);
  arv_camera_set_integer(camera, "StrobeLineDuration", 250, &problem);
  EXPECT_TRUE(problem.is_none()) << problem.text();
  arv_camera_set_string(camera, "LineSelector", "Line0", &problem);
  EXPECT_STREQ(arv_camera_get_string(camera, "LineMode", &problem), "Input");
  EXPECT_EQ(arv_camera_get_integer(camera, "StrobeLineDuration", &problem), 0);
  arv_camera_set_string(camera, "LineMode", "Strobe", &problem);
  EXPECT_THAT(problem.text(), HasSubstr("parameter"));
  arv_camera_set_string(camera, "LineSelector", "Line2", &problem);
  EXPECT_STREQ(arv_camera_get_string(camera, "LineMode", &problem), "Strobe");
  EXPECT_EQ(arv_camera_get_integer(camera, "StrobeLineDuration", &problem), 250);

  arv_camera_set_chunks(camera, "ExposureTime,FrameID", &problem);
  EXPECT_TRUE(problem.is_none()) << problem.text();
  EXPECT_TRUE(arv_camera_get_chunk_state(camera, "ExposureTime", &problem));
  EXPECT_FALSE(arv_camera_get_chunk_state(camera, "Gain", &problem));
  EXPECT_EQ(arv_camera_get_payload(camera, &problem), 1280U * 1024 + 8 + 2 * 16);

  arv_camera_set_string(camera, "UserSetSelector", "Default", &problem);
  arv_camera_execute_command(camera, "UserSetLoad", &problem);
  EXPECT_TRUE(problem.is_none()) << problem.text();
  EXPECT_EQ(arv_camera_get_payload(camera, &problem), 1280U * 1024);
}

TEST_F(AravisFeatures, ItsClockIsLatched) {
  device.device.clock_start_ns = 50'000'000'000;
  serve(device);
  const auto opened = open();
  ASSERT_TRUE(opened);
  ArvCamera* camera = opened.get();
  EXPECT_EQ(arv_camera_get_integer(camera, "GevTimestampTickFrequency", &problem), 100'000'000);
  const auto latch = [&] {
    arv_camera_execute_command(camera, "GevTimestampControlLatch", &problem);
    EXPECT_TRUE(problem.is_none()) << problem.text();
    return static_cast<double>(arv_camera_get_integer(camera, "GevTimestampValue", &problem)) * 1e-8;
  };
  const double first = latch();
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const double second = latch();
  EXPECT_GE(first, 50.0);
  EXPECT_GE(second - first, 0.1);
}

TEST_F(AravisFeatures, ASecondHostIsTurnedAway) {
  serve(device);
  auto first = open();
  ASSERT_TRUE(first);
  const auto second = open_camera(address_of(device), problem);
  // Aravis opens it to be read; what is written is refused.
  if (second) arv_camera_set_exposure_time(second.get(), 3000.0, &problem);
  EXPECT_FALSE(problem.is_none());
  EXPECT_TRUE(server->counts()[0].is_owned);
  first.reset();
  EXPECT_FALSE(server->counts()[0].is_owned);
  const auto third = open();
  arv_camera_set_exposure_time(third.get(), 3000.0, &problem);
  EXPECT_TRUE(problem.is_none()) << problem.text();
}

TEST_F(AravisFeatures, AHostThatCrashedLosesItsCamera) {
  serve(device);
  // It takes control, sets the shortest heartbeat, and is not heard of again.
  auto crashed = host_socket();
  ASSERT_TRUE(crashed.has_value());
  const gige::Request request =
      gige::WriteRegistersRequest{{{gige::bootstrap::kPrivilege, 2}, {gige::bootstrap::kHeartbeatTimeout, 500}}};
  ASSERT_TRUE(*crashed->send({device.device.identity.ip, gige::kControlPort}, gige::encode_request(request, 1)));
  const auto wait_for_owner = [this](bool owned) {
    for (int i = 0; i < 300 && server->counts()[0].is_owned != owned; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return server->counts()[0].is_owned == owned;
  };
  ASSERT_TRUE(wait_for_owner(true));
  ASSERT_TRUE(wait_for_owner(false));
  const auto camera = open();
  ASSERT_TRUE(camera);
  arv_camera_set_exposure_time(camera.get(), 3000.0, &problem);
  EXPECT_TRUE(problem.is_none()) << problem.text();
}

TEST_F(AravisFeatures, ASlowCameraIsWaitedFor) {
  device.device.answer_delay_s = 0.15;
  serve(device);
  auto client = host_socket();
  ASSERT_TRUE(client.has_value());
  static_cast<void>(client->send({device.device.identity.ip, gige::kControlPort},
                                 gige::encode_request(gige::ReadRegistersRequest{{0}}, 9)));
  net::ReceiveBatch batch(4);
  std::vector<std::uint16_t> acks;
  for (int i = 0; i < 300 && acks.size() < 2; ++i) {
    const auto count = client->receive(batch);
    for (std::size_t k = 0; count && k < *count; ++k) acks.push_back(gige::parse_ack(batch[k].bytes)->ack);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_THAT(acks, ElementsAre(0x0089, 0x0081));
}

TEST_F(AravisFeatures, ACameraMovesToAnotherAddressByForce) {
  serve(device);
  auto client = host_socket();
  ASSERT_TRUE(client.has_value());
  const gige::ForceIpRequest request{device.device.identity.mac, {127, 0, 7, 35}, {255, 0, 0, 0}, {}};
  ASSERT_TRUE(*client->send({{127, 255, 255, 255}, gige::kControlPort}, gige::encode_request(request, 1)));
  Held<ArvCamera> camera;
  for (int i = 0; i < 50 && !camera; ++i) camera = open_camera("127.0.7.35", problem);
  ASSERT_TRUE(camera) << problem.text();
  Stream stream(camera.get());
  stream.start();
  EXPECT_EQ(stream.frame().status, ARV_BUFFER_STATUS_SUCCESS);
}

TEST_F(AravisFeatures, AnAddressInUseIsSaid) {
  serve(device);
  const auto again = CameraServer::start({device});
  ASSERT_FALSE(again.has_value());
  EXPECT_THAT(again.error().message(), HasSubstr("127.0.7.31:3956"));
  ServedCamera elsewhere = device;
  elsewhere.device.identity.ip = {203, 0, 113, 7};
  EXPECT_THAT(CameraServer::start({elsewhere}).error().message(), HasSubstr("203.0.113.7"));
}

}  // namespace
}  // namespace rigcal::sim
