#include "core/io/extrinsics_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/ground_truth.h"
#include "tests/core/io/dump_bytes.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const char* const full_example = R"(
rigcal: 1
base: avia
method: targetless
status: failed
convention: "p_base = R p_sensor + t"
sensors:
  avia: {status: good, reasons: [], translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1]}
  mid100_left:
    status: weak
    reasons: ["no wall across its view: the shift along y is not held"]
    translation: [0.1, -0.2, 0.3]
    rotation_xyzw: [0, 0, 0.70710678, 0.70710678]
    matrix: [[0, -1, 0, 0.1], [1, 0, 0, -0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]]
    stddev: {translation_m: [1e-3, 1e-3, 1e-3], rotation_deg: [1e-3, 1e-3, 1e-3]}
  mid100_right:
    status: failed
    reasons: ["never seen"]
)";

std::string error_of(const std::string& text) {
  const Expected<ExtrinsicsFile> file = parse_extrinsics(text, "e.yaml");
  return file ? std::string("no error") : file.error().message();
}

TEST(ExtrinsicsFile, ReadsAResult) {
  const Expected<ExtrinsicsFile> file = parse_extrinsics(full_example, "e.yaml");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->base, "avia");
  ASSERT_EQ(file->T_base_sensor.size(), 2U);
  // The quaternion has eight digits.
  EXPECT_THAT(file->T_base_sensor.at("mid100_left"), SE3Near(pose_deg(0, 0, 90, 0.1, -0.2, 0.3), 1e-5, 1e-9));
  EXPECT_EQ(file->status.at("mid100_left"), "weak");
  EXPECT_EQ(file->status.at("mid100_right"), "failed");
  EXPECT_FALSE(file->has_stops);
}

TEST(ExtrinsicsFile, IsThatOfAResultFolder) {
  const std::filesystem::path folder = scratch_folder("extrinsics_file");
  const Expected<ExtrinsicsFile> none = load_extrinsics(folder.string());
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message(), AllOf(HasSubstr("is no result: it holds no extrinsics.yaml"), HasSubstr("give")));
  std::ofstream(folder / "ground_truth.yaml") << "";
  EXPECT_THAT(load_extrinsics(folder.string()).error().mend, HasSubstr("ground_truth.yaml"));
  std::ofstream(folder / "extrinsics.yaml") << full_example;
  const Expected<ExtrinsicsFile> file = load_extrinsics(folder.string());
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->base, "avia");
}

TEST(ExtrinsicsFile, CanHaveAnotherBase) {
  ExtrinsicsFile file;
  file.base = "a";
  file.T_base_sensor = {{"b", pose_deg(0, 0, 90, 1, 2, 3)}, {"c", pose_deg(10, 20, 30, -1, 0, 0.5)}};
  const SE3 T_b_c = file.T_base_sensor.at("b").inverse() * file.T_base_sensor.at("c");
  const SE3 T_b_a = file.T_base_sensor.at("b").inverse();
  ASSERT_TRUE(change_base(file, "a"));
  EXPECT_EQ(file.T_base_sensor.size(), 2U);
  ASSERT_TRUE(change_base(file, "b"));
  EXPECT_EQ(file.base, "b");
  EXPECT_EQ(file.T_base_sensor.at("b").matrix(), SE3{}.matrix());
  EXPECT_THAT(file.T_base_sensor.at("a"), SE3Near(T_b_a, 1e-9, 1e-9));
  EXPECT_THAT(file.T_base_sensor.at("c"), SE3Near(T_b_c, 1e-9, 1e-9));
  const Expected<void> unknown = change_base(file, "d");
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message(), HasSubstr("its base is b, and it does not say where d, the rig's base, is"));
}

