#include "simdata/session/session_writer.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/patch_folder.h"
#include "core/io/pcap_reader.h"
#include "core/io/pcd_file.h"
#include "core/io/session_folder.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::sim {
namespace {

RunOptions short_run() {
  RunOptions options;
  options.turntable.stops = 2;
  options.turntable.dwell_s = 0.2;
  options.turntable.initial_still_s = 0.0;
  options.turntable.final_still_s = 0.0;
  options.turntable.turn_s = 0.3;
  return options;
}

TEST(SessionWriter, WritesASessionThatOpensWithAllItsPacketsAndItsTruth) {
  const auto scene = load_scene("room");
  SilentReporter silent;
  const std::string path = fresh_path("session");
  const auto summary = simulate_session(*scene, nominal_rig(), short_run(), path, {silent});
  ASSERT_TRUE(summary.has_value()) << summary.error().message();
  const auto session = open_session(path);
  ASSERT_TRUE(session.has_value()) << session.error().message();
  ASSERT_FALSE(session->packets.empty());
  auto reader = PcapReader::open(session->packets);
  ASSERT_TRUE(reader.has_value());
  Datagram datagram;
  std::uint64_t count = 0;
  for (;;) {
    const auto more = reader->next(datagram);
    ASSERT_TRUE(more.has_value());
    if (!*more) break;
    ++count;
  }
  EXPECT_FALSE(reader->truncated());
  EXPECT_EQ(summary->datagrams, count);
  // 0.7 s of 2500 + 3 x 1000 point packets and 200 readings a second, and 8 broadcasts; a packet more or less each.
  EXPECT_NEAR(0.7 * 5700.0 + 8.0, static_cast<double>(count), 5.0);
  const auto truth = load_ground_truth(session->ground_truth);
  ASSERT_TRUE(truth.has_value()) << truth.error().message();
  ASSERT_EQ(2U, truth->stops.size());
  EXPECT_EQ("avia", truth->base);
  EXPECT_LT(truth->T_base_sensor[0].second.log().norm(), 1e-12);
  const SE3 nominal = *nominal_rig().sensors[2].initial_T_base_sensor;
  EXPECT_NEAR(0.2, (truth->T_base_sensor[2].second.t - nominal.t).norm(), 1e-9);
  EXPECT_LT(std::abs(truth->clocks.at("avia").drift_ppm), 50.0);
}

TEST(SessionWriter, WritesAPatchFolderWithTheTruthBesideIt) {
  const auto scene = load_scene("room");
  SilentReporter silent;
  LightRigOptions options;
  options.turntable.stops = 3;
  options.shots_per_patch = 500;
  const std::string path = fresh_path("patches");
  const auto summary = simulate_patches(*scene, nominal_rig(), options, path, {silent});
  ASSERT_TRUE(summary.has_value()) << summary.error().message();
  const auto session = open_session(path);
  ASSERT_TRUE(session.has_value()) << session.error().message();
  const auto folder = list_patch_folder(session->patches, session->rig);
  ASSERT_TRUE(folder.has_value()) << folder.error().message();
  EXPECT_EQ(3U, folder->stops.size());
  std::uint64_t points = 0;
  for (const auto& sensor : folder->patches)
    for (const PatchFile& file : sensor) points += read_pcd(file.path)->points.size();
  EXPECT_EQ(summary->points, points);
  EXPECT_TRUE(load_ground_truth(session->ground_truth).has_value());
}

TEST(SessionWriter, NeverTouchesAnExistingFolderAndLeavesNothingBehindWhenStopped) {
  const auto scene = load_scene("room");
  SilentReporter silent;
  const std::string path = fresh_path("existing");
  std::filesystem::create_directory(path);
  EXPECT_FALSE(simulate_session(*scene, nominal_rig(), short_run(), path, {silent}).has_value());
  EXPECT_TRUE(std::filesystem::is_empty(path));
  std::filesystem::remove_all(path);

  std::stop_source stop;
  stop.request_stop();
  const auto stopped = simulate_session(*scene, nominal_rig(), short_run(), path, {silent, stop.get_token()});
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(ErrorKind::cancelled, stopped.error().kind);
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace rigcal::sim
