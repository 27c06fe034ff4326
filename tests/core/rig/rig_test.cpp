#include "core/rig/rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/records/records.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

const char* const full_example = R"(
rigcal: 1                       # version of this format
name: turntable-lab
base: avia
sensors:
  avia:          {type: livox_avia,  broadcast_code: "3JEDHC900100791", ip: 192.168.1.179, range: [1.5, 200]}
  mid100_left:   {type: livox_mid40, broadcast_code: "0TFDG3B00600551", ip: 192.168.1.21, return_mode: strongest,
                  coordinates: spherical, imu: false, scan_pattern: non_repetitive, folder: left}
  top:           {type: lidar, rings: true, topic: /points, imu_topic: /imu}
  camera_left:
    type: camera
    driver: aravis
    device: "Hikrobot-MV-CA013-21UC-00F12345678"
    pixel_format: BayerRG8
    exposure_us: 5000
    gain: 3.5
    frame_rate: 10
    packet_size: 9000
    packet_delay: 100
    ptp: true
    strobe: Line2
    trigger: {source: Line0, activation: falling, delay_us: 2.5}
    intrinsics: {model: radtan, width: 1280, height: 1024, fx: 863.0, fy: 864.0, cx: 639.5, cy: 511.5,
                 distortion: [-0.1, 0.2, 1e-3, -2e-3, 0.05]}
initial_extrinsics:
  mid100_left: {translation: [0.0, 0.10, -0.05], rotation_xyzw: [0, 0, 0.2588, 0.9659]}
turntable: {driver: serial, axis: [0, 0, 2], port: /dev/ttyUSB0, baud: 9600, protocol: ascii, reverse: true,
             letter: A, speed_deg_s: 12.5, move: "GO {angle}", ask: none, answer: "AT {angle}", done: OK, fault: "E"}
trigger:   {gpiochip: gpiochip0, line: 17, pulse_us: 500, strobe_line: 18, pps: /dev/pps0}
lidar:     {interface: eth0, host_ip: 192.168.1.50, send_utc: true}
board:     {type: checkerboard, inner_corners: [10, 8], square: 0.07, size: [0.77, 0.63], offset: [0, 0.01]}
)";

Rig read(const std::string& text) {
  Expected<Rig> rig = parse_rig(text, "rig.yaml");
  EXPECT_TRUE(rig) << rig.error().message();
  return *rig;
}

TEST(Rig, ReadsEveryKey) {
  const Rig rig = read(full_example);
  EXPECT_EQ(rig.name, "turntable-lab");
  ASSERT_EQ(rig.sensors.size(), 4U);
  EXPECT_EQ(rig.base, 0);
  const LidarSettings& avia = *rig.sensors[0].lidar;
  EXPECT_EQ(avia.model, LidarModel::livox_avia);
  EXPECT_EQ(avia.broadcast_code, "3JEDHC900100791");
  EXPECT_EQ(to_string(*avia.ip), "192.168.1.179");
  EXPECT_EQ((*avia.range_m)[0], 1.5);
  EXPECT_EQ((*avia.range_m)[1], 200.0);
  const LidarSettings& left = *rig.sensors[1].lidar;
  EXPECT_EQ(left.return_mode, ReturnMode::strongest);
  EXPECT_EQ(left.coordinates, CoordinateSystem::spherical);
  EXPECT_EQ(left.imu, false);
  EXPECT_EQ(left.scan_pattern, "non_repetitive");
  EXPECT_EQ(rig.sensors[1].folder, "left");
  EXPECT_TRUE(rig.sensors[2].lidar->rings);
  EXPECT_EQ(rig.sensors[2].lidar->topic, "/points");
  const CameraSettings& camera = *rig.sensors[3].camera;
  EXPECT_FALSE(rig.sensors[3].is_lidar());
  EXPECT_EQ(camera.driver, "aravis");
  EXPECT_EQ(camera.gain, 3.5);
  EXPECT_EQ(camera.packet_delay, 100);
  EXPECT_EQ(camera.trigger->activation, "falling");
  EXPECT_EQ(camera.trigger->delay_us, 2.5);
  EXPECT_EQ(camera.intrinsics->fy, 864.0);
  EXPECT_THAT(camera.intrinsics->distortion, testing::ElementsAre(-0.1, 0.2, 1e-3, -2e-3, 0.05));
  EXPECT_EQ(rig.turntable->axis->z(), 1.0);  // made a unit vector
  EXPECT_EQ(rig.turntable->protocol, "ascii");
  EXPECT_TRUE(rig.turntable->is_reversed);
  EXPECT_EQ(rig.turntable->letter, "A");
  EXPECT_EQ(rig.turntable->speed_deg_s, 12.5);
  EXPECT_EQ(rig.turntable->move, "GO {angle}");
  EXPECT_EQ(rig.turntable->ask, "none");
  EXPECT_EQ(rig.turntable->done, "OK");
  EXPECT_EQ(rig.trigger->strobe_line, 18);
  EXPECT_EQ(rig.network.interface, "eth0");
  EXPECT_EQ(rig.board->inner_corners[1], 8);
}

TEST(Rig, NormalisesTheInitialRotation) {
  const Rig rig = read(full_example);
  EXPECT_FALSE(rig.sensors[0].initial_T_base_sensor);
  // The file's quaternion has four digits: 2 acos(0.9659) is 30 degrees within 0.01.
  EXPECT_THAT(*rig.sensors[1].initial_T_base_sensor, SE3Near(pose_deg(0, 0, 30, 0, 0.10, -0.05), 0.01, 1e-9));
  const Matrix3d& R = rig.sensors[1].initial_T_base_sensor->R;
  // A rotation to rounding, which 0.2588 and 0.9659 as they stand are not (they miss by 6e-5).
  EXPECT_LT((R * R.transpose() - Matrix3d::Identity()).norm(), 1e-14);
}

