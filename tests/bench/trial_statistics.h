#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/evaluation/evaluation.h"

/// What trials of one kind came to; plain text for people.
namespace rigcal {

/// One solution against the truth. Right is what trials take `good` to promise: within 10 mm and 0.1 degrees.
struct Trial {
  SensorError error;
  bool flagged = false;  ///< The verdict is not `good`.
  double wall_s = 0.0;
  [[nodiscard]] bool is_right() const {
    return error.compared && error.translation_m <= 0.010 && error.rotation_rad <= to_rad(0.1);
  }
};

/// "camera_left 0.0123 deg 2.31 mm nees 0.9 good", without a line end.
[[nodiscard]] std::string trial_text(const Trial& trial);

/// A line of counts (right, right but flagged, wrong and flagged, wrong and not flagged), medians, worst and mean NEES.
[[nodiscard]] std::string summary_text(const std::string& title, const std::vector<Trial>& trials);

/// The trial farthest from the truth, each error over what is right; nothing where there is none.
[[nodiscard]] std::optional<std::size_t> worst_trial(const std::vector<Trial>& trials);

}  // namespace rigcal
