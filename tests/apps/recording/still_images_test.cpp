#include "apps/recording/still_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "apps/exchange/image_files.h"
#include "apps/recording/bag_images.h"
#include "core/io/frame_files.h"
#include "core/io/image_file.h"
#include "tests/support/bag_bytes.h"
#include "tests/support/files.h"
#include "tests/support/noting_reporter.h"
#include "tests/support/ros_bytes.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Image plain(int width, int height, std::uint8_t value) {
  Image image{width, height, 1, 8, {}, {}};
  image.bytes.assign(static_cast<std::size_t>(width * height), value);
  return image;
}

class StillImagesTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = scratch_folder("still_images");
    camera_.name = "left";
    camera_.camera.emplace();
    camera_.camera->pixel_format = "BayerRG8";
    camera_.camera->exposure_us = 10.0;
    CameraIntrinsics intrinsics;
    intrinsics.width = 4;
    intrinsics.height = 3;
    camera_.camera->intrinsics = intrinsics;
  }

  void image(const std::string& name, const Image& image) const {
    const auto written = write_image((folder_ / name).string(), image);
    ASSERT_TRUE(written) << written.error().message();
  }
  StillImages read() { return read_still_images(folder_.string(), camera_, stops_, {reporter_}); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  fs::path folder_;
  Sensor camera_;
  NotingReporter reporter_;
  std::vector<Stop> stops_{{3, 1'000'000, 2'000'000}, {4, 3'000'000, 4'000'000}};
};

// A square in an image that is large enough to have edges.
Image square() {
  Image image = plain(64, 48, 40);
  for (int y = 12; y < 36; ++y) {
    for (int x = 16; x < 48; ++x) image.bytes[static_cast<std::size_t>(y * 64 + x)] = 200;
  }
  return image;
}

TEST_F(StillImagesTest, ThatWereReadAheadAreTakenFromThere) {
  camera_.camera->intrinsics->width = 64;
  camera_.camera->intrinsics->height = 48;
  const std::string folder = "images/left/";
  fs::create_directories(folder_ / folder);
  image(folder + "1500000.png", square());
  image(folder + "3500000.png", square());
  Rig rig;
  rig.sensors = {camera_};
  const auto ahead = std::make_shared<StopImageCache>();
  read_images_ahead(rig, {stops_[0]}, {path("images")}, *ahead, {});  // The second stop is not over.
  EXPECT_TRUE(ahead->has("left", 0, {path(folder + "1500000.png")}));
  EXPECT_FALSE(ahead->has("left", 1, {path(folder + "3500000.png")}));
  read_images_ahead(rig, stops_, {path("images")}, *ahead, {});
  EXPECT_TRUE(ahead->has("left", 1, {path(folder + "3500000.png")}));
  image(folder + "3600000.png", square());  // One more comes late: the stop is read anew.

  const StillImages again = read_still_images(path("images/left"), camera_, stops_, {reporter_}, ahead.get());
  const StillImages plainly = read_still_images(path("images/left"), camera_, stops_, {reporter_});
  ASSERT_EQ(again.images.size(), 2U);
  ASSERT_EQ(plainly.images.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(again.images[k].stop, plainly.images[k].stop);
    EXPECT_EQ(again.images[k].file, plainly.images[k].file);
    EXPECT_TRUE(again.images[k].image.bytes == plainly.images[k].image.bytes);
    EXPECT_EQ(plainly.images[k].features, nullptr);
  }
  EXPECT_EQ(again.images[1].features, nullptr);
  ASSERT_NE(again.images[0].features, nullptr);
  const ImageFeatures found = find_features(plainly.images[0].image, 0);
  EXPECT_TRUE(again.images[0].features->grey.values == found.grey.values);
  ASSERT_FALSE(found.edges->empty());
  EXPECT_EQ(again.images[0].features->edges->size(), found.edges->size());
  EXPECT_FALSE(ahead->has("left", 0, {path(folder + "1500000.png")}));  // It was taken out.
}

