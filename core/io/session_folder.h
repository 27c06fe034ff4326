#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/rig/rig.h"

namespace rigcal {

/// CLOCK_REALTIME and CLOCK_MONOTONIC read together.
struct ClockPair {
  std::int64_t realtime_ns = 0;
  std::int64_t monotonic_ns = 0;
};

/// session.json. A recording that was cut short has no end.
struct SessionRecord {
  std::string software;  ///< Version of the program that recorded, for example "0.1.0".
  std::int64_t start_ns = 0;
  std::optional<std::int64_t> end_ns;
  std::vector<ClockPair> clock_pairs;
  /// By device, then by the counter's name ("packets", "lost" and so on).
  std::map<std::string, std::map<std::string, std::uint64_t>> counters;
  std::vector<std::string> gaps;    ///< Why something is missing, one sentence each.
  std::vector<std::string> events;  ///< What happened, one sentence each, with its time.
};

/// A session folder (docs/manual.md, "Inputs") and what is in it. Paths are empty where the file or folder is not
/// there.
struct SessionFolder {
  std::string path;
  Rig rig;
  std::optional<SessionRecord> record;  ///< Nothing where the recording was cut short before it was written.
  std::string packets;                  ///< lidar.pcapng; see `session_packet_parts`.
  std::string patches;                  ///< patches/
  std::string trajectory;               ///< trajectory.tum
  std::string images;                   ///< images/
  std::string ground_truth;             ///< ground_truth.yaml
};

/// Whether a path is a session folder: one that holds a session.json or packets, or a rig.yaml and patches. One that
/// may not be looked into is taken for one, too: `open_session` says what is wrong with it.
[[nodiscard]] bool is_session_folder(const std::string& path);

/// Reads rig.yaml and session.json and finds the rest. Errors: no session, no permission, no rig.yaml, a newer format,
/// damaged files, a session with neither packets nor patches.
[[nodiscard]] Expected<SessionFolder> open_session(const std::string& path);

/// Whether its session.json says that the recording goes on or was cut short.
[[nodiscard]] bool is_unfinished_session(const std::string& path);

/// Makes the folder with rig.yaml and a session.json that has no end yet. An existing path is never touched.
Expected<void> create_session(const std::string& path, const Rig& rig, const SessionRecord& record);

/// Replaces session.json, for example at the end of the recording.
Expected<void> write_session_record(const std::string& path, const SessionRecord& record);

/// Where the packets of a session lie.
[[nodiscard]] std::string session_packets_path(const std::string& path);

/// A recording of which only the newest part is kept lies in several files: the one at `packets_path` is the newest,
/// and this is the name of the part `number` before it (lidar.000001.pcapng).
[[nodiscard]] std::string session_packets_part_path(const std::string& packets_path, int number);
/// All files of such a recording in the order of time, that of `packets_path` last; only that one where it is of any
/// other kind.
[[nodiscard]] std::vector<std::string> session_packet_parts(const std::string& packets_path);

}  // namespace rigcal