TEST(ExtrinsicsFile, ReadsTheRoughExtrinsicsOfARigFile) {
  const std::string rig =
      "rigcal: 1\nbase: a\nsensors:\n  a: {type: lidar}\n  b: {type: lidar}\n  c: {type: lidar}\n"
      "initial_extrinsics:\n  b: {translation: [1, 2, 3], rotation_xyzw: [0, 0, 0, 1]}\n";
  const Expected<ExtrinsicsFile> file = parse_extrinsics(rig, "rig.yaml");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->T_base_sensor.size(), 2U);  // the base and b
  EXPECT_EQ(file->T_base_sensor.at("b").t, Vector3d(1, 2, 3));
  EXPECT_THAT(error_of("rigcal: 1\nbase: a\nsensors:\n  a: {type: lidar}\n"), HasSubstr("without initial_extrinsics"));
  // Still checked as a rig file.
  EXPECT_THAT(error_of("rigcal: 1\nbase: b\nsensors:\n  a: {type: lidar}\n"), HasSubstr("e.yaml:2"));
}

TEST(ExtrinsicsFile, NamesTheLineOfAMistake) {
  const std::string head = "rigcal: 1\nbase: a\nsensors:\n";
  EXPECT_THAT(error_of("rigcal: 3\nbase: a\n"), HasSubstr("e.yaml:1"));
  EXPECT_THAT(error_of("rigcal: 1\nsensors: {}\n"), HasSubstr("'base' is missing"));
  EXPECT_THAT(error_of("rigcal: 1\nbase: a\n"), HasSubstr("'sensors' is missing"));
  EXPECT_THAT(error_of(head + "  b: {status: good}\n"), HasSubstr("e.yaml:4: sensors.b: the key 'translation'"));
  EXPECT_THAT(error_of(head + "  b: {status: fine}\n"), HasSubstr("use one of good weak failed"));
  EXPECT_THAT(error_of(head + "  b: {translation: [1, 2], rotation_xyzw: [0, 0, 0, 1]}\n"), HasSubstr("3 numbers"));
  EXPECT_THAT(error_of(head + "  b: {translation: [1, 2, nan], rotation_xyzw: [0, 0, 0, 1]}\n"),
              HasSubstr("not a number"));
  EXPECT_THAT(error_of(head + "  b: {translation: [1, 2, 3], rotation_xyzw: [0, 0, 1, 1]}\n"),
              HasSubstr("unit quaternion"));
  EXPECT_THAT(error_of(head + "  a: {translation: [1, 2, 3], rotation_xyzw: [0, 0, 0, 1]}\n"),
              HasSubstr("not the identity"));
  EXPECT_THAT(error_of(head + "  b: {status: failed}\n"), HasSubstr("no transform"));
  EXPECT_THAT(load_extrinsics(fresh_path("none.yaml")).error().message(), HasSubstr("no such file"));
}

TEST(ExtrinsicsFile, RefusesAnotherConvention) {
  const std::string sensors = "base: a\nsensors:\n  b: {translation: [1, 2, 3], rotation_xyzw: [0, 0, 0, 1]}\n";
  EXPECT_EQ(error_of("rigcal: 1\nconvention: \"p_base = R p_sensor + t\"\n" + sensors), "no error");
  EXPECT_EQ(error_of("rigcal: 1\nconvention: p_base=R p_sensor+t\n" + sensors), "no error");
  EXPECT_THAT(error_of("rigcal: 1\nconvention: \"p_sensor = R p_base + t\"\n" + sensors),
              HasSubstr("e.yaml:2: convention is another than 'p_base = R p_sensor + t'; convert the transforms"));
  EXPECT_THAT(error_of("rigcal: 1\nconvention: [1]\n" + sensors), HasSubstr("e.yaml:2: convention is a list"));
  EXPECT_THAT(parse_ground_truth("rigcal: 1\nconvention: theirs\n" + sensors, "g.yaml").error().message(),
              HasSubstr("g.yaml:2: convention"));
}

// A quarter turn about z and a shift, and one line more.
std::string with(const std::string& line) {
  return "rigcal: 1\nbase: a\nsensors:\n  b:\n    translation: [1, 2, 3]\n    rotation_xyzw: [0, 0, 0.7071068, "
         "0.7071068]\n    " +
         line + "\n";
}