// As of a camera that was left at a mosaic which the rig file did not name: the session's names it in the end.
TEST_F(StillImagesTest, ThatWereReadAheadInAnotherFormatAreReadAgain) {
  camera_.camera->intrinsics->width = 64;
  camera_.camera->intrinsics->height = 48;
  fs::create_directories(folder_ / "images/left");
  image("images/left/1500000.png", square());
  Rig rig;
  rig.sensors = {camera_};
  rig.sensors[0].camera->pixel_format.clear();
  const auto ahead = std::make_shared<StopImageCache>();
  read_images_ahead(rig, stops_, {path("images")}, *ahead, {});
  ASSERT_TRUE(ahead->has("left", 0, {path("images/left/1500000.png")}));

  const StillImages again = read_still_images(path("images/left"), camera_, stops_, {reporter_}, ahead.get());
  ASSERT_EQ(again.images.size(), 1U);
  EXPECT_EQ(again.images[0].image.pixel_format, "BayerRG8");
  EXPECT_EQ(again.images[0].features, nullptr) << "of the mosaic, taken for grey";
}

TEST_F(StillImagesTest, BelongToTheStopThatContainsTheirExposure) {
  image("1500000.png", plain(4, 3, 10));
  image("1999000.png", plain(4, 3, 20));  // its exposure ends 4 us after the stop
  image("3000000.png", plain(4, 3, 30));  // and this one's begins before
  image("3005000.png", plain(4, 3, 40));
  const StillImages still = read();
  ASSERT_EQ(still.images.size(), 2U);
  EXPECT_EQ(still.images[0].stop, 0);
  EXPECT_EQ(still.images[0].file, path("1500000.png"));
  EXPECT_EQ(still.images[0].image.bytes[0], 10);
  EXPECT_EQ(still.images[0].image.pixel_format, "BayerRG8");
  EXPECT_EQ(still.images[1].stop, 1);
  EXPECT_EQ(still.images[1].image.bytes[0], 40);
  ASSERT_EQ(reporter_.warnings.size(), 1U);
  EXPECT_THAT(reporter_.warnings[0], HasSubstr("left: 2 of 4 images were taken outside of all stops"));
  EXPECT_THAT(reporter_.warnings[0], HasSubstr("1999000.png"));
}

TEST_F(StillImagesTest, TellHowFarTheyLieFromTheNearestStop) {
  image("9000000.png", plain(4, 3, 10));
  const StillImages still = read();
  EXPECT_THAT(still.images, IsEmpty());
  EXPECT_THAT(still.why_none, HasSubstr("9000000.png (0.005 s after stop 4)"));
  EXPECT_THAT(reporter_.warnings, IsEmpty());
}

TEST_F(StillImagesTest, GuessWhyNoStampLiesInAStop) {
  stops_ = {{0, 1'000'000'000'000, 1'002'000'000'000}, {1, 1'010'000'000'000, 1'012'000'000'000}};
  image("1001000000.png", plain(4, 3, 1));
  image("1011000000.png", plain(4, 3, 1));
  EXPECT_THAT(read().why_none, HasSubstr("2 of 2 images were taken outside of all stops"));
  EXPECT_THAT(read().why_none, HasSubstr("; their stamps look like microseconds: write nanoseconds"));
}

TEST_F(StillImagesTest, SayWhereImagesLieInstead) {
  fs::create_directory(folder_ / "data");
  image("data/1500000.png", plain(4, 3, 1));
  EXPECT_THAT(read().why_none, HasSubstr("holds no images; its folder data holds 1 images: move them up"));
  image("1.5.png", plain(4, 3, 1));
  fs::remove_all(folder_ / "data");
  EXPECT_THAT(read().why_none, HasSubstr("seconds are not read"));
  EXPECT_THAT(reporter_.warnings.back(), HasSubstr("their names are no numbers, the first: 1.5.png; seconds are not"));
  fs::remove(folder_ / "1.5.png");
  std::ofstream(folder_ / "1500000.BMP") << "BM";
  EXPECT_THAT(read().why_none, HasSubstr("files that end in .bmp are not read: make them PNG"));
  EXPECT_THAT(reporter_.warnings.back(), HasSubstr("they are neither .png nor .jpg, the first: 1500000.BMP"));
}

