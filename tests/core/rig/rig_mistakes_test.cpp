#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/rig/rig.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

struct Mistake {
  const char* name;
  const char* text;
  const char* where;      ///< Expected "file:line".
  const char* complaint;  ///< Part of the message.
};

std::ostream& operator<<(std::ostream& out, const Mistake& mistake) { return out << mistake.name; }

class RigMistake : public testing::TestWithParam<Mistake> {};

TEST_P(RigMistake, IsNamedWithItsLine) {
  const Expected<Rig> rig = parse_rig(GetParam().text, "rig.yaml");
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().kind, ErrorKind::input);
  EXPECT_EQ(rig.error().where, GetParam().where);
  EXPECT_THAT(rig.error().message(), HasSubstr(GetParam().complaint));
}

#define HEAD "rigcal: 1\nbase: a\nsensors:\n"
#define ONE HEAD "  a: {type: livox_avia}\n"

const Mistake mistakes[] = {
    {"Empty", "", "rig.yaml", "is empty; check that it is the right file"},
    {"OnlyComment", "# nothing\n", "rig.yaml", "empty"},
    {"NotAMap", "- 1\n- 2\n", "rig.yaml:1", "not a map of keys and values; check"},
    {"NoVersion", "base: a\nsensors:\n  a: {type: lidar}\n", "rig.yaml:1", "'rigcal' is missing"},
    {"NewerVersion", "rigcal: 2\nsurprise: 1\n", "rig.yaml:1", "reads version 1; use rigcal 2.0 or newer"},
    {"VersionOfWrongKind", "rigcal: one\n", "rig.yaml:1", "not a whole number; write digits alone"},
    {"QuotedVersion", "rigcal: \"1\"\n", "rig.yaml:1", "not a whole number"},
    {"UnknownTopKey", "rigcal: 1\nbase: a\nsensor:\n  a: {type: lidar}\n", "rig.yaml:3", "did you mean 'sensors'?"},
    {"UnknownKeyOfALidar", HEAD "  a: {type: lidar,\n      rnage: [1, 2]}\n", "rig.yaml:5", "did you mean 'range'?"},
    {"UnknownKeyFarFromAny", ONE "zzzzzzzz: 1\n", "rig.yaml:5", "known here are rigcal"},
    {"MisspeltType", HEAD "  a: {tpye: lidar}\n", "rig.yaml:4", "did you mean 'type'?"},
    {"CameraKeyOnALidar", HEAD "  a: {type: livox_avia, exposure_us: 5}\n", "rig.yaml:4", "unknown key 'exposure_us'"},
    {"UnknownType", HEAD "  a: {type: livox_avvia}\n", "rig.yaml:4", "use one of livox_avia"},
    {"NoType", HEAD "  a: {ip: 192.168.1.5}\n", "rig.yaml:4", "'type' is missing"},
    {"SensorIsNoMap", HEAD "  a: livox_avia\n", "rig.yaml:4", "sensors.a is 'livox_avia', not a map"},
    {"NoSensors", "rigcal: 1\nbase: a\n", "rig.yaml:1", "'sensors' is missing"},
    {"EmptySensors", "rigcal: 1\nbase: a\nsensors: {}\n", "rig.yaml:3", "is empty"},
    {"NoBase", "rigcal: 1\nsensors:\n  a: {type: lidar}\n", "rig.yaml:1", "'base' is missing"},
    {"BaseThatDoesNotExist", "rigcal: 1\nbase: aviar\nsensors:\n  avia: {type: lidar}\n", "rig.yaml:2",
     "did you mean 'avia'?"},
    {"BaseThatIsACamera", HEAD "  a: {type: camera}\n  b: {type: lidar}\n", "rig.yaml:2", "is a camera"},
    {"DuplicateKey", "rigcal: 1\nbase: a\nbase: b\n", "rig.yaml:3", "key 'base' twice"},
    {"DuplicateSensor", HEAD "  a: {type: lidar}\n  a: {type: lidar}\n", "rig.yaml:5", "key 'a' twice"},
    {"SameIp", HEAD "  a: {type: lidar, ip: 10.0.0.1}\n  b: {type: lidar, ip: 10.0.0.1}\n", "rig.yaml:5", "10.0.0.1"},
    {"SameCode",
     HEAD "  a: {type: livox_avia, broadcast_code: 3JEDHC900100791}\n"
          "  b: {type: livox_avia, broadcast_code: 3JEDHC900100791}\n",
     "rig.yaml:5", "another sensor"},
    {"FolderOfAnother", HEAD "  a: {type: lidar}\n  b: {type: lidar, folder: a}\n", "rig.yaml:5", "another sensor"},
    {"SameTopic", HEAD "  a: {type: lidar, topic: /p}\n  b: {type: lidar, topic: p}\n", "rig.yaml:5", "another sensor"},
    {"SameImuTopic", HEAD "  a: {type: lidar, imu_topic: /i}\n  b: {type: lidar, imu_topic: /i}\n", "rig.yaml:5",
     "sensors.b.imu_topic is /i"},
    {"ImuTopicOfPoints", HEAD "  a: {type: lidar, topic: /p}\n  b: {type: lidar, imu_topic: /p}\n", "rig.yaml:5",
     "another sensor"},
    {"SameDevice", HEAD "  a: {type: lidar}\n  b: {type: camera, device: x}\n  c: {type: camera, device: x}\n",
     "rig.yaml:6", "sensors.c.device is x"},
    {"ShortCode", HEAD "  a: {type: livox_avia, broadcast_code: 3JEDHC90010079}\n", "rig.yaml:4", "15"},
    {"CodeOfANonLivox", HEAD "  a: {type: lidar, broadcast_code: 3JEDHC900100791}\n", "rig.yaml:4", "only Livox"},
    {"IpOutOfRange", HEAD "  a: {type: lidar, ip: 192.168.1.256}\n", "rig.yaml:4", "no address"},
    {"IpWithThreeParts", HEAD "  a: {type: lidar, ip: 192.168.1}\n", "rig.yaml:4", "no address"},
    {"BroadcastIp", HEAD "  a: {type: lidar, ip: 255.255.255.255}\n", "rig.yaml:4", "no address"},
    {"FlagOfWrongKind", HEAD "  a: {type: lidar, rings: 3}\n", "rig.yaml:4",
     "not true or false; write one of these words, without quotes"},
    {"RangeTurnedAround", HEAD "  a: {type: lidar, range: [5, 1]}\n", "rig.yaml:4", "minimum above"},
    {"RangeNotFinite", HEAD "  a: {type: lidar, range: [0, inf]}\n", "rig.yaml:4",
     "not a number; write digits alone, without a unit"},
    {"RangeOfYamlInfinity", HEAD "  a: {type: lidar, range: [0, .inf]}\n", "rig.yaml:4", "not a number"},
    {"FolderThatLeaves", HEAD "  a: {type: lidar, folder: ../b}\n", "rig.yaml:4", "not usable"},
    {"NameThatLeaves", HEAD "  ../a: {type: lidar}\n", "rig.yaml:4", "not usable"},
    {"TextWithNewline", HEAD "  a: {type: lidar, topic: \"x\\ny\"}\n", "rig.yaml:4",
     "control characters; write a short text in one line"},
    {"ExtrinsicsOfAStranger", ONE "initial_extrinsics:\n  b: {translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1]}\n",
     "rig.yaml:6", "does not exist"},
    {"ExtrinsicsOfNothing", ONE "initial_extrinsics:\n", "rig.yaml:5", "give it keys below it, or leave it out"},
    {"QuaternionNotUnit",
     HEAD "  a: {type: lidar}\n  b: {type: lidar}\ninitial_extrinsics:\n"
          "  b: {translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1.0011]}\n",
     "rig.yaml:7", "unit quaternion"},
    {"RotationMissing",
     HEAD "  a: {type: lidar}\n  b: {type: lidar}\ninitial_extrinsics:\n  b: {translation: [0, 0, 0]}\n", "rig.yaml:7",
     "'rotation_xyzw' is missing"},
    {"BaseNotIdentity", ONE "initial_extrinsics:\n  a: {translation: [0, 0, 1e-3], rotation_xyzw: [0, 0, 0, 1]}\n",
     "rig.yaml:6", "identity"},
    {"AxisWithoutDirection", ONE "turntable: {axis: [0, 0, 0]}\n", "rig.yaml:5", "no direction"},
    {"UnknownTableProtocol", ONE "turntable: {driver: serial, port: p, protocol: gerbl}\n", "rig.yaml:5", "protocol"},
    {"SerialWithoutPort", ONE "turntable: {driver: serial}\n", "rig.yaml:5", "'port' is missing"},
    {"LineWithoutChip", ONE "trigger: {line: 3}\n", "rig.yaml:5", "'gpiochip' is missing"},
    {"HostIp", ONE "lidar: {host_ip: here}\n", "rig.yaml:5", "no IPv4 address"},
    {"BoardWithoutSquare", ONE "board: {inner_corners: [3, 4]}\n", "rig.yaml:5", "'square' is missing"},
    {"BoardInMillimetres", ONE "board: {inner_corners: [7, 5], square: 95, size: [850, 610]}\n", "rig.yaml:5",
     "board.square is 95.0 m; give lengths in metres"},
    {"BoardInCentimetres", ONE "board: {inner_corners: [7, 5], square: 1.5, size: [15, 12]}\n", "rig.yaml:5",
     "board.square is 1.5 m; give lengths in metres"},
    {"BoardConvertedTwice", ONE "board: {inner_corners: [7, 5], square: 9.5e-5}\n", "rig.yaml:5",
     "board.square is 9.5e-05 m; give lengths in metres"},
    {"BoardInTwoUnits", ONE "board: {inner_corners: [7, 5], square: 0.095, size: [0.085, 0.061]}\n", "rig.yaml:5",
     "has no room for the inner corners"},
    {"PlateTurned", ONE "board: {inner_corners: [7, 5], square: 0.095, size: [0.61, 0.85]}\n", "rig.yaml:5",
     "columns first"},
    {"MarkersOfAPlainBoard", ONE "board: {inner_corners: [3, 4], square: 1, marker: 0.7}\n", "rig.yaml:5",
     "type: charuco"},
    {"CharucoWithoutMarker", ONE "board: {type: charuco, inner_corners: [3, 4], square: 1, dictionary: DICT_4X4_50}\n",
     "rig.yaml:5", "'marker' is missing"},
    {"UnknownDictionary",
     ONE "board: {type: charuco, inner_corners: [3, 4], square: 1, dictionary: DICT_4X4_51, marker: 0.7}\n",
     "rig.yaml:5", "no dictionary of markers"},
    {"MarkerLargerThanSquare",
     ONE "board: {type: charuco, inner_corners: [3, 4], square: 1, dictionary: DICT_4X4_50, marker: 1}\n", "rig.yaml:5",
     "no smaller than a square"},
    {"TooFewMarkers",
     ONE "board: {type: charuco, inner_corners: [10, 9], square: 1, dictionary: DICT_4X4_50, marker: 0.7}\n",
     "rig.yaml:5", "fewer markers than"},
    {"DistortionTooShort",
     ONE "  c: {type: camera, intrinsics: {model: radtan, width: 9, height: 9, fx: 9, fy: 9, cx: 4, cy: 4,\n"
         "      distortion: [1, 2, 3]}}\n",
     "rig.yaml:6", "list of 4 to 5 numbers; write the numbers in brackets"},
    {"MisspeltPixelFormat", ONE "  c: {type: camera,\n      pixel_format: BayrRG8}\n", "rig.yaml:6",
     "sensors.c.pixel_format is 'BayrRG8', which is no format that can be read; did you mean 'BayerRG8'?"},
    {"PixelFormatInSmallLetters", ONE "  c: {type: camera, pixel_format: bayergr12}\n", "rig.yaml:5",
     "did you mean 'BayerGR12'?"},
    {"PackedMosaic", ONE "  c: {type: camera, pixel_format: BayerGB12Packed}\n", "rig.yaml:5",
     "did you mean 'BayerGB12'?"},
    {"PixelFormatOfRos", ONE "  c: {type: camera, pixel_format: bayer_grbg16}\n", "rig.yaml:5",
     "did you mean 'BayerGR16'?"},
    {"PixelFormatOfVideo4Linux", ONE "  c: {type: camera, pixel_format: RGGB}\n", "rig.yaml:5",
     "did you mean 'BayerRG8'?"},
    {"PixelFormatFarFromAny", ONE "  c: {type: camera, pixel_format: Confidence}\n", "rig.yaml:5",
     "use a name like BayerRG8"},
    {"Alias", "rigcal: &v 1\nbase: *v\n", "rig.yaml:1", "anchor"},
    {"Tag", "rigcal: !!int 1\n", "rig.yaml:1", "tag"},
    {"SecondDocument", ONE "---\nrigcal: 1\n", "rig.yaml:6", "second document"},
    {"BrokenYaml", "rigcal: 1\nbase: [a\nsensors: b\n", "rig.yaml:3", "no valid YAML"},
};

INSTANTIATE_TEST_SUITE_P(All, RigMistake, testing::ValuesIn(mistakes),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(RigFile, ThatIsMissingIsNamed) {
  const Expected<Rig> rig = load_rig(testing::TempDir() + "/no_such_rig.yaml");
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().kind, ErrorKind::input);
  EXPECT_THAT(rig.error().message(), HasSubstr("no such file"));
}

TEST(RigFile, ThatIsAFolderIsNamed) {
  const Expected<Rig> rig = load_rig(testing::TempDir());
  ASSERT_FALSE(rig);
  EXPECT_THAT(rig.error().message(), HasSubstr("is a folder"));
}

}  // namespace
}  // namespace rigcal
