#pragma once

#include <string>

#include "apps/evaluation/evaluation.h"
#include "core/base/error.h"

namespace rigcal {

/// A result folder with its poses, or an extrinsics.yaml.
[[nodiscard]] Expected<KnownRig> load_result(const std::string& path);

/// An extrinsics.yaml (or the folder that holds it), a ground_truth.yaml, or a rig file.
[[nodiscard]] Expected<KnownRig> load_truth(const std::string& path);

}  // namespace rigcal