TEST_F(StillImagesTest, BelieveTheStampAndNotTheRemarkOfAStop) {
  image("a.png", plain(4, 3, 10));
  ASSERT_TRUE(write_frames(path("frames.csv"), std::vector<FrameRecord>{{"a.png", 1'500'000, {}, 4.0, {}, 4}}));
  const StillImages still = read();
  ASSERT_EQ(still.images.size(), 1U);
  EXPECT_EQ(still.images[0].stop, 0);
  EXPECT_THAT(reporter_.warnings, ElementsAre(HasSubstr("(4, but taken in stop 3)")));
}

TEST_F(StillImagesTest, WithoutTimesTheNumberOrTheRemarkTellsTheStop) {
  stops_ = {{3, 0, 0}, {7, 0, 0}};
  image("7.png", plain(4, 3, 10));
  image("8.png", plain(4, 3, 10));
  const StillImages by_name = read();
  ASSERT_EQ(by_name.images.size(), 1U);
  EXPECT_EQ(by_name.images[0].stop, 1);
  EXPECT_THAT(reporter_.warnings, ElementsAre(HasSubstr("8.png (the recording has no such stop)")));
  ASSERT_TRUE(write_frames(path("frames.csv"), std::vector<FrameRecord>{{"8.png", 5, {}, {}, {}, 3}}));
  const StillImages by_remark = read();
  ASSERT_EQ(by_remark.images.size(), 1U);
  EXPECT_EQ(by_remark.images[0].stop, 0);
  EXPECT_THAT(reporter_.warnings, testing::Contains(HasSubstr("frames.csv does not list them, the first: 7.png")));
}

TEST_F(StillImagesTest, TellThatTheyAreCountedFromAnotherNumberThanTheStops) {
  stops_ = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  for (const char* name : {"1.png", "2.png", "3.png"}) image(name, plain(4, 3, 10));
  EXPECT_EQ(read().images.size(), 2U);
  EXPECT_THAT(reporter_.warnings,
              ElementsAre(HasSubstr("3.png (the recording has no such stop); images are numbered "
                                    "from 1, stops from 0: if the first image belongs to the first")));
  // One more than there are stops, and numbers that run on: nothing is known.
  for (const char* name : {"0.png", "7.png"}) {
    image(name, plain(4, 3, 10));
    reporter_.warnings.clear();
    (void)read();
    EXPECT_THAT(reporter_.warnings, ElementsAre(testing::Not(HasSubstr("numbered from")))) << name;
  }
}

TEST_F(StillImagesTest, OfOneStopBecomeTheirMean) {
  image("1100000.png", plain(4, 3, 10));
  image("1200000.png", plain(4, 3, 13));
  image("1300000.png", plain(4, 3, 20));
  const StillImages still = read();
  ASSERT_EQ(still.images.size(), 1U);
  EXPECT_EQ(still.images[0].image.bytes, std::vector<std::uint8_t>(12, 14));
  EXPECT_EQ(still.images[0].file, path("1100000.png"));
  EXPECT_THAT(reporter_.warnings, IsEmpty());
}

TEST_F(StillImagesTest, LeaveOutWhatIsDamagedOrOfAnotherSize) {
  image("1100000.png", plain(4, 3, 10));
  image("3100000.png", plain(8, 6, 10));
  std::ofstream(folder_ / "3200000.png") << "no image";
  const StillImages still = read();
  ASSERT_EQ(still.images.size(), 1U);
  EXPECT_THAT(reporter_.warnings,
              ElementsAre(testing::AllOf(HasSubstr("3100000.png"), HasSubstr("8 x 6"), HasSubstr("4 x 3")),
                          testing::AllOf(HasSubstr("3200000.png"), HasSubstr("neither a PNG nor a JPEG"))));
}

