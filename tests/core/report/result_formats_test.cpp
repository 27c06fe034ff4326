// Each exported file is read by the library that its users have, and must give the transforms back.
#include "core/report/result_formats.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml.h>
#include <urdf_parser/urdf_parser.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <sstream>
#include <stdexcept>

#include "core/base/random.h"
#include "core/base/text.h"
#include "core/report/result_texts.h"
#include "core/report/rpy.h"
#include "core/report/summary_text.h"
#include "tests/support/json.h"
#include "tests/support/make_result.h"
#include "tests/support/schema_check.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Through quaternions and angles some roundings are lost; a matrix must come back to the bit.
constexpr double rounding = 4e-15;

Matrix3d rotation_from_rpy(const Vector3d& rpy) {
  return exp_so3({0.0, 0.0, rpy[2]}) * exp_so3({0.0, rpy[1], 0.0}) * exp_so3({rpy[0], 0.0, 0.0});
}

Eigen::Matrix4d matrix_of(const YAML::Node& rows) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) matrix(i, j) = rows[i][j].as<double>();
  }
  return matrix;
}

/// avia (the base), mid40_left, mid40_right (failed), two cameras.
class ResultFormats : public testing::Test {
 protected:
  ResultFormats() {
    SensorResult left_camera = result.sensors[1];
    left_camera.name = "camera-left";
    left_camera.status = Status::good;
    Vector6d xi;
    xi << 1.2, -1.2, 1.2, 0.2, 1.0 / 7.0, -0.1;
    left_camera.T_base_sensor = SE3::exp(xi);
    SensorResult right_camera = left_camera;
    right_camera.name = "camera-right";
    // Looks straight down: pitch is -90 degrees to rounding, where roll and yaw cannot be told apart.
    right_camera.T_base_sensor = SE3{rotation_from_rpy({0.7, -pi / 2.0, -0.4}), {0.3, 1e-7, 2.0 / 3.0}};
    result.sensors.push_back(left_camera);
    result.sensors.push_back(right_camera);
    rig.sensors.resize(5);
    const char* names[] = {"avia", "mid40_left", "mid40_right", "camera-left", "camera-right"};
    for (std::size_t i = 0; i < 5; ++i) rig.sensors[i].name = names[i];
    for (std::size_t i = 0; i < 3; ++i) rig.sensors[i].lidar.emplace();
    for (std::size_t i = 3; i < 5; ++i)
      rig.sensors[i].camera.emplace().topic = "/" + rig.sensors[i].name + "/image_raw";
    rig.sensors[3].camera->intrinsics = {DistortionModel::radtan,       1280, 1024, 863.1, 863.2, 639.5, 511.25,
                                         {-0.1, 0.09, 1e-4, -2e-4, 0.0}};
    rig.sensors[4].camera->intrinsics = {DistortionModel::equidistant, 1920, 1208, 900.0, 901.0, 960.0, 604.0,
                                         {0.1, 0.01, 1e-3, 1e-4}};
  }

  [[nodiscard]] ExportedResult write(ResultFormat format, bool with_rig = true) const {
    const Expected<ExportedResult> out = export_result(result, with_rig ? &rig : nullptr, format);
    EXPECT_TRUE(out) << out.error().message();
    return out ? *out : ExportedResult{};
  }
  [[nodiscard]] const SE3& truth(const std::string& name) const {
    for (const SensorResult& sensor : result.sensors) {
      if (sensor.name == name) return *sensor.T_base_sensor;
    }
    throw std::out_of_range(name);
  }
  void expect_pose(const std::string& name, const Vector3d& t, const Matrix3d& R) const {
    EXPECT_EQ(t, truth(name).t) << name;
    EXPECT_LT((R - truth(name).R).cwiseAbs().maxCoeff(), rounding) << name;
  }

  CalibrationResult result = make_result();
  Rig rig;
};

