#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/experiment/board_detection.h"
#include "apps/experiment/board_experiment.h"
#include "apps/experiment/board_livox.h"

namespace rigcal {

/// All that `rigcal experiment checkerboard` found; parts that were not asked for are empty.
struct BoardExperiment {
  std::vector<BoardRow> rows;
  std::vector<DetectionRow> detection;
  std::vector<LivoxRow> livox;
};

/// The tables for people.
[[nodiscard]] std::string board_experiment_text(const BoardExperiment& experiment);
/// One JSON object, docs/schema/experiment_checkerboard.json.
[[nodiscard]] std::string board_experiment_json(const BoardExperiment& experiment);

/// Pictures as (file name, SVG): for each kind of pair the errors against the number of poses.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> board_experiment_pictures(
    const std::vector<BoardRow>& rows);
/// The names of these files, whatever was found.
[[nodiscard]] std::vector<std::string> board_experiment_files();

}  // namespace rigcal
