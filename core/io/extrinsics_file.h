#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/se3.h"
#include "core/rig/rig.h"

namespace rigcal {

/// A direction that is known worse than was required, as a result lists it.
struct ListedDirection {
  bool is_turn = false;  ///< Else a place.
  Vector3d axis = Vector3d::Zero();
  double bound = 0.0;  ///< 95 %; m, or rad of a turn.
  bool is_open = false;
  bool is_frozen = false;
  std::string missing;  ///< What would hold it.
};

/// Transforms by sensor name, from a result's extrinsics.yaml, a ground_truth.yaml or a rig file.
struct ExtrinsicsFile {
  std::string base;
  std::string method;              ///< How it was found; empty where the file does not say it.
  std::vector<std::string> names;  ///< Of the sensors that the file lists, in its order, failed ones included.
  std::map<std::string, SE3> T_base_sensor;                 ///< Sensors without a transform (failed ones) are not here.
  std::map<std::string, std::string> status;                ///< good, weak or failed, where the file says it.
  std::map<std::string, std::vector<std::string>> reasons;  ///< Why not good, where the file says it.
  /// Of xi = [rotation rad; translation m] in T exp(xi), where the file has it.
  std::map<std::string, Matrix6d> covariance;
  std::map<std::string, std::vector<ListedDirection>> weak_directions;  ///< Where the file has some.
  std::map<std::string, CameraIntrinsics> intrinsics;  ///< Of cameras whose intrinsics were found, too.
  bool has_stops = false;                              ///< It lists stops, too: it is a ground truth.
  bool is_rig = false;                                 ///< It is a rig file, which knows more of its sensors.
};

/// The file that `path` stands for: of a folder the extrinsics.yaml in it. Error: a folder that has none.
[[nodiscard]] Expected<std::string> extrinsics_path(const std::string& path);

/// Reads `sensors` of an extrinsics.yaml, of the same exported as JSON or of a ground_truth.yaml (docs/formats.md), or
/// a rig file's `initial_extrinsics`; which of them it is shows in the text. Every error names "file:line": a newer
/// version, a sensor that is not failed without a transform, a quaternion off by more than 1e-3, a base that is not the
/// identity, no transform at all, another convention, matrices that contradict translation and quaternion, a covariance
/// that is none. A result folder stands for its extrinsics.yaml.
[[nodiscard]] Expected<ExtrinsicsFile> load_extrinsics(const std::string& path);
/// The same from text; `name` stands for the file in errors.
[[nodiscard]] Expected<ExtrinsicsFile> parse_extrinsics(const std::string& text, const std::string& name);

/// Lets the transforms map into the frame of `base` instead; that of another sensor must be there to go through. Error,
/// without a place: it is not.
[[nodiscard]] Expected<void> change_base(ExtrinsicsFile& file, const std::string& base);

}  // namespace rigcal
