#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/recording/recording_progress.h"
#include "core/io/pcapng_writer.h"
#include "core/io/session_lock.h"

namespace rigcal {

/// The packets of a capture on their way into its session, all or only the newest of them. What is to be thrown away
/// lies in files of its own: lidar.pcapng is always the newest part, lidar.000001.pcapng and so on the ones before it.
/// As long as it is there nobody else may mend the session. No memory is asked for per packet.
class PacketRecorder {
 public:
  /// So many files hold what is kept: between 7/8 of the limit and all of it.
  static constexpr std::uint64_t kParts = 8;
  static constexpr std::uint64_t kLeastKept = 16ULL << 20U;

  /// `keep_bytes`: what the files may take together, at least `kLeastKept`; 0: all is kept. Errors: the disk.
  [[nodiscard]] static Expected<PacketRecorder> create(const std::string& session, std::uint64_t keep_bytes);

  /// Errors: the disk; after one, the recording is at its end.
  Expected<void> write(const Datagram& datagram);
  /// Hands everything to the system: others can read it, and it outlives this program.
  Expected<void> hand_over() { return writer_.flush(); }
  /// The same, and the system begins to write it to the disk, so that little is left to do at the end.
  /// Errors, too: the file is not where it was.
  Expected<void> flush();
  /// Hands everything to the system, which brings it to the disk within seconds: a disk that others keep busy must not
  /// keep a capture from ending.
  Expected<void> close();

  [[nodiscard]] std::uint64_t datagrams() const { return datagrams_; }  ///< Also those thrown away since.
  [[nodiscard]] std::uint64_t bytes() const { return earlier_bytes_ + writer_.bytes(); }  ///< As kept.
  /// For who reads the packets while they are recorded.
  [[nodiscard]] std::shared_ptr<RecordingProgress> progress() const { return progress_; }
  /// Session time up to which everything was thrown away.
  [[nodiscard]] std::optional<std::int64_t> forgotten_until_ns() const { return forgotten_until_ns_; }

 private:
  struct Part {
    std::string path;
    std::uint64_t bytes = 0;
    std::int64_t end_ns = 0;
  };
  struct Broadcast {
    Endpoint from;
    Endpoint to;
    std::vector<std::uint8_t> bytes;
  };

  PacketRecorder(std::optional<SessionLock> lock, std::string path, PcapngWriter writer, std::uint64_t part_bytes)
      : lock_(std::move(lock)),
        path_(std::move(path)),
        writer_(std::move(writer)),
        part_bytes_(part_bytes),
        progress_(std::make_shared<RecordingProgress>(path_)) {}
  Expected<void> begin_part(std::int64_t now_ns);
  void remember_broadcast(const Datagram& datagram);

  std::optional<SessionLock> lock_;  ///< Also while the rest of the session is written, after the last packet.
  std::string path_;
  PcapngWriter writer_;
  std::uint64_t part_bytes_;
  std::shared_ptr<RecordingProgress> progress_;
  std::uint64_t datagrams_ = 0;
  int part_number_ = 0;
  std::deque<Part> earlier_;
  std::uint64_t earlier_bytes_ = 0;
  std::int64_t latest_ns_ = 0;
  std::optional<std::int64_t> forgotten_until_ns_;
  /// The last one of each address: a part names its devices itself when those before it are gone.
  std::map<std::array<std::uint8_t, 4>, Broadcast> broadcasts_;
};

}  // namespace rigcal