TEST_F(StillImagesTest, SayOnceWhyNoneIsLeft) {
  for (int k = 0; k < 6; ++k) std::ofstream(folder_ / (std::to_string(1'100'000 + k) + ".png")) << "no image";
  EXPECT_THAT(read().why_none, HasSubstr("none of its 6 images can be used"));
  EXPECT_THAT(reporter_.warnings, IsEmpty());
  image("3100000.png", plain(4, 3, 10));
  EXPECT_EQ(read().images.size(), 1U);
  EXPECT_THAT(reporter_.warnings, testing::SizeIs(4));
  EXPECT_THAT(reporter_.warnings.back(), HasSubstr("left: 3 more of its images were left out"));
}

TEST_F(StillImagesTest, ADamagedFramesFileAndAnEmptyFolderAreReasons) {
  EXPECT_THAT(read().why_none, HasSubstr("holds no images"));
  std::ofstream(folder_ / "frames.csv") << "nonsense\n";
  EXPECT_THAT(read().why_none, HasSubstr("frames.csv:1"));
}

// 10 us of exposure: the middle of the first lies in the stop, its end does not. A clock an hour off is guessed.
TEST_F(StillImagesTest, OfABagAndOfItsSessionAreThoseWithinTheirStops) {
  camera_.camera->topic = "/cam";
  Rig rig;
  rig.sensors.push_back(camera_);
  const RosBytes pixels(12, 7);
  ImageFiles files(path("images"), rig);
  BagBytes bytes;
  for (const std::int64_t stamp_ns : {1'996'000, 1'994'000}) {
    const RosBytes message = image_message(0, 0, 4, 3, "bayer_rggb8", 4, pixels);
    bytes.add("/cam", image_type, image_md5, stamp_ns, message);
    files.write({0, stamp_ns, RosType::image, *decode_image(RosType::image, message)});
  }
  save_bytes(path("x.bag"), bytes.finish());
  EXPECT_EQ(bag_camera_recordings(rig, stops_, path("x.bag"))[0].read_images({reporter_}).images.size(), 1U);
  EXPECT_THAT(reporter_.warnings, ElementsAre(HasSubstr("1 of 2 images were taken outside")));
  ASSERT_TRUE(files.finish(stops_));
  const auto frames = read_frames(path("images/left/frames.csv"));
  ASSERT_TRUE(frames);
  EXPECT_FALSE(frames->at(0).stop);
  EXPECT_EQ(frames->at(1).stop, 3);

  BagBytes shifted;
  constexpr std::int64_t hour_ns = 3'600'000'000'000;
  for (const std::int64_t stamp_ns : {1'500'000, 3'500'000})
    shifted.add("/cam", image_type, image_md5, stamp_ns + hour_ns, image_message(0, 0, 4, 3, "mono8", 4, pixels));
  save_bytes(path("y.bag"), shifted.finish());
  EXPECT_THAT(bag_camera_recordings(rig, stops_, path("y.bag"))[0].read_images({reporter_}).why_none,
              HasSubstr("with -3600.000 s added to their stamps all would lie in stops"));
}