TEST(ExtrinsicsFile, RefusesWhatContradictsItself) {
  EXPECT_EQ(error_of(with("matrix: [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3.000004], [0, 0, 0, 1]]")), "no error");
  EXPECT_EQ(error_of(with("matrix_inverse: [[0, 1, 0, -2], [-1, 0, 0, 1], [0, 0, 1, -3], [0, 0, 0, 1]]")), "no error");
  EXPECT_EQ(error_of(with("example: {p_sensor: [1, 0, 0], p_base: [1, 3, 3]}")), "no error");
  for (const char* wrong : {"matrix: [[0, 1, 0, 1], [-1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]",
                            "matrix: [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3.0001], [0, 0, 0, 1]]",
                            "matrix: [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 2]]",
                            "matrix_inverse: [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]",
                            "example: {p_sensor: [1, 0, 0], p_base: [1, 1, 3]}"}) {
    EXPECT_THAT(error_of(with(wrong)),
                AllOf(HasSubstr("e.yaml:7: sensors.b."), HasSubstr("contradicts translation and rotation_xyzw")))
        << wrong;
  }
  EXPECT_THAT(error_of(with("matrix: [[0, -1, 0, 1]]")), HasSubstr("e.yaml:7: sensors.b.matrix is no list of four"));
  EXPECT_THAT(error_of(with("matrix: [[0, -1, 0], [1, 0, 0], [0, 0, 1], [0, 0, 0]]")),
              HasSubstr("sensors.b.matrix.row 1 is a list of 3, not a list of 4 numbers"));
}

TEST(ExtrinsicsFile, RefusesACovarianceThatIsNone) {
  const std::string rest = ", [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], ";
  const auto message = [&](const std::string& first, const std::string& last) {
    return error_of(with("covariance: [[" + first + "]" + rest + "[" + last + "]]"));
  };
  EXPECT_EQ(message("1, 0, 0, 0, 0, 0.5", "0.5, 0, 0, 0, 0, 1"), "no error");
  EXPECT_THAT(message("1, 0, 0, 0, 0, 0", "0, 0, 0, 0, 0, -1"), HasSubstr("e.yaml:7: sensors.b.covariance has a var"));
  EXPECT_THAT(message("1, 0, 0, 0, 0, 0.5", "0, 0, 0, 0, 0, 1"), HasSubstr("is not symmetric"));
}

TEST(ExtrinsicsFile, ReadsWhatIsKnownWorst) {
  const Expected<ExtrinsicsFile> file = parse_extrinsics(
      with("weak_directions:\n"
           "      - {of: place, axis: [0, 0.6, 0.8], bound_m: 0.25, open: false, frozen: true, missing: \"a floor\"}\n"
           "      - {of: turn, axis: [1, 0, 0], bound_deg: 45, open: true, frozen: false, missing: \"a wall\"}"),
      "e.yaml");
  ASSERT_TRUE(file) << file.error().message();
  const std::vector<ListedDirection>& directions = file->weak_directions.at("b");
  ASSERT_EQ(directions.size(), 2U);
  EXPECT_FALSE(directions[0].is_turn);
  EXPECT_EQ(directions[0].axis, Vector3d(0, 0.6, 0.8));
  EXPECT_EQ(directions[0].bound, 0.25);
  EXPECT_TRUE(directions[0].is_frozen);
  EXPECT_EQ(directions[0].missing, "a floor");
  EXPECT_TRUE(directions[1].is_turn);
  EXPECT_DOUBLE_EQ(directions[1].bound, pi / 4.0);
  EXPECT_TRUE(directions[1].is_open);
  EXPECT_THAT(error_of(with("weak_directions: {of: place}")), HasSubstr("weak_directions is not a list"));
  EXPECT_THAT(error_of(with("weak_directions: [{of: place, axis: [0, 0, 1], bound_deg: 3}]")),
              HasSubstr("e.yaml:7: sensors.b.weak_directions[0]: the key 'bound_m' is missing"));
}

