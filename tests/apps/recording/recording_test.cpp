#include "apps/recording/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <tuple>

#include "apps/exchange/patch_export.h"
#include "apps/exchange/session_import.h"
#include "apps/inspection/inspection.h"
#include "core/base/random.h"
#include "core/io/image_file.h"
#include "core/io/pcapng_writer.h"
#include "core/io/tum_file.h"
#include "tests/support/bag_bytes.h"
#include "tests/support/files.h"
#include "tests/support/json.h"
#include "tests/support/noting_reporter.h"
#include "tests/support/ros_bytes.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::StartsWith;

// A LiDAR's clouds at stops 3 and 4, a camera's images at stops 3, 5 and 9.
class RecordingOfPatches : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "patches" / "top");
    fs::create_directories(folder_ / "patches" / "image" / "eye");
    write_clouds(
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 "
        "0\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n");
    const Image image{2, 2, 1, 8, {}, {1, 2, 3, 4}};
    for (const char* stop : {"3", "5", "9"}) {
      ASSERT_TRUE(write_image((folder_ / "patches" / "image" / "eye" / (std::string(stop) + ".png")).string(), image));
    }
    std::ofstream(folder_ / "rig.yaml")
        << "rigcal: 1\nname: small\nbase: top\nsensors:\n  top: {type: lidar}\n  eye: {type: camera, driver: images}\n";
  }

  /// The same for stops 3 and 4, as a whole PCD file.
  void write_clouds(const std::string& pcd) const {
    for (const char* stop : {"3", "4"})
      std::ofstream(folder_ / "patches" / "top" / (std::string(stop) + ".pcd")) << pcd;
  }
  void write_trajectory(double metres_a_stop) const {
    std::vector<TumPose> poses;
    for (const int stop : {3, 4, 5, 7})
      poses.push_back(
          {stop * std::int64_t{1'000'000'000}, SE3{Matrix3d::Identity(), {metres_a_stop * stop, 0.0, 0.0}}});
    ASSERT_TRUE(write_tum((folder_ / "patches" / "trajectory.tum").string(), poses));
  }
  [[nodiscard]] Expected<Recording> read() const {
    SilentReporter silent;
    return read_recording({(folder_ / "patches").string(), (folder_ / "rig.yaml").string(), {}}, CellOptions{},
                          RunContext{silent});
  }
  static std::vector<int> stops(const Recording& recording) {
    std::vector<int> out;
    for (const Stop& stop : recording.lidar.stops) out.push_back(stop.index);
    return out;
  }

  fs::path folder_ = scratch_folder("patches");
};

TEST_F(RecordingOfPatches, HasStopsOfImagesAloneWhereTheirPosesAreGiven) {
  write_trajectory(0.1);
  const auto recording = read();
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_THAT(stops(*recording), ElementsAre(3, 4, 5)) << "9 has no pose, 7 no image";
  ASSERT_EQ(recording->lidar.trajectory.size(), 3U);
  EXPECT_NEAR(recording->lidar.trajectory[2]->t.x(), 0.5, 1e-9);
  ASSERT_EQ(recording->lidar.patches.size(), 2U);
  EXPECT_EQ(recording->lidar.patches[1].stop, 1);
}

TEST_F(RecordingOfPatches, HasNoStopOfImagesAloneWithoutAPose) {
  auto recording = read();
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_THAT(stops(*recording), ElementsAre(3, 4));
  // The gyro's rotations do not say where the rig was.
  write_trajectory(0.0);
  recording = read();
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_THAT(stops(*recording), ElementsAre(3, 4));
}

TEST_F(RecordingOfPatches, TellsWhatIsLeftOutOfItsClouds) {
  std::ofstream(folder_ / "rig.yaml")
      << "rigcal: 1\nname: small\nbase: top\nsensors:\n  top: {type: lidar, range: [0.5, 3.0]}\n";
  write_clouds(
      "VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 4\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA ascii\n1 1 1 0.5\n4 5 6 0.9\n0.1 0 0 0.2\n9 9 9 0.1\n");
  NotingReporter notes;
  const std::string rig = (folder_ / "rig.yaml").string();
  const auto recording = read_recording({(folder_ / "patches").string(), rig, {}}, CellOptions{}, {notes});
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_EQ(recording->points, 2U);
  EXPECT_THAT(notes.warnings,
              testing::IsSupersetOf({testing::HasSubstr("top: 6 of its 8 points lie outside of its range"),
                                     testing::HasSubstr("top: its intensities are at most 0.90")}));
}

TEST_F(RecordingOfPatches, LeavesOutWhatTheTagsOfALivoxCallNoise) {
  for (const auto& [type, points] : {std::pair{"livox_avia", 4U}, {"lidar", 6U}}) {
    std::ofstream(folder_ / "rig.yaml") << "rigcal: 1\nname: small\nbase: top\nsensors:\n  top: {type: " << type
                                        << "}\n";
    write_clouds(
        "VERSION 0.7\nFIELDS x y z tag\nSIZE 4 4 4 1\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\n"
        "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n0.5 0 0 16\n4 5 6 0\n4 5 7 1\n");
    const auto recording = read();
    ASSERT_TRUE(recording) << recording.error().message();
    EXPECT_EQ(recording->points, points) << type;
  }
}

TEST_F(RecordingOfPatches, NamesTheTrajectoryThatHasNoPoseOfAStop) {
  const std::vector<TumPose> poses{{3'000'000'000, SE3{}}, {5'000'000'000, SE3{Matrix3d::Identity(), {1.0, 0.0, 0.0}}}};
  ASSERT_TRUE(write_tum((folder_ / "patches" / "trajectory.tum").string(), poses));
  const auto recording = read();
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().where, (folder_ / "patches" / "trajectory.tum").string());
}

// As `export` and `import` wrote it where no turn is known.
TEST_F(RecordingOfPatches, TakesOnePoseThatIsZeroForNone) {
  const std::vector<TumPose> one{{3'000'000'000, SE3{}}};
  ASSERT_TRUE(write_tum((folder_ / "patches" / "trajectory.tum").string(), one));
  const auto recording = read();
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_THAT(stops(*recording), ElementsAre(3, 4));
  EXPECT_THAT(recording->lidar.trajectory, testing::IsEmpty());
}

TEST_F(RecordingOfPatches, SaysThatTheImagesThatWereGivenLieOneFolderTooDeep) {
  SilentReporter silent;
  const std::string given = (folder_ / "patches/image/eye").string();
  const auto recording = read_recording({(folder_ / "patches").string(), (folder_ / "rig.yaml").string(), given},
                                        CellOptions{}, RunContext{silent});
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_THAT(recording->cameras.at(0).read_images({silent}).why_none,
              testing::HasSubstr(given + " has no folder that is named after it"));
}

TEST_F(RecordingOfPatches, IsImportedWithItsImagesAndToldWhereNoneCanBeRead) {
  NotingReporter notes;
  const std::string patches = (folder_ / "patches").string();
  const std::string rig = (folder_ / "rig.yaml").string();
  auto imported = import_session({patches, rig, {}}, (folder_ / "with").string(), {notes});
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->images, 3U);
  EXPECT_THAT(notes.warnings, testing::IsEmpty());
  const fs::path image = folder_ / "patches/image/eye";
  for (const char* stop : {"3", "5", "9"})
    fs::rename(image / (std::string(stop) + ".png"), image / (std::string(stop) + ".bmp"));
  imported = import_session({patches, rig, {}}, (folder_ / "without").string(), {notes});
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->images, 0U);
  EXPECT_THAT(notes.warnings, testing::Contains(testing::HasSubstr("eye: no image of it is written: its folder")));
}

TEST_F(RecordingOfPatches, TellsOnceASensorWhatIsWrongWithItsClouds) {
  for (const char* stop : {"3", "4", "5"}) {
    std::ofstream(folder_ / "patches" / "top" / (std::string(stop) + ".pcd"))
        << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
           "VIEWPOINT 0 0 1 1 0 0 0\nPOINTS 2\nDATA ascii\nnan 1 1\n"
        << (stop[0] == '3' ? "1 2 3\n" : "4000 5000 6000\n");
  }
  NotingReporter notes;
  const auto recording =
      read_recording({(folder_ / "patches").string(), (folder_ / "rig.yaml").string(), {}}, CellOptions{}, {notes});
  ASSERT_TRUE(recording) << recording.error().message();
  const std::string first = (folder_ / "patches/top/4.pcd").string();
  EXPECT_THAT(notes.warnings,
              ElementsAre("top: 3 points with NaN or infinite coordinates left out",
                          testing::HasSubstr("top: its clouds have a VIEWPOINT, which is not applied"),
                          "top: 2 of its 3 clouds have no usable point, the first: " + first,
                          testing::HasSubstr("top: 2 of its 3 points in the stops lie farther than 60 m")));
}

// One that looks at the sky has empty clouds, or a few points far away, in metres.
TEST_F(RecordingOfPatches, AsksForMetresWhereNoPointOfAnyCloudCanBeUsed) {
  const auto warning_where = [&](const std::string& third, const std::string& others) {
    for (const char* stop : {"3", "4", "5"}) {
      const std::string& points = stop[0] == '3' ? third : others;
      std::ofstream(folder_ / "patches" / "top" / (std::string(stop) + ".pcd"))
          << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nWIDTH "
          << (points.empty() ? 0 : 1) << "\nPOINTS " << (points.empty() ? 0 : 1) << "\nDATA ascii\n"
          << points;
    }
    NotingReporter notes;
    // Where nothing is left this is an error, after the warning.
    std::ignore =
        read_recording({(folder_ / "patches").string(), (folder_ / "rig.yaml").string(), {}}, CellOptions{}, {notes});
    const auto of_clouds = [](const std::string& warning) { return warning.find("usable") != std::string::npos; };
    const auto at = std::find_if(notes.warnings.begin(), notes.warnings.end(), of_clouds);
    return at == notes.warnings.end() ? std::string() : *at;
  };
  const std::string all = "top: 3 of its 3 clouds have no usable point, the first: ";
  EXPECT_THAT(warning_where("4000 5000 6000\n", "4000 5000 6000\n"),
              AllOf(StartsWith(all), EndsWith("3.pcd; are they in metres?")));
  EXPECT_THAT(warning_where("4000 5000 6000\n", ""),
              AllOf(StartsWith(all), EndsWith("3.pcd; 2 have none at all; are they in metres?")));
  EXPECT_THAT(warning_where("", ""), AllOf(StartsWith(all), EndsWith("3.pcd; 3 have none at all")));
  EXPECT_THAT(warning_where("1 2 3\n", ""),
              AllOf(StartsWith("top: 2 of its 3"), EndsWith("4.pcd; 2 have none at all")));
}

// What its range leaves out was told of already.
TEST_F(RecordingOfPatches, TellsOfPointsInRangeThatLieFartherThanCellsReach) {
  write_clouds(
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA ascii\n1 2 3\n80 0 0\n90 0 0\n1000 0 0\n");
  for (const auto& [range, told] :
       {std::pair{"[1, 200]", "top: 4 of its 6 points in the stops lie farther than 60 m"}, {"[1, 50]", ""}}) {
    std::ofstream(folder_ / "rig.yaml") << "rigcal: 1\nname: small\nbase: top\nsensors:\n  top: {type: lidar, range: "
                                        << range << "}\n";
    NotingReporter notes;
    const auto recording =
        read_recording({(folder_ / "patches").string(), (folder_ / "rig.yaml").string(), {}}, CellOptions{}, {notes});
    ASSERT_TRUE(recording) << recording.error().message();
    const auto of_far = [](const std::string& warning) { return warning.find("farther than") != std::string::npos; };
    const auto far = std::find_if(notes.warnings.begin(), notes.warnings.end(), of_far);
    EXPECT_THAT(far == notes.warnings.end() ? "" : *far, testing::StartsWith(told));
    EXPECT_EQ(far == notes.warnings.end(), std::string(told).empty());
  }
}

TEST_F(RecordingOfPatches, IsExportedWithItsTrajectory) {
  write_trajectory(0.1);
  std::ofstream(folder_ / "rig.yaml")
      << "rigcal: 1\nname: small\nbase: top\nsensors:\n  top: {type: lidar, range: [0.5, 5.0]}\n";
  const auto source = open_stream((folder_ / "patches").string(), (folder_ / "rig.yaml").string());
  ASSERT_TRUE(source) << source.error().message();
  SilentReporter silent;
  for (const auto& [layout, name] : {std::pair{PatchLayout::pcd, "top_4.pcd"}, {PatchLayout::las, "top_4.las"}}) {
    const fs::path out = folder_ / "clouds" / name;
    const auto done = export_patches(*source, layout, out.string(), {silent});
    ASSERT_TRUE(done) << done.error().message();
    EXPECT_EQ(done->files, 2U);
    EXPECT_EQ(done->reading.stops.size(), 2U);
    EXPECT_EQ(done->reading.points.in_stops, 2U) << "one of each two points is out of range";
    EXPECT_TRUE(fs::exists(out / name));
  }
  EXPECT_EQ(read_pcd((folder_ / "clouds/top_4.pcd/top_4.pcd").string())->points.front().z, 3.0F);
  const auto done = export_patches(*source, PatchLayout::patches, (folder_ / "again").string(), {silent});
  ASSERT_TRUE(done) << done.error().message();
  // Its own rig.yaml is with it.
  const auto again = open_stream((folder_ / "again").string(), {});
  ASSERT_TRUE(again) << again.error().message();
  const auto listed = list_patch_folder((folder_ / "again").string(), again->rig);
  ASSERT_TRUE(listed) << listed.error().message();
  ASSERT_TRUE(listed->trajectory);
  EXPECT_NEAR(listed->trajectory->at(4).t.x(), 0.4, 1e-9);
  EXPECT_THAT(open_stream((folder_ / "patches").string(), {}).error().message(), testing::HasSubstr("add --rig"));
}

TEST_F(RecordingOfPatches, IsExportedWithItsRingsAndToldWhatIsLost) {
  std::ofstream(folder_ / "rig.yaml")
      << "rigcal: 1\nname: small\nbase: top\nsensors:\n  top: {type: lidar, rings: true}\n";
  write_clouds(
      "VERSION 0.7\nFIELDS x y z intensity ring\nSIZE 4 4 4 4 2\nTYPE F F F F U\nCOUNT 1 1 1 1 1\nWIDTH 2\n"
      "HEIGHT 1\nVIEWPOINT 0 0 1 1 0 0 0\nPOINTS 2\nDATA ascii\n1 2 3 0.5 7\n4 5 6 0.9 300\n");
  const auto source = open_stream((folder_ / "patches").string(), (folder_ / "rig.yaml").string());
  ASSERT_TRUE(source) << source.error().message();
  for (const PatchLayout layout : {PatchLayout::patches, PatchLayout::pcd}) {
    const fs::path out = folder_ / (layout == PatchLayout::pcd ? "clouds" : "again");
    NotingReporter notes;
    const auto done = export_patches(*source, layout, out.string(), {notes});
    ASSERT_TRUE(done) << done.error().message();
    EXPECT_THAT(notes.warnings, ElementsAre(testing::HasSubstr("top: its intensities are at most 0.90"),
                                            testing::HasSubstr("top: its clouds have a VIEWPOINT")));
    const auto cloud = read_pcd((out / (layout == PatchLayout::pcd ? "top_4.pcd" : "top/4.pcd")).string());
    ASSERT_TRUE(cloud) << cloud.error().message();
    EXPECT_TRUE(cloud->summary.has_ring);
    ASSERT_EQ(cloud->points.size(), 2U);
    EXPECT_EQ(cloud->points[0].shot, 7);
    EXPECT_EQ(cloud->points[1].shot, 300);
  }
  EXPECT_EQ(text_of(folder_ / "again/rig.yaml"), text_of(folder_ / "rig.yaml"));
}

// A link within that leads back, and the session is made within what it is made of.
TEST_F(RecordingOfPatches, IsImportedOnceWhateverItsLinksLeadTo) {
  const fs::path image = folder_ / "patches/image";
  fs::create_directory_symlink(".", image / "loop");
  fs::create_directory_symlink("eye", image / "other");
  SilentReporter silent;
  const std::string out = (image / "session").string();
  const auto imported =
      import_session({(folder_ / "patches").string(), (folder_ / "rig.yaml").string(), {}}, out, {silent});
  ASSERT_TRUE(imported) << imported.error().message();
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(image / "session/patches/image")) {
    if (!entry.is_directory()) files.push_back(entry.path().lexically_relative(image / "session/patches/image"));
  }
  EXPECT_THAT(files, testing::UnorderedElementsAre("eye/3.png", "eye/5.png", "eye/9.png", "other/3.png", "other/5.png",
                                                   "other/9.png"));
}

TEST_F(RecordingOfPatches, InspectCountsImagesWhateverTheCaseOfTheirNames) {
  fs::rename(folder_ / "patches/image/eye/5.png", folder_ / "patches/image/eye/5.PNG");
  std::ofstream(folder_ / "patches/image/eye/6.JPG") << "only counted";
  SilentReporter silent;
  const auto inspection = inspect_patches((folder_ / "patches").string(), (folder_ / "rig.yaml").string(), {silent});
  ASSERT_TRUE(inspection) << inspection.error().message();
  EXPECT_EQ(inspection->at("images").at("eye").at("files"), 4);
}

TEST_F(RecordingOfPatches, IsExportedWithItsImages) {
  const auto source = open_stream((folder_ / "patches").string(), (folder_ / "rig.yaml").string());
  ASSERT_TRUE(source) << source.error().message();
  NotingReporter notes;
  const auto done = export_patches(*source, PatchLayout::patches, (folder_ / "again").string(), {notes});
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_EQ(done->images, 3U) << "those of stops without a cloud, too";
  for (const char* file : {"3.png", "5.png", "9.png"}) {
    const auto image = read_image((folder_ / "again/image/eye" / file).string());
    ASSERT_TRUE(image) << image.error().message();
    EXPECT_EQ(image->bytes, (std::vector<std::uint8_t>{1, 2, 3, 4}));
  }
  EXPECT_THAT(notes.warnings, testing::IsEmpty());

  fs::remove_all(folder_ / "patches/image");
  const auto without = export_patches(*source, PatchLayout::patches, (folder_ / "without").string(), {notes});
  ASSERT_TRUE(without) << without.error().message();
  EXPECT_EQ(without->images, 0U);
  EXPECT_THAT(notes.warnings, ElementsAre(testing::HasSubstr("eye: no image of it is written")));
}

// Images of two stops, in a folder as a user has it.
TEST(RecordingOfImages, OfARigWithoutLidarsIsReadInspectedAndImported) {
  const fs::path folder = scratch_folder("images_alone");
  std::ofstream(folder / "rig.yaml")
      << "rigcal: 1\nname: pair\nbase: left\nsensors:\n  left: {type: camera}\n  right: {type: camera}\n";
  const Image image{2, 2, 1, 8, {}, {1, 2, 3, 4}};
  for (const char* camera : {"left", "right"}) {
    fs::create_directories(folder / "poses/image" / camera);
    for (const char* stop : {"0", "1"})
      ASSERT_TRUE(write_image((folder / "poses/image" / camera / (std::string(stop) + ".png")).string(), image));
  }
  SilentReporter silent;
  const std::string poses = (folder / "poses").string();
  const std::string rig = (folder / "rig.yaml").string();
  for (const std::string& known_rig : {rig, std::string()}) {
    const auto inspection = inspect_patches(poses, known_rig, {silent});
    ASSERT_TRUE(inspection) << inspection.error().message();
    EXPECT_EQ(inspection->at("images").at("right").at("files"), 2);
    EXPECT_THAT(inspection_text(*inspection), testing::HasSubstr("right"));
  }
  const std::string session = (folder / "session").string();
  const auto imported = import_session({poses, rig, {}}, session, {silent});
  ASSERT_TRUE(imported) << imported.error().message();
  const auto recording = read_recording({session, {}, {}}, CellOptions{}, {silent});
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_EQ(recording->lidar.stops.size(), 2U);
  ASSERT_EQ(recording->cameras.size(), 2U);
  EXPECT_EQ(recording->cameras[1].read_images({silent}).images.size(), 2U);
}

// As a simulation of such a rig left it before it was refused.
TEST(SessionOfPackets, OfARigWithoutLidarsIsInspectedButNotRead) {
  const fs::path folder = scratch_folder("cameras_and_packets");
  std::ofstream(folder / "rig.yaml") << "rigcal: 1\nname: one\nbase: eye\nsensors:\n  eye: {type: camera}\n";
  fs::create_directories(folder / "images/eye");
  ASSERT_TRUE(write_image((folder / "images/eye/5.png").string(), {2, 2, 1, 8, {}, {1, 2, 3, 4}}));
  auto packets = PcapngWriter::create((folder / "lidar.pcapng").string());
  ASSERT_TRUE(packets && packets->close());
  SilentReporter silent;
  const auto source = open_stream(folder.string(), {});
  ASSERT_TRUE(source) << source.error().message();
  const auto inspection = inspect_recording(*source, {silent});
  ASSERT_TRUE(inspection) << inspection.error().message();
  EXPECT_EQ(inspection->at("images").at("eye").at("files"), 1);
  EXPECT_THAT(json_text(inspection->at("warnings")), testing::HasSubstr("not fit for calibrate: the rig has no LiDAR"));
  const auto recording = read_recording({folder.string(), {}, {}}, CellOptions{}, {silent});
  ASSERT_FALSE(recording);
  EXPECT_THAT(recording.error().message(), testing::HasSubstr("rig.yaml: the rig has no LiDAR"));
  const auto exported = export_patches(*source, PatchLayout::patches, (folder / "out").string(), {silent});
  ASSERT_FALSE(exported);
  EXPECT_EQ(exported.error().where, recording.error().where);
}

// Three seconds of rest, five million points a second: of a file so many are held until it is sure that it is a rest.
TEST(RecordingOfABag, ThatIsDenseLosesNoPoints) {
  const fs::path folder = scratch_folder("dense");
  std::ofstream(folder / "rig.yaml") << "rigcal: 1\nname: one\nbase: top\nsensors:\n"
                                        "  top: {type: lidar, topic: /points, imu_topic: /imu}\n";
  constexpr std::uint32_t points = 500'000;
  RosBytes data;
  ByteWriter out(data);
  for (std::uint32_t i = 0; i < points; ++i) {
    for (const float value : {2.0F, 1.0F, 1.0F}) out.write(value);
  }
  BagBytes bytes;
  bytes.compression = "lz4";
  Random random(3);
  for (std::int64_t ms = 0; ms < 3000; ms += 5) {
    const std::int64_t now_ns = 1'000'000'000 + 1'000'000 * ms;
    const Vector3d gyro(1e-3 * random.normal(), 1e-3 * random.normal(), 1e-3 * random.normal());
    bytes.add("/imu", imu_type, imu_md5, now_ns, imu_message(0, now_ns, gyro, Vector3d(0.0, 0.0, 9.8)));
    if (ms % 100 != 0) continue;
    bytes.add(
        "/points", cloud_type, cloud_md5, now_ns,
        cloud_message(0, now_ns, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}}, {1, points, 12, 12 * points, false}, data));
    bytes.flush();
  }
  const auto bag = bytes.finish();
  save_bytes(folder / "dense.bag", bag);
  const auto source = open_stream((folder / "dense.bag").string(), (folder / "rig.yaml").string());
  ASSERT_TRUE(source) << source.error().message();
  SilentReporter silent;
  NoPoints sink;
  const auto reading = read_stops(*source, StopOptions{}, sink, {silent});
  ASSERT_TRUE(reading) << reading.error().message();
  EXPECT_EQ(reading->stops.size(), 1U);
  EXPECT_EQ(reading->points.dropped[static_cast<std::size_t>(DropReason::overflow)], 0U);
  EXPECT_GE(reading->points.in_stops, 20U * points);
}

