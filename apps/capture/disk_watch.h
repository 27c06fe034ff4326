#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/error.h"

namespace rigcal {

/// What there is to write to, and how long it lasts.
struct DiskRoom {
  std::uint64_t free_bytes = 0;
  double bytes_per_s = 0.0;            ///< As the session grew lately.
  std::optional<double> seconds_left;  ///< Until the recording would be ended; nothing where nothing
                                       ///< grows, or --keep makes room for all that does.
};

/// What a session holds on the disk now.
struct SessionBytes {
  std::uint64_t packets = 0;
  std::uint64_t images = 0;
};

/// How long a disk lasts that has so much room, when a session grows like this; pure.
class DiskForecast {
 public:
  /// What is always left free: session.json and the last images have to get in.
  static constexpr std::uint64_t kReserveBytes = 32ULL << 20U;

  /// `keep_bytes`: more than this the packets never take, as older ones are thrown away; 0: all are kept.
  explicit DiskForecast(std::uint64_t keep_bytes = 0) : keep_bytes_(keep_bytes) {}

  /// Times in seconds of a clock that never goes back.
  [[nodiscard]] DiskRoom add(double now_s, const SessionBytes& session, std::uint64_t free_bytes);

 private:
  [[nodiscard]] std::optional<double> seconds_left(std::uint64_t packets, double room) const;

  std::uint64_t keep_bytes_;
  double last_s_ = -1.0;
  SessionBytes last_;
  double packets_per_s_ = 0.0;  ///< Bytes of them; and of images.
  double images_per_s_ = 0.0;
};

/// Free bytes where the session lies; nothing where the system does not say.
[[nodiscard]] std::optional<std::uint64_t> free_bytes(const std::string& session);

/// Warns before the disk of a recording is full, and says when to end it; pure.
class DiskWatch {
 public:
  /// How long before, s.
  static constexpr double kWarningS = 120.0;

  /// `keep_bytes`: as of `DiskForecast`.
  explicit DiskWatch(std::string session, std::uint64_t keep_bytes = 0)
      : session_(std::move(session)), forecast_(keep_bytes) {}

  /// As `DiskForecast::add`, until the disk was full once. Gives a sentence to warn with, once.
  [[nodiscard]] std::optional<std::string> look(double now_s, const SessionBytes& session, std::uint64_t free_bytes);

  [[nodiscard]] const std::optional<DiskRoom>& room() const { return room_; }
  /// Why the recording has to end.
  [[nodiscard]] const std::optional<Error>& full() const { return full_; }

 private:
  std::string session_;
  DiskForecast forecast_;
  std::optional<DiskRoom> room_;
  bool has_warned_ = false;
  std::optional<Error> full_;
};

}  // namespace rigcal
