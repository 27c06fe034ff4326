#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/capture/capture_status.h"
#include "drivers/livox/device/driver.h"

namespace rigcal {

/// What happened during a capture and when, in sentences; bounded, so that days of trouble fill no memory.
class CaptureLog {
 public:
  static constexpr std::size_t kMost = 10'000;
  static constexpr std::size_t kNewest = 100;

  /// `sensors`: names by device of the driver.
  explicit CaptureLog(std::vector<std::string> sensors)
      : sensors_(std::move(sensors)), sampling_since_ns_(sensors_.size()), is_silent_(sensors_.size(), false) {}

  void add(const livox::Event& event);
  /// From now on it is meant that LiDARs stop.
  void end() { is_over_ = true; }
  /// Counts of losses that have grown since the last call.
  void compare(std::int64_t now_ns, const std::vector<livox::InterfaceReport>& interfaces);
  /// LiDARs of which nothing comes though they were told to sample, or comes (again), since the last call.
  void compare(std::int64_t now_ns, const std::vector<livox::DeviceReport>& devices);
  /// `is_gap`: also a reason for something that is missing.
  void add(std::int64_t stamp_ns, const std::string& about, const std::string& what, bool is_gap);

  /// In the order of their times; the last one says how many more there were.
  [[nodiscard]] std::vector<std::string> events() const { return closed(events_, left_out_events_); }
  /// The newest `count`, the newest last.
  [[nodiscard]] std::uint64_t count() const { return events_.size() + left_out_events_; }
  [[nodiscard]] std::vector<std::string> last_events(std::size_t count) const;
  [[nodiscard]] std::vector<std::string> gaps() const { return closed(gaps_, left_out_gaps_); }

 private:
  [[nodiscard]] static std::vector<std::string> closed(std::vector<std::string> sentences, std::uint64_t left_out);

  std::vector<std::string> sensors_;
  std::vector<std::optional<std::int64_t>> sampling_since_ns_;  ///< By device, as far as it samples.
  std::vector<bool> is_silent_;                                 ///< By device.
  std::vector<std::string> events_;
  std::vector<std::string> gaps_;
  std::deque<std::string> newest_;  ///< Also those that are left out.
  bool is_over_ = false;
  std::uint64_t left_out_events_ = 0;
  std::uint64_t left_out_gaps_ = 0;
  std::map<std::string, std::string> last_;  ///< By what it is about: not to say it again and again.
  std::map<std::string, livox::ReceiverCounters> last_counters_;  ///< By address.
};

}  // namespace rigcal
