#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace rigcal {

/// A place where packets are missing.
struct StreamGap {
  std::int64_t end_ns = 0;  ///< Session time of the first packet after it.
  std::int64_t length_ns = 0;
  std::uint64_t lost = 0;
};

struct StreamCounters {
  std::uint64_t received = 0;  ///< Duplicates included.
  std::uint64_t lost = 0;
  std::uint64_t duplicated = 0;
  std::uint64_t out_of_order = 0;
  std::uint64_t restarts = 0;  ///< Jumps of the device's clock; what was lost there is not known.
  std::uint64_t gaps = 0;

  /// Packets that the device has sent, as far as its stamps tell.
  [[nodiscard]] std::uint64_t expected() const { return received - duplicated + lost; }
};

enum class Arrival { in_order, late, duplicate };

/// Keeps the book of one stream (the points, or the IMU) of one device by its stamps: packets carry no number. Memory
/// is bounded; only the first gaps are listed, all are counted.
class StreamLedger {
 public:
  static constexpr std::size_t kListedGaps = 1000;

  /// `interval_ns` is how long after this packet the next one is due. A gap is more than 1.8 intervals without a
  /// packet; one that comes late after all is taken out of the loss.
  Arrival add(std::int64_t device_ns, double interval_ns, std::int64_t session_ns);
  /// The device's clock has jumped: the next packet is the first again.
  void restart();

  [[nodiscard]] const StreamCounters& counters() const { return counters_; }
  /// The first gaps that were not filled again, in order.
  [[nodiscard]] std::vector<StreamGap> gaps() const;

 private:
  struct OpenGap {
    std::int64_t from = 0;
    std::int64_t to = 0;
    std::uint64_t missing = 0;
    std::size_t listed = kListedGaps;  ///< Its place in the list, kListedGaps where it has none.
  };
  static constexpr std::size_t kRemembered = 64;
  static constexpr std::size_t kOpenGaps = 16;

  [[nodiscard]] bool is_known(std::int64_t device_ns) const;
  void remember(std::int64_t device_ns);
  void open_gap(std::int64_t device_ns, std::int64_t session_ns);
  void fill_gap(std::int64_t device_ns);

  StreamCounters counters_;
  bool started_ = false;
  std::int64_t last_ns_ = 0;
  double interval_ns_ = 0.0;
  std::array<std::int64_t, kRemembered> recent_{};
  std::size_t recent_count_ = 0;
  std::array<OpenGap, kOpenGaps> open_{};
  std::size_t open_count_ = 0;
  std::vector<StreamGap> listed_;
};

}  // namespace rigcal