// As compressed_image_transport writes them: what became of the pixels stands behind "compressed".
TEST_F(StillImagesTest, ACompressedMosaicIsNamedByItsFormat) {
  camera_.camera->pixel_format.clear();
  camera_.camera->topic = "/cam";
  image("grey.png", plain(4, 3, 7));
  Image colours = plain(4, 3, 7);
  colours.channels = 3;
  colours.bytes.assign(36, 7);
  image("colours.png", colours);
  Rig rig;
  rig.sensors.push_back(camera_);
  const auto format_of = [&](const std::string& format, const std::string& name) {
    const std::string png = text_of(path(name));
    BagBytes bytes;
    bytes.add("/cam", compressed_type, compressed_md5, 1'500'000,
              compressed_message(0, 0, format, RosBytes(png.begin(), png.end())));
    save_bytes(path("x.bag"), bytes.finish());
    const StillImages still = bag_camera_recordings(rig, stops_, path("x.bag"))[0].read_images({reporter_});
    EXPECT_EQ(still.images.size(), 1U) << still.why_none;
    ImageFiles files(path("images"), rig);
    RosImage ros;
    ros.encoding = format;
    ros.data = ByteView(reinterpret_cast<const std::uint8_t*>(png.data()), png.size());
    files.write({0, 0, RosType::compressed_image, ros});
    const auto missing = files.missing_formats();
    const std::string told = missing.contains(0) ? missing.at(0) : "";
    const std::string read = still.images.empty() ? "" : still.images[0].image.pixel_format;
    EXPECT_EQ(told, read) << "what import says";
    return read;
  };
  EXPECT_EQ(format_of("bayer_grbg8; png compressed ", "grey.png"), "BayerGR8");
  EXPECT_EQ(format_of("bayer_grbg16; jpeg compressed", "grey.png"), "BayerGR8");
  EXPECT_EQ(format_of("bayer_grbg8; jpeg compressed mono8", "grey.png"), "");
  EXPECT_EQ(format_of("bayer_grbg8; png compressed ", "colours.png"), "");
  EXPECT_EQ(format_of("png", "grey.png"), "");
}

TEST_F(StillImagesTest, ComeOutOfABag) {
  camera_.camera->topic = "/cam";
  BagBytes bytes;
  const auto add = [&](std::int64_t stamp_ns, const std::string& encoding, std::uint8_t value) {
    std::vector<std::uint8_t> data(3 * 5, 99);  // rows have a gap
    for (std::size_t y = 0; y < 3; ++y) std::fill_n(data.begin() + static_cast<std::ptrdiff_t>(5 * y), 4, value);
    bytes.add("/cam", image_type, image_md5, stamp_ns, image_message(0, 0, 4, 3, encoding, 5, data));
  };
  add(500'000, "bayer_bggr8", 1);
  add(1'500'000, "bayer_bggr8", 10);
  add(1'600'000, "bayer_bggr8", 20);
  add(3'500'000, "unheard", 30);
  add(3'600'000, "mono8", 40);
  const std::string file = path("x.bag");
  save_bytes(file, bytes.finish());
  Rig rig;
  rig.sensors.push_back(camera_);
  const auto cameras = bag_camera_recordings(rig, stops_, file);
  ASSERT_EQ(cameras.size(), 1U);
  const StillImages still = cameras[0].read_images({reporter_});
  ASSERT_EQ(still.images.size(), 2U) << still.why_none;
  EXPECT_EQ(still.images[0].stop, 0);
  EXPECT_EQ(still.images[0].image.bytes, std::vector<std::uint8_t>(12, 15));
  EXPECT_EQ(still.images[0].image.pixel_format, "BayerBG8");
  EXPECT_EQ(still.images[1].image.bytes, std::vector<std::uint8_t>(12, 40));
  EXPECT_EQ(still.images[1].image.pixel_format, "BayerRG8") << "the rig file's";
  EXPECT_THAT(reporter_.warnings,
              ElementsAre(HasSubstr("1 of 5 images were taken outside of all stops and are not used, the first at 0.0"),
                          HasSubstr("'unheard' is not known")));
}

TEST_F(StillImagesTest, OfABagAreMissedBySentences) {
  BagBytes bytes;
  bytes.add("/cam", image_type, image_md5, 500'000, image_message(0, 0, 1, 1, "mono8", 1, {1}));
  const std::string file = path("x.bag");
  save_bytes(file, bytes.finish());
  const auto why = [&](const std::string& topic) {
    camera_.camera->topic = topic;
    Rig rig;
    rig.sensors.push_back(camera_);
    return bag_camera_recordings(rig, stops_, file)[0].read_images({reporter_}).why_none;
  };
  EXPECT_THAT(why(""), HasSubstr("no topic for it"));
  EXPECT_THAT(why("/other"), HasSubstr("no images on its topic '/other'"));
  EXPECT_THAT(why("/cam"),
              HasSubstr("all of its 1 images were taken outside of the stops, the first at 0.001 s (0.001 s "
                        "before stop 3)"));
}

}  // namespace
}  // namespace rigcal
