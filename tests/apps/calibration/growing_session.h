#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "apps/capture/live_stops.h"
#include "apps/capture/packet_recorder.h"
#include "apps/recording/stop_reader.h"
#include "core/io/session_folder.h"

namespace rigcal {

/// The folder of a session that is about to be recorded, with the rig of a simulated one.
inline void begin_growing(const std::filesystem::path& given, const std::filesystem::path& session) {
  std::filesystem::create_directories(session);
  std::filesystem::copy_file(given / "rig.yaml", session / "rig.yaml");
  std::filesystem::copy_file(given / "session.json", session / "session.json");
}

/// It as LiveStops takes it.
inline StreamSource growing_session(const std::filesystem::path& session) {
  StreamSource source;
  source.path = session.string();
  source.file = session_packets_path(session.string());
  auto rig = load_rig((session / "rig.yaml").string());
  EXPECT_TRUE(rig.has_value());
  source.rig = std::move(*rig);
  return source;
}

/// Records the packets of a simulated session that `keep` wants, handing them over every 200, so that blocks are cut in
/// between.
template <class Keep>
void record_growing(const std::filesystem::path& given_session, PacketRecorder& recorder, Keep keep) {
  auto given = open_datagrams(session_packets_path(given_session.string()));
  ASSERT_TRUE(given.has_value());
  Datagram datagram;
  for (int i = 0; *(*given)->next(datagram); ++i) {
    if (keep(datagram)) {
      ASSERT_TRUE(recorder.write(datagram).has_value());
    }
    if (i % 200 != 0) continue;
    ASSERT_TRUE(recorder.hand_over().has_value());
    if (i % 2000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_TRUE(recorder.close().has_value());
}

/// Waits until what came up to a second before was read: as on a rig, packets come no faster than that. Where only the
/// newest are kept, those far behind would be gone.
inline bool is_followed(const LiveStops& stops, const Datagram& datagram) {
  constexpr std::int64_t most_behind_ns = 1'000'000'000;
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  const auto is_behind = [&] {
    const std::int64_t read_ns = stops.status().read_until_ns;
    return read_ns != 0 && datagram.stamp_ns - read_ns > most_behind_ns;
  };
  while (is_behind()) {
    if (std::chrono::steady_clock::now() > give_up) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace rigcal