TEST(Rpy, GivesTheRotationBackAlsoWhereRollAndYawCannotBeToldApart) {
  Random random(5);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double off = std::pow(10.0, random.uniform(-17.0, 0.0)) * (random.below(2) == 0 ? 1.0 : -1.0);
    const double pitch = i % 2 == 0 ? random.uniform(-pi / 2.0, pi / 2.0) : (i % 4 == 1 ? 0.5 : -0.5) * pi + off;
    const Matrix3d R = rotation_from_rpy({random.uniform(-pi, pi), pitch, random.uniform(-pi, pi)});
    const Vector3d rpy = rpy_from_rotation(R);
    EXPECT_LE(std::abs(rpy[1]), pi / 2.0 + 1e-15);
    worst = std::max(worst, (rotation_from_rpy(rpy) - R).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, rounding);
  Matrix3d down;  // Exactly at the pole, nothing but zeros to tell yaw from.
  down << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  EXPECT_LT((rotation_from_rpy(rpy_from_rotation(down)) - down).cwiseAbs().maxCoeff(), rounding);
}

TEST_F(ResultFormats, Ros2LaunchPublishesEveryTransform) {
  const ExportedResult file = write(ResultFormat::ros2_tf);
  TiXmlDocument xml;
  ASSERT_NE(xml.Parse(file.text.c_str()), nullptr) << xml.ErrorDesc();
  std::map<std::string, int> seen;
  for (const TiXmlElement* node = xml.RootElement()->FirstChildElement("node"); node != nullptr;
       node = node->NextSiblingElement("node")) {
    EXPECT_STREQ(node->Attribute("pkg"), "tf2_ros");
    EXPECT_STREQ(node->Attribute("exec"), "static_transform_publisher");
    EXPECT_EQ(std::string(node->Attribute("name")).find_first_of("-."), std::string::npos);
    std::istringstream words(node->Attribute("args"));
    std::map<std::string, std::string> options;
    for (std::string key, value; words >> key >> value;) options[key] = value;
    ASSERT_EQ(options.size(), 9U);
    EXPECT_EQ(options["--frame-id"], "avia");
    const auto number = [&options](const char* key) { return std::stod(options.at(key)); };
    const std::string name = options["--child-frame-id"];
    expect_pose(name, {number("--x"), number("--y"), number("--z")},
                rotation_from_xyzw({number("--qx"), number("--qy"), number("--qz"), number("--qw")}));
    ++seen[name];
  }
  EXPECT_EQ(seen, (std::map<std::string, int>{{"mid40_left", 1}, {"camera-left", 1}, {"camera-right", 1}}));
}

TEST_F(ResultFormats, Ros2LaunchHasNoTwoNodesOfOneName) {
  SensorResult& other = result.sensors.emplace_back(result.sensors[1]);
  other.name = "mid40-left";
  TiXmlDocument xml;
  ASSERT_NE(xml.Parse(write(ResultFormat::ros2_tf).text.c_str()), nullptr) << xml.ErrorDesc();
  std::set<std::string> names;
  for (const TiXmlElement* node = xml.RootElement()->FirstChildElement("node"); node != nullptr;
       node = node->NextSiblingElement("node")) {
    EXPECT_TRUE(names.insert(node->Attribute("name")).second) << node->Attribute("name");
  }
  EXPECT_EQ(names.count("tf_avia_mid40_left"), 1U);
}

TEST_F(ResultFormats, UrdfIsReadByItsOwnLibrary) {
  const auto model = urdf::parseURDF(write(ResultFormat::urdf).text);
  ASSERT_TRUE(model);
  EXPECT_EQ(model->getRoot()->name, "avia");
  ASSERT_EQ(model->joints_.size(), 3U);
  for (const auto& [name, joint] : model->joints_) {
    EXPECT_EQ(joint->type, urdf::Joint::FIXED);
    EXPECT_EQ(joint->parent_link_name, "avia");
    const auto& origin = joint->parent_to_joint_origin_transform;
    expect_pose(joint->child_link_name, {origin.position.x, origin.position.y, origin.position.z},
                rotation_from_xyzw({origin.rotation.x, origin.rotation.y, origin.rotation.z, origin.rotation.w}));
  }
}

TEST_F(ResultFormats, AutowareHasSixNumbersASensorBelowTheBase) {
  const YAML::Node file = YAML::Load(write(ResultFormat::autoware).text);
  ASSERT_EQ(file.size(), 1U);
  ASSERT_EQ(file["avia"].size(), 3U);
  for (const auto& entry : file["avia"]) {
    const auto number = [&entry](const char* key) { return entry.second[key].as<double>(); };
    expect_pose(entry.first.as<std::string>(), {number("x"), number("y"), number("z")},
                rotation_from_rpy({number("roll"), number("pitch"), number("yaw")}));
  }
}