// Three seconds of rest, clouds with one point that is very far, intensities up to 1.
TEST(ExportOfABag, SaysWhatAFormatCannotHold) {
  const fs::path folder = scratch_folder("far_points");
  std::ofstream(folder / "rig.yaml") << "rigcal: 1\nname: one\nbase: top\nsensors:\n"
                                        "  top: {type: lidar, rings: true, topic: /points, imu_topic: /imu}\n";
  BagBytes bytes;
  Random random(3);
  for (std::int64_t ms = 0; ms < 3000; ms += 5) {
    const std::int64_t now_ns = 1'000'000'000 + 1'000'000 * ms;
    const Vector3d gyro(1e-3 * random.normal(), 1e-3 * random.normal(), 1e-3 * random.normal());
    bytes.add("/imu", imu_type, imu_md5, now_ns, imu_message(0, now_ns, gyro, Vector3d(0.0, 0.0, 9.8)));
    if (ms % 100 != 0) continue;
    RosBytes data;
    ByteWriter out(data);
    for (const float x : {2.0F, 3e5F}) {
      for (const float value : {x, 1.0F, 1.0F, 0.4F}) out.write(value);
    }
    bytes.add("/points", cloud_type, cloud_md5, now_ns,
              cloud_message(0, now_ns, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}},
                            {1, 2, 16, 32, false}, data));
  }
  const auto bag = bytes.finish();
  save_bytes(folder / "far.bag", bag);
  const auto source = open_stream((folder / "far.bag").string(), (folder / "rig.yaml").string());
  ASSERT_TRUE(source) << source.error().message();
  NotingReporter notes;
  const auto done = export_patches(*source, PatchLayout::las, (folder / "las").string(), {notes});
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_GT(done->files, 0U);
  EXPECT_THAT(notes.warnings,
              testing::IsSupersetOf({testing::HasSubstr("points lie farther than a .las file can say (214 km)"),
                                     testing::HasSubstr("/points: its intensities are at most 0.40")}));

  notes.warnings.clear();
  ASSERT_TRUE(export_patches(*source, PatchLayout::patches, (folder / "patches").string(), {notes}));
  ASSERT_TRUE(import_session({(folder / "far.bag").string(), (folder / "rig.yaml").string(), {}},
                             (folder / "session").string(), {notes}));
  EXPECT_THAT(notes.warnings,
              testing::Contains(StartsWith("top: its clouds are written without the numbers")).Times(2));
  for (const char* made : {"patches", "session"}) {
    const auto rig = load_rig((folder / made / "rig.yaml").string());
    ASSERT_TRUE(rig) << rig.error().message();
    EXPECT_FALSE(rig->base_sensor().lidar->rings) << made;
    EXPECT_FALSE(fs::exists(folder / made / "trajectory.tum")) << "one stop has no turn";
  }
  EXPECT_FALSE(fs::exists(folder / "session/patches/rig.yaml"));
}

}  // namespace
}  // namespace rigcal