TEST(Rig, KnowsBoardsWithMarkers) {
  const std::string text =
      "rigcal: 1\nbase: a\nsensors:\n  a: {type: lidar}\nboard: {type: charuco, inner_corners: [7, 5], square: 0.1, "
      "dictionary: DICT_5X5_100, marker: 0.075}\n";
  const Rig rig = read(text);
  const Rig again = read(write_rig(rig));
  for (const Rig* r : {&rig, &again}) {
    EXPECT_EQ(r->board->type, "charuco");
    EXPECT_EQ(r->board->dictionary, "DICT_5X5_100");
    EXPECT_EQ(r->board->marker, 0.075);
  }
}

TEST(Rig, FindsSensorsByName) {
  const Rig rig = read(full_example);
  EXPECT_EQ(rig.find("camera_left"), 3);
  EXPECT_EQ(rig.find("camera"), -1);
}

TEST(Rig, IsTheSameAfterWritingAndReading) {
  const Rig rig = read(full_example);
  const std::string text = write_rig(rig);
  const Rig again = read(text);
  EXPECT_EQ(again.sensors.size(), rig.sensors.size());
  // Doubles are written with all their digits; only the quaternion goes through a matrix.
  EXPECT_THAT(*again.sensors[1].initial_T_base_sensor, SE3Near(*rig.sensors[1].initial_T_base_sensor, 1e-12, 0.0));
  EXPECT_EQ(again.sensors[3].camera->intrinsics->distortion, rig.sensors[3].camera->intrinsics->distortion);
  // Every other difference would show in the text.
  Rig without_rotation = rig;
  Rig again_without_rotation = again;
  without_rotation.sensors[1].initial_T_base_sensor.reset();
  again_without_rotation.sensors[1].initial_T_base_sensor.reset();
  EXPECT_EQ(write_rig(again_without_rotation), write_rig(without_rotation));
  for (const char* word : {"spherical", "Line2", "/imu", "ttyUSB0", "strobe_line", "0.63", "folder", "host_ip"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word;
  }
}

TEST(Rig, ShippedRigFilesAreRightAndDifferOnlyInAddresses) {
  const std::string folder = std::string(RIGCAL_SOURCE_DIR) + "/config/rigs/";
  const Expected<Rig> turntable = load_rig(folder + "turntable.yaml");
  const Expected<Rig> loopback = load_rig(folder + "loopback.yaml");
  ASSERT_TRUE(turntable) << turntable.error().message();
  ASSERT_TRUE(loopback) << loopback.error().message();
  ASSERT_EQ(turntable->sensors.size(), loopback->sensors.size());
  for (const Sensor& sensor : loopback->sensors) {
    const Sensor& twin = turntable->sensors[static_cast<std::size_t>(turntable->find(sensor.name))];
    if (!sensor.is_lidar()) continue;
    EXPECT_EQ((*sensor.lidar->ip)[0], 127);
    EXPECT_EQ((*twin.lidar->ip)[0], 192);
    EXPECT_EQ(sensor.lidar->broadcast_code, twin.lidar->broadcast_code);
  }
  // The MID-100 looks backwards, its left unit turned by +30 degrees about z.
  const Sensor& left = turntable->sensors[static_cast<std::size_t>(turntable->find("mid100_left"))];
  EXPECT_THAT(*left.initial_T_base_sensor, SE3Near(pose_deg(0, 0, 210, -0.15, 0, -0.15), 1e-3, 1e-9));
}

TEST(Rig, ACameraMayBeTheBaseOnlyWhereThereAreNoLidars) {
  const std::string cameras = "rigcal: 1\nbase: a\nsensors:\n  a: {type: camera}\n  b: {type: camera}\n";
  EXPECT_TRUE(parse_rig(cameras, "rig.yaml"));
  EXPECT_FALSE(parse_rig(cameras + "  c: {type: livox_avia}\n", "rig.yaml"));
}

TEST(Rig, PixelFormatsWithoutAMosaicNeedNotBeReadable) {
  for (const char* name : {"BayerGB14", "Mono12Packed", "Mono10p", "BGRa8", "YUV422_8", "YCbCr422_8"}) {
    const Rig rig = read("rigcal: 1\nbase: a\nsensors:\n  a: {type: lidar}\n  c: {type: camera, pixel_format: " +
                         std::string(name) + "}\n");
    EXPECT_EQ(rig.sensors[1].camera->pixel_format, name);
  }
}

TEST(Rig, TellsFocalLengthsInMillimetresFromPixels) {
  const auto with_focal = [](const std::string& focal) {
    return parse_rig(
        "rigcal: 1\nbase: a\nsensors:\n  a: {type: lidar}\n  c: {type: camera,\n      intrinsics: {model: "
        "radtan, width: 1280, height: 1024, cx: 639.5, cy: 511.5,\n        " +
            focal + "}}\n",
        "rig.yaml");
  };
  const Expected<Rig> rig = with_focal("fx: 8.63, fy: 8.63");
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().where, "rig.yaml:7");
  EXPECT_NE(rig.error().message().find("were these millimetres?"), std::string::npos) << rig.error().message();
  EXPECT_TRUE(with_focal("fx: 150.0, fy: 150.0")) << "the widest of lenses";
}

TEST(Rig, ReadsWindowsLineEndings) {
  EXPECT_TRUE(parse_rig("rigcal: 1\r\nbase: a\r\nsensors:\r\n  a: {type: lidar}\r\n", "rig.yaml"));
}

}  // namespace
}  // namespace rigcal
