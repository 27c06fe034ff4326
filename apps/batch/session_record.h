#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace rigcal::batch {

/// Options of a calibration by name, as report.json has them, but for the input's path.
using Settings = std::vector<std::pair<std::string, std::string>>;

/// What is kept of a session that was tried, beside its result.
struct AttemptRecord {
  std::string input;  ///< From the root, so that it is the same from every folder.
  Settings settings;
  std::string version;      ///< Of rigcal.
  std::string input_state;  ///< See InputState.
  int code = 0;             ///< Exit code of the calibration; -1: ended by a signal.
  std::string error;        ///< In words; empty where there is a result.
  bool of_input = false;    ///< The error: as long as the input stays as it is, it comes again.
  double wall_s = 0.0;
  double cpu_s = 0.0;
  double peak_memory_mb = 0.0;
  std::string host;  ///< That it ran on.
};

/// Names, sizes, times of change of all files of the inputs and whether they may be read: what has these as before has
/// not changed.
struct InputState {
  std::string digest;  ///< Empty where a folder could not be gone through: nothing is known of it.
  std::uint64_t bytes = 0;
};
[[nodiscard]] InputState input_state(const std::vector<std::string>& paths);

/// The recording's path from the root.
[[nodiscard]] std::string whole_path(const std::string& input);

/// Whether a calibration that failed with this exit code did so because of its input or its options, and not because of
/// what stands where its result should go, the disk, or whoever ended it.
[[nodiscard]] bool came_of_input(int code, const std::string& result);

/// The exit code of the calibration that ended with this result, good or not; nothing where there is no report. For a
/// result whose calibration was ended after it had written all.
[[nodiscard]] std::optional<int> code_of_result(const std::string& folder);

/// Nothing where there is none that can be read.
[[nodiscard]] std::optional<AttemptRecord> read_record(const std::string& path);
Expected<void> write_record(const AttemptRecord& record, const std::string& path);

/// Whether a session need not be calibrated, and why it is or is not.
struct Judgement {
  bool keep = false;
  std::string why;
  std::optional<AttemptRecord> record;  ///< Where it is kept.
};

/// What a session is to be calibrated from and with.
struct SessionWork {
  std::string name;
  std::string input;
  std::vector<std::string> inputs;  ///< All files and folders that the result depends on.
  Settings settings;
  std::string result;  ///< Folder.
  std::string record;  ///< File.
};

/// A result is kept where its record says that inputs, options and version are those of now; without such a record
/// (copied, or made by `rigcal calibrate`) where its report says the same and the inputs have the same digests, which
/// takes reading them. A failure that came of the input is kept by its record, unless `retry`.
/// `stop` ends the reading. Errors: what would be replaced is of another recording.
[[nodiscard]] Expected<Judgement> judge_session(const SessionWork& work, const InputState& state, bool retry,
                                                const std::stop_token& stop);

}  // namespace rigcal::batch