TEST_F(ResultFormats, KalibrChainsTheCameras) {
  const ExportedResult out = write(ResultFormat::kalibr);
  EXPECT_THAT(out.sensors, ElementsAre("camera-left", "camera-right"));
  const YAML::Node file = YAML::Load(out.text);
  ASSERT_EQ(file.size(), 2U) << "Kalibr counts the entries, so there may be nothing but cameras";
  EXPECT_EQ(file["cam0"]["camera_model"].as<std::string>(), "pinhole");
  EXPECT_EQ(file["cam0"]["intrinsics"].as<std::vector<double>>(), (std::vector<double>{863.1, 863.2, 639.5, 511.25}));
  EXPECT_EQ(file["cam0"]["distortion_model"].as<std::string>(), "radtan");
  EXPECT_EQ(file["cam0"]["distortion_coeffs"].as<std::vector<double>>(),
            (std::vector<double>{-0.1, 0.09, 1e-4, -2e-4}));
  EXPECT_EQ(file["cam1"]["distortion_model"].as<std::string>(), "equidistant");
  EXPECT_EQ(file["cam1"]["resolution"].as<std::vector<int>>(), (std::vector<int>{1920, 1208}));
  EXPECT_EQ(file["cam1"]["rostopic"].as<std::string>(), "/camera-right/image_raw");
  EXPECT_FALSE(file["cam0"]["T_cn_cnm1"]);
  EXPECT_EQ(matrix_of(file["cam0"]["T_cam_base"]), truth("camera-left").inverse().matrix());
  const Eigen::Matrix4d chained = matrix_of(file["cam1"]["T_cn_cnm1"]) * matrix_of(file["cam0"]["T_cam_base"]);
  EXPECT_LT((chained - truth("camera-right").inverse().matrix()).cwiseAbs().maxCoeff(), rounding);
}

TEST_F(ResultFormats, KalibrSaysWhatItCannotHold) {
  rig.sensors[3].camera->intrinsics->distortion[4] = 0.02;
  rig.sensors[3].camera->topic.clear();
  rig.sensors[4].camera->intrinsics.reset();
  const ExportedResult out = write(ResultFormat::kalibr);
  EXPECT_THAT(out.warnings, testing::Contains(HasSubstr("camera-left is known without a topic")));
  EXPECT_THAT(out.warnings, testing::Contains(HasSubstr("no k3")));
  EXPECT_THAT(out.warnings, testing::Contains(HasSubstr("camera-right is known without intrinsics")));
}

TEST_F(ResultFormats, KalibrsLayoutHoldsLidarsWhereNoCameraIsKnown) {
  const YAML::Node file = YAML::Load(write(ResultFormat::kalibr, false).text);
  ASSERT_EQ(file.size(), 4U);
  EXPECT_EQ(file["lidar0"]["name"].as<std::string>(), "avia");
  EXPECT_EQ(file["lidar1"]["name"].as<std::string>(), "mid40_left");
  EXPECT_EQ(matrix_of(file["lidar1"]["T_cn_cnm1"]), truth("mid40_left").inverse().matrix());
}

TEST_F(ResultFormats, OpenCvReadsEveryMatrixToTheBit) {
  const cv::FileStorage file(write(ResultFormat::opencv).text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
  ASSERT_TRUE(file.isOpened());
  EXPECT_EQ(static_cast<std::string>(file["base"]), "avia");
  ASSERT_EQ(file["sensors"].size(), 4U);
  for (const cv::FileNode& sensor : file["sensors"]) {
    const auto name = static_cast<std::string>(sensor["name"]);
    cv::Mat T;
    sensor["T_base_sensor"] >> T;
    ASSERT_EQ(T.type(), CV_64F);
    ASSERT_EQ(T.size(), cv::Size(4, 4));
    const Eigen::Matrix4d expected = truth(name).matrix();
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) EXPECT_EQ(T.at<double>(i, j), expected(i, j)) << name;
    }
    EXPECT_EQ(sensor["camera_matrix"].empty(), name.find("camera") != 0) << name;
  }
  const cv::FileNode camera = file["sensors"][2];
  cv::Mat K;
  cv::Mat distortion;
  camera["camera_matrix"] >> K;
  camera["distortion_coefficients"] >> distortion;
  EXPECT_EQ(K.at<double>(0, 2), 639.5);
  EXPECT_EQ(K.at<double>(1, 1), 863.2);
  EXPECT_EQ(distortion.total(), 5U);
  EXPECT_EQ(distortion.at<double>(0, 3), -2e-4);
  EXPECT_EQ(static_cast<int>(camera["image_height"]), 1024);
}

