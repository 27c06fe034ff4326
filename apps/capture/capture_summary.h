#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/capture/capture_status.h"
#include "drivers/livox/device/driver.h"

namespace rigcal {

/// One thing that keeps a capture from being complete.
struct Shortfall {
  enum class Kind {
    no_lidar,          ///< None has sent anything: this is no recording of the rig. Always the first of a list.
    never_sent,        ///< A LiDAR or a camera.
    connection_lost,   ///< To a LiDAR or a camera; also where it came again.
    interrupted,       ///< A LiDAR stopped to send unasked, though its connection stayed.
    fell_silent,       ///< A LiDAR, until the end.
    setting_missing,   ///< A LiDAR does not work as the rig file says.
    images_unwritten,  ///< Of a camera that was given up.
    lost_here,         ///< Packets, frames: this machine was too slow for them.
    failed,            ///< It could not go on as it was asked to.
    stops_unread,      ///< The search for stops came to no end.
    stops_missing,     ///< Of those that it was to end with.
  };
  Kind kind = Kind::failed;
  // With `= {}`, as without it GCC warns where one is left out.
  std::string about = {};           ///< The sensor or interface; empty: the capture as a whole.
  std::string text = {};            ///< One clause.
  std::string mend = {};            ///< Where one is known.
  std::string remark = {};          ///< What it adds to its sensor's line of the summary, which has the counts.
  std::string gap = {};             ///< With its time, where nothing happened that would be among the gaps already.
  std::optional<Error> error = {};  ///< Where the capture failed by it.

  /// "about: text: mend", the one line a user sees.
  [[nodiscard]] std::string message() const;
};

/// What came of a capture.
struct CaptureSummary {
  std::string session;
  CaptureStatus status;
  std::vector<livox::InterfaceReport> interfaces;
  std::uint64_t control_datagrams = 0;  ///< Recorded, both directions.
  std::uint64_t recorded = 0;           ///< All datagrams, also those that --keep has thrown away since.
  std::uint64_t dropped_control = 0;
  livox::ControlCounters control;
  std::optional<std::int64_t> forgotten_until_ns;
  std::int64_t start_ns = 0;  ///< Session time, as of all.
  std::int64_t end_ns = 0;    ///< When it was ended; closing comes after that.
  std::vector<std::string> gaps;
  std::vector<std::string> notes;      ///< What was less good than it could be, with its mend.
  double closing_s = 0.0;              ///< From its end until all was recorded, the devices free and the stops read.
  std::optional<StopReading> reading;  ///< What the stops were found from; nothing where that failed.

  /// Every LiDAR and every camera has sent, without interruption and to the end, and as it was set up to, nothing got
  /// lost in this machine, the stops were found, and all that were asked for are in.
  [[nodiscard]] bool is_complete() const { return shortfalls().empty(); }
  /// What keeps it from that, by the counts above. Nobody else decides what is one.
  [[nodiscard]] std::vector<Shortfall> shortfalls() const;
};

}  // namespace rigcal
