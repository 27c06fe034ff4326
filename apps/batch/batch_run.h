#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "apps/batch/session_names.h"
#include "apps/batch/session_record.h"
#include "core/base/error.h"
#include "core/geometry/se3.h"

namespace rigcal::batch {

struct BatchOptions {
  std::string out;                     ///< The batch's folder.
  Settings settings;                   ///< Of every calibration, without its input.
  std::vector<std::string> arguments;  ///< The same on the command line of `rigcal calibrate`.
  std::vector<std::string> inputs;     ///< Files that all results depend on: the rig file, rough extrinsics.
  int threads = 1;                     ///< Of all calibrations together.
  int jobs = 0;                        ///< Calibrations at a time; 0: as many as threads.
  std::uint64_t memory = 0;            ///< Bytes for all of them together; 0: nine tenths of what is available.
  bool retry = false;                  ///< Tries failures again that came of the input.
};

/// What a result says of a sensor.
struct SensorRow {
  std::string name;
  std::string status;
  std::vector<std::string> reasons;
  bool placed = false;  ///< What follows is known.
  SE3 T_base_sensor;
  double sigma_m = 0.0;  ///< On the worst axis; 0 for the base.
  double sigma_rad = 0.0;
};

/// A session in the table of a batch.
struct SessionRow {
  Session session;
  std::string result;  ///< Its folder.
  /// good, weak or failed, the worst of its sensors, failed where it has no result; waiting: not done yet.
  std::string status = "waiting";
  bool kept = false;  ///< From before, or by another worker.
  std::string why;    ///< Why it was kept or calibrated.
  std::string error;  ///< Of a session that failed as a whole.
  AttemptRecord record;
  std::vector<SensorRow> sensors;
};

struct BatchOutcome {
  std::vector<SessionRow> rows;  ///< In the order of the sessions.
  double wall_s = 0.0;
  int jobs = 0;  ///< At a time,
  int threads_each = 0;
  bool stopped = false;
};

/// Whom to tell.
struct BatchWatcher {
  std::function<void(const std::string& what, double fraction)> progress;
  std::function<void(const std::string& line)> news;
};

/// When the rest will be done, like ", about 40 s left", from what was done in `spent_s`; empty where that is too
/// little to tell.
[[nodiscard]] std::string forecast_text(double spent_s, double bytes_done, double bytes_left);

/// Calibrates every session into `out`/<name> by a `rigcal calibrate` of its own, so that one that fails or crashes is
/// a row and not the end. Several of these may work on one folder, on one machine or several: each session is claimed,
/// what others are at is waited for, and what they leave undone is taken up. After every session batch.csv and
/// batch.json in `out` are replaced as a whole. When told to stop it stops the calibrations; those write nothing.
/// Errors: `out` is no folder of a batch or cannot be written, it has the result of another recording under a name of
/// this one, locks are not to be had.
[[nodiscard]] Expected<BatchOutcome> run_batch(const std::vector<Session>& sessions, const BatchOptions& options,
                                               const BatchWatcher& watcher, const std::stop_token& stop);

}  // namespace rigcal::batch
