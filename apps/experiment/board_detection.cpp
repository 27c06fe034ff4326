#include "apps/experiment/board_detection.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/experiment/board_stage.h"
#include "core/board/board_adjustment.h"
#include "core/board/rectangle_fit.h"
#include "simdata/scene/scene_file.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

constexpr std::array<const char*, 3> scenes{"room", "courtyard", "sparse"};
constexpr double least_overlap = 0.95;
constexpr double margin_px = 12.0;
constexpr int most_tries = 20000;
constexpr int asked_k = 1;

// What is left of a polygon on the inner side of a line (Sutherland and Hodgman 1974).
std::vector<Vector2d> cut(const std::vector<Vector2d>& polygon, int axis, double sign, double reach) {
  std::vector<Vector2d> out;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector2d& a = polygon[k];
    const Vector2d& b = polygon[(k + 1) % polygon.size()];
    const double in_a = reach - sign * a[axis];
    const double in_b = reach - sign * b[axis];
    if (in_a >= 0.0) out.push_back(a);
    if ((in_a >= 0.0) != (in_b >= 0.0)) out.push_back(a + (b - a) * (in_a / (in_a - in_b)));
  }
  return out;
}

// Area that a plate found covers together with the true one, over what both cover, in the true one's plane.
double overlap(const SE3& T_true, const SE3& T_found, const BoardModel& board) {
  std::vector<Vector2d> found;
  for (const Vector3d& corner : board.plate_corners()) {
    const Vector3d p = T_true.inverse() * (T_found * corner);
    if (std::abs(p.z()) > 0.3) return 0.0;
    found.emplace_back(p.head<2>());
  }
  const double own = area_of(found);
  std::vector<Vector2d> common = found;
  for (int axis = 0; axis < 2; ++axis) {
    for (const double sign : {-1.0, 1.0}) common = cut(common, axis, sign, 0.5 * board.size()[axis]);
  }
  const double both = common.empty() ? 0.0 : area_of(common);
  return both / (own + board.size().prod() - both);
}

double best_overlap(const BoardSighting& seen, const SE3& T_sensor_board, const BoardModel& board) {
  double best = 0.0;
  for (const SE3& turn : seen.alternatives) {
    best = std::max(best, overlap(T_sensor_board, seen.T_sensor_board * turn, board));
  }
  return best;
}

// All that was seen of the poses in one scene.
struct Shown {
  std::vector<SE3> T_rig_board;
  std::vector<BoardSighting> sightings;  ///< Their stop counts poses.
};

class Judge {
 public:
  Judge(const std::vector<BoardStation>& stations, const Shown& shown, const BoardModel& board)
      : stations_(stations), shown_(shown), board_(board) {}

  [[nodiscard]] bool is_right(const BoardSighting& s) const {
    const SE3 T = stations_[static_cast<std::size_t>(s.sensor)].T_rig_sensor.inverse() *
                  shown_.T_rig_board[static_cast<std::size_t>(s.stop)];
    return best_overlap(s, T, board_) >= least_overlap;
  }

  [[nodiscard]] std::vector<DetectionRow> rows(const std::string& scene) const {
    std::vector<DetectionRow> out;
    for (std::size_t station = 0; station < stations_.size(); ++station) {
      DetectionRow& row = out.emplace_back();
      row.scene = scene;
      row.sensor = stations_[station].camera ? "camera" : "LiDAR of 16 rings";
      row.boards = static_cast<int>(shown_.T_rig_board.size());
      for (const BoardSighting& s : shown_.sightings) {
        if (static_cast<std::size_t>(s.sensor) == station) ++(is_right(s) ? row.right : row.wrong);
      }
    }
    count_used(out);
    return out;
  }

 private:
  // What a calibration keeps that is no board: a piece that lies off the plate by more than a third of it.
  void count_used(std::vector<DetectionRow>& rows) const {
    const auto placed = place_pair(shown_.sightings, 0, 1, board_, std::nullopt);
    if (!placed) return;
    std::vector<BoardSensor> sensors(2);
    sensors[1].T_base_sensor = placed->T_a_b;
    for (std::size_t s = 0; s < 2; ++s) {
      sensors[s].name = stations_[s].name;
      sensors[s].camera = stations_[s].camera;
    }
    sensors[0].fixed = true;
    const BoardAdjustment found =
        adjust_boards(sensors, board_places(shown_.sightings, sensors, board_), board_, BoardAdjustOptions{});
    for (const BoardPlace& place : found.places) {
      if (!place.why_out.empty() || place.sightings.size() < 2) continue;
      for (const BoardSighting& s : place.sightings) {
        const auto station = static_cast<std::size_t>(s.sensor);
        const Vector3d there =
            (stations_[station].T_rig_sensor.inverse() * shown_.T_rig_board[static_cast<std::size_t>(s.stop)]).t;
        if ((s.T_sensor_board.t - there).norm() > board_.size().minCoeff() / 3.0) ++rows[station].wrong_used;
      }
    }
  }

  const std::vector<BoardStation>& stations_;
  const Shown& shown_;
  const BoardModel& board_;
};

}  // namespace

Expected<std::vector<DetectionRow>> detect_boards(int poses, std::uint64_t seed, const RunContext& context) {
  const BoardSettings settings = published_board();
  const BoardModel board(settings);
  std::vector<DetectionRow> out;
  int shown_before = 0;
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    Expected<sim::Scene> scene = sim::load_scene(scenes[k]);
    if (!scene) return scene.error();
    BoardStage stage;
    stage.T_scene_rig = scene->T_scene_table;
    stage.scene = std::move(*scene);
    Random random(seed, 40 + k);
    std::vector<BoardStation> stations = published_rig(random);
    stations = {stations[0], stations[2]};
    const int until = poses * static_cast<int>(k + 1) / static_cast<int>(scenes.size());
    Shown shown;
    for (int tries = 0; tries < most_tries && shown_before < until; ++tries) {
      if (context.cancelled()) return cancelled_error("stopped before the end");
      // The rig turns, too, so that other things stand behind the board.
      stage.T_scene_rig.R = exp_so3({0.0, 0.0, random.uniform(-pi, pi)});
      const SE3 T = draw_board_pose({}, random);
      if (!is_in_all_images(stations, T, board, margin_px) || !stands_free(stage, stations, T, board)) continue;
      context.reporter.progress("detection", static_cast<double>(shown_before) / poses);
      auto seen = see_board(stage, stations, T, settings, {published_noise(asked_k)},
                            seed * 100000 + static_cast<std::uint64_t>(shown_before));
      for (BoardSighting& s : seen[0]) {
        s.stop = static_cast<int>(shown.T_rig_board.size());
        shown.sightings.push_back(std::move(s));
      }
      shown.T_rig_board.push_back(T);
      ++shown_before;
    }
    const auto rows = Judge(stations, shown, board).rows(scenes[k]);
    out.insert(out.end(), rows.begin(), rows.end());
  }
  return out;
}

}  // namespace rigcal