TEST_F(ResultFormats, ColmapHasTheCamerasInTheFirstOnesFrame) {
  const auto file = parse_json(write(ResultFormat::colmap).text);
  ASSERT_EQ(file.size(), 1U);
  const auto& cameras = file[0]["cameras"];
  ASSERT_EQ(cameras.size(), 2U);
  EXPECT_EQ(cameras[0]["image_prefix"], "camera-left/");
  EXPECT_EQ(cameras[0]["ref_sensor"], true);
  EXPECT_FALSE(cameras[0].contains("cam_from_rig_rotation"));
  const auto q = cameras[1]["cam_from_rig_rotation"].get<std::vector<double>>();
  const auto t = cameras[1]["cam_from_rig_translation"].get<std::vector<double>>();
  const SE3 T_right_left{rotation_from_xyzw({q[1], q[2], q[3], q[0]}), {t[0], t[1], t[2]}};
  const SE3 expected = truth("camera-right").inverse() * truth("camera-left");
  EXPECT_EQ(T_right_left.t, expected.t);
  EXPECT_LT((T_right_left.R - expected.R).cwiseAbs().maxCoeff(), rounding);
  // Half a pixel more: COLMAP counts from the corner of the first pixel.
  EXPECT_EQ(cameras[0]["camera_model_name"], "OPENCV");
  EXPECT_EQ(cameras[0]["camera_params"], (std::vector<double>{863.1, 863.2, 640.0, 511.75, -0.1, 0.09, 1e-4, -2e-4}));
  EXPECT_EQ(cameras[1]["camera_model_name"], "OPENCV_FISHEYE");
}

TEST_F(ResultFormats, ColmapTakesAThirdRadialTermInItsFullModel) {
  rig.sensors[3].camera->intrinsics->distortion[4] = 0.02;
  const auto camera = parse_json(write(ResultFormat::colmap).text)[0]["cameras"][0];
  EXPECT_EQ(camera["camera_model_name"], "FULL_OPENCV");
  ASSERT_EQ(camera["camera_params"].size(), 12U);
  EXPECT_EQ(camera["camera_params"][8], 0.02);
}

TEST_F(ResultFormats, MlccHasALineALidarBesideTheBase) {
  result.sensors.erase(result.sensors.begin() + 2);  // the failed one
  const ExportedResult out = write(ResultFormat::mlcc);
  EXPECT_THAT(out.sensors, ElementsAre("mid40_left"));
  std::istringstream text(out.text);
  std::vector<double> v;
  for (double value = 0.0; text >> value;) v.push_back(value);
  ASSERT_EQ(v.size(), 7U);
  expect_pose("mid40_left", {v[0], v[1], v[2]}, rotation_from_xyzw({v[4], v[5], v[6], v[3]}));
  // mlcc itself reads poses until the file is at its end, and takes what follows a last line end for one more.
  EXPECT_NE(out.text.back(), '\n');
}

TEST_F(ResultFormats, OfCamerasHoldNoLidarWhereAllCamerasFailed) {
  for (std::size_t i = 3; i < 5; ++i) result.sensors[i].T_base_sensor.reset();
  for (const ResultFormat format : {ResultFormat::kalibr, ResultFormat::colmap}) {
    const Expected<ExportedResult> out = export_result(result, &rig, format);
    ASSERT_FALSE(out);
    EXPECT_THAT(out.error().message(), HasSubstr("none of its cameras has a transform"));
  }
  EXPECT_TRUE(export_result(result, &rig, ResultFormat::json));
}

