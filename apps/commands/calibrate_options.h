#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

namespace rigcal {

/// How a recording is calibrated: what `rigcal calibrate` and `rigcal batch` are told on the command line.
struct CalibrateOptions {
  std::string input;
  std::string out;
  std::string rig;
  std::string method = "targetless";
  std::string stages = "cameras";
  std::string initial;
  std::string images;
  std::string require = "10mm,0.1deg";
  std::vector<double> pose_prior{0.05, 2.0};
  std::uint64_t seed = 1;
  bool full_map = false;
  bool refine_intrinsics = false;
  bool incremental = false;
};

/// What `--initial` says where nothing is to be guessed.
inline constexpr const char* no_guess = "none";

/// Declares those that do not belong to one recording: all but input, out, images and incremental.
void add_calibration_options(CLI::App& command, CalibrateOptions& options);

/// A CLI::ValidationError where an option was given that is of no use with the method: the planes method knows neither
/// stages nor poses nor cameras, that of the board neither stages nor poses nor a map; who asks for these wants another
/// method.
void check_calibration_options(const CalibrateOptions& options, const CLI::App& command);

/// What makes another `rigcal calibrate` do the same: those of `add_calibration_options` that differ from the usual.
[[nodiscard]] std::vector<std::string> arguments_of(const CalibrateOptions& options);

/// What the report tells of the run, so that it can be repeated.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> settings_of(const CalibrateOptions& options);

/// The files and folders that a result is made from.
[[nodiscard]] std::vector<std::string> inputs_of(const CalibrateOptions& options);

}  // namespace rigcal