GroundTruth full_truth() {
  GroundTruth truth;
  truth.base = "b";
  truth.T_base_sensor = {{"b", SE3{}}, {"a", pose_deg(10, 20, 30, 1.0 / 3.0, 2, 3)}};
  truth.stops = {{{0, 1'700'000'000'000'000'001, 1'700'000'002'000'000'003}, SE3{}},
                 {{1, 1'700'000'003'000'000'000, 1'700'000'005'000'000'000}, pose_deg(0, 0, 18, 0.1, 0.2, 0)}};
  truth.table_axis = TableAxis{Vector3d(0.1, 0.2, 0.3), Vector3d::UnitZ()};
  truth.noise["a"]["range_m"] = 0.02;
  truth.biases["a"]["range_m"] = -1.0 / 3.0;
  truth.clocks["a"] = {-5'000'000'000'001, 12.5};
  return truth;
}

TEST(GroundTruth, ReadsBackWhatWasWritten) {
  const GroundTruth truth = full_truth();
  const std::string path = fresh_path("ground_truth.yaml");
  ASSERT_TRUE(write_ground_truth(path, truth));
  const Expected<GroundTruth> again = load_ground_truth(path);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->base, "b");
  ASSERT_EQ(again->T_base_sensor.size(), 2U);
  EXPECT_EQ(again->T_base_sensor[0].first, "b");  // the order of the file, not of the alphabet
  // Translations to the bit; rotations go through a quaternion.
  EXPECT_THAT(again->T_base_sensor[1].second, SE3Near(truth.T_base_sensor[1].second, 1e-12, 0.0));
  ASSERT_EQ(again->stops.size(), 2U);
  EXPECT_EQ(again->stops[0].stop.start_ns, truth.stops[0].stop.start_ns);
  EXPECT_EQ(again->stops[0].stop.end_ns, truth.stops[0].stop.end_ns);
  EXPECT_THAT(again->stops[1].T_G_base, SE3Near(truth.stops[1].T_G_base, 1e-12, 0.0));
  EXPECT_EQ(again->table_axis->point, truth.table_axis->point);
  EXPECT_EQ(again->noise, truth.noise);
  EXPECT_EQ(again->biases, truth.biases);
  EXPECT_EQ(again->clocks.at("a").offset_ns, truth.clocks.at("a").offset_ns);
  EXPECT_EQ(again->clocks.at("a").drift_ppm, 12.5);
}

TEST(GroundTruth, IsReadAsExtrinsicsToo) {
  const std::string path = fresh_path("truth_as_extrinsics.yaml");
  ASSERT_TRUE(write_ground_truth(path, full_truth()));
  const Expected<ExtrinsicsFile> file = load_extrinsics(path);
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->T_base_sensor.size(), 2U);
  EXPECT_TRUE(file->has_stops);
}

TEST(GroundTruth, NamesTheLineOfAMistake) {
  const std::string head =
      "rigcal: 1\nbase: a\nsensors:\n  a: {translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1]}\nstops:\n";
  const auto message = [](const std::string& text) { return parse_ground_truth(text, "g.yaml").error().message(); };
  EXPECT_THAT(message(head + "  - {stop: 0, start_ns: 5, end_ns: 4, T_G_base: {translation: [0, 0, 0], rotation_xyzw: "
                             "[0, 0, 0, 1]}}\n"),
              HasSubstr("g.yaml:6: stops[0].end_ns lies before"));
  EXPECT_THAT(message(head + "  - {stop: 0, start_ns: 5, end_ns: 6}\n"), HasSubstr("'T_G_base' is missing"));
  EXPECT_THAT(message(head + "  a: 1\n"), HasSubstr("not a list"));
  const std::string stop =
      "  - {stop: 3, start_ns: 5, end_ns: 6, T_G_base: {translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1]}}\n";
  EXPECT_THAT(message(head + stop + stop), HasSubstr("g.yaml:7: stops[1].stop is 3, as that of a stop before"));
}

}  // namespace
}  // namespace rigcal