TEST_F(ResultFormats, MlccIsRefusedWhereALineWouldBeMissing) {
  const Expected<ExportedResult> out = export_result(result, &rig, ResultFormat::mlcc);
  ASSERT_FALSE(out);
  EXPECT_THAT(out.error().message(), HasSubstr("mid40_right is failed (" + result.sensors[2].reasons.front()));
  EXPECT_THAT(out.error().mend, testing::Not(HasSubstr("--rig")));
  EXPECT_THAT(export_result(result, nullptr, ResultFormat::mlcc).error().mend, HasSubstr("add --rig RIG"));
  // A camera has no line anyway.
  rig.sensors[2].lidar.reset();
  rig.sensors[2].camera.emplace();
  EXPECT_THAT(write(ResultFormat::mlcc).sensors, ElementsAre("mid40_left"));
}

TEST_F(ResultFormats, FastLivoHasEachLidarInTheBaseAndInEachCamera) {
  const ExportedResult out = write(ResultFormat::fast_livo);
  EXPECT_THAT(out.sensors, ElementsAre("avia", "mid40_left", "camera-left", "camera-right"));
  const YAML::Node yaml = YAML::Load(out.text);
  EXPECT_EQ(yaml.size(), 2U);
  const auto transform = [](const YAML::Node& block, const char* rotation, const char* translation) {
    const auto R = block[rotation].as<std::vector<double>>();
    const auto t = block[translation].as<std::vector<double>>();
    return SE3{Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()), Vector3d(t.data())};
  };
  for (const char* lidar : {"avia", "mid40_left"}) {
    EXPECT_EQ(transform(yaml[lidar], "extrinsic_R", "extrinsic_T").matrix(), truth(lidar).matrix());
    for (const char* camera : {"camera-left", "camera-right"}) {
      const Vector3d p_lidar(3.0, 1.0, -2.0);
      const Vector3d p_camera = transform(yaml[lidar][camera], "Rcl", "Pcl") * p_lidar;
      EXPECT_LT((truth(camera) * p_camera - truth(lidar) * p_lidar).norm(), 1e-14) << lidar << camera;
    }
  }
  const ExportedResult blind = write(ResultFormat::fast_livo, false);
  EXPECT_THAT(blind.text, HasSubstr("all stand as LiDARs: export with --rig RIG"));
  EXPECT_EQ(YAML::Load(blind.text).size(), 4U);
}

TEST_F(ResultFormats, JsonHoldsAllOfTheResult) {
  const auto json = parse_json(write(ResultFormat::json).text);
  EXPECT_TRUE(fits_schema("extrinsics.json", json));
  EXPECT_EQ(json["sensors"]["mid40_right"]["status"], "failed");
  EXPECT_THAT(json["sensors"]["mid40_right"]["reasons"][0].get<std::string>(), HasSubstr("no stop"));
  EXPECT_EQ(json["sensors"]["camera-left"]["intrinsics"]["cy"], 511.25);
  const auto& matrix = json["sensors"]["mid40_left"]["matrix"];
  const auto& covariance = json["sensors"]["mid40_left"]["covariance"];
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) EXPECT_EQ(matrix[i][j], truth("mid40_left").matrix()(i, j));
  }
  for (int i = 0; i < 6; ++i) EXPECT_EQ(covariance[i][i], result.sensors[1].covariance(i, i));
}

TEST_F(ResultFormats, JsonDoesNotMakeACovarianceUp) {
  result.sensors[1].covariance.setZero();
  const auto json = parse_json(write(ResultFormat::json).text);
  EXPECT_FALSE(json["sensors"]["mid40_left"].contains("stddev"));
  EXPECT_TRUE(json["sensors"]["avia"].contains("stddev")) << "the base is where it is by definition";
}

TEST_F(ResultFormats, JsonCallsGoodNothingThatNobodyJudged) {
  ExtrinsicsFile file;
  file.base = "avia";
  file.names = {"mid40_left"};
  file.T_base_sensor = {{"mid40_left", truth("mid40_left")}};
  const Expected<CalibrationResult> guess = result_from(file);
  ASSERT_TRUE(guess);
  auto json = parse_json(export_result(*guess, nullptr, ResultFormat::json)->text);
  EXPECT_TRUE(fits_schema("extrinsics.json", json));
  EXPECT_FALSE(json.contains("status"));
  EXPECT_FALSE(json["sensors"]["mid40_left"].contains("status"));
  json["method"] = "targetless";
  EXPECT_FALSE(fits_schema("extrinsics.json", json)) << "what calibrate finds is judged";
}

TEST_F(ResultFormats, SayWhichWayTheyGoWhereTheyCanHaveAComment) {
  const std::string point = worked_point_text("mid40_left", false, "avia", truth("mid40_left"));
  const Vector3d p = truth("mid40_left") * Vector3d::UnitX();
  EXPECT_THAT(point, HasSubstr("is [" + fixed_text(p.x(), 3) + ", "));
  for (const ResultFormat format : {ResultFormat::ros2_tf, ResultFormat::urdf, ResultFormat::autoware,
                                    ResultFormat::opencv, ResultFormat::fast_livo}) {
    EXPECT_THAT(write(format).text, HasSubstr("With T_base_sensor, p_base = R p_sensor + t: " + point));
  }
  EXPECT_THAT(write(ResultFormat::kalibr).text, HasSubstr("1 m to the right of camera-left, [1, 0, 0], is ["));
}

TEST_F(ResultFormats, NameEveryFailedAndWeakSensor) {
  for (const std::string& name : result_format_names()) {
    if (name == "mlcc") continue;  // refused
    const ExportedResult out = write(*result_format(name));
    EXPECT_THAT(out.warnings, ElementsAre(HasSubstr("mid40_left is weak"), HasSubstr("mid40_right is failed"))) << name;
    EXPECT_THAT(out.sensors, testing::Not(testing::Contains("mid40_right"))) << name;
  }
  EXPECT_FALSE(result_format("las"));
}

TEST_F(ResultFormats, AResultOfTheBaseAloneIsAFileThatReads) {
  result.sensors.resize(1);
  EXPECT_TRUE(urdf::parseURDF(write(ResultFormat::urdf).text));
  EXPECT_TRUE(YAML::Load(write(ResultFormat::autoware).text)["avia"].IsMap());
  EXPECT_EQ(parse_json(write(ResultFormat::colmap).text)[0]["cameras"].size(), 1U);
  const Expected<ExportedResult> lines = export_result(result, &rig, ResultFormat::mlcc);
  ASSERT_FALSE(lines) << "of lines without the base none is left: " << lines->text;
  EXPECT_THAT(lines.error().message(), HasSubstr("no LiDAR beside its base"));
}

TEST_F(ResultFormats, AreMadeFromTheFileThatCalibrateWrites) {
  const Expected<ExtrinsicsFile> file = parse_extrinsics(extrinsics_yaml(result), "extrinsics.yaml");
  ASSERT_TRUE(file) << file.error().message();
  const Expected<CalibrationResult> read = result_from(*file);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->status, Status::failed);
  EXPECT_EQ(read->method, "targetless");
  ASSERT_EQ(read->sensors.size(), result.sensors.size());
  for (std::size_t i = 0; i < read->sensors.size(); ++i) {
    EXPECT_EQ(read->sensors[i].name, result.sensors[i].name);
    EXPECT_EQ(read->sensors[i].status, result.sensors[i].status);
    EXPECT_EQ(read->sensors[i].reasons, result.sensors[i].reasons);
    EXPECT_EQ(read->sensors[i].covariance, result.sensors[i].covariance);
    ASSERT_EQ(read->sensors[i].T_base_sensor.has_value(), result.sensors[i].T_base_sensor.has_value());
    if (!read->sensors[i].T_base_sensor) continue;
    EXPECT_EQ(read->sensors[i].T_base_sensor->t, result.sensors[i].T_base_sensor->t);
  }
  // A rig file lists the sensors around its base only.
  ExtrinsicsFile around;
  around.base = "avia";
  around.names = {"mid40_left"};
  around.T_base_sensor = {{"mid40_left", SE3{}}};
  EXPECT_EQ(result_from(around)->sensors.front().name, "avia");
  around.base = "a b\"";
  EXPECT_FALSE(result_from(around));
}

}  // namespace
}  // namespace rigcal
