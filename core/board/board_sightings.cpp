#include "core/board/board_sightings.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/board/closed_form.h"

namespace rigcal {
namespace {

constexpr double agree_sigmas = 4.0;
constexpr double least_agree_share = 0.01;  // of the distance: a camera's scale is no better known,
constexpr double least_agree_plate = 0.03;  // and of the plate: no better cut
constexpr double most_agree_plate = 0.2;    // beyond which a board is another one
constexpr double same_motion_rad = to_rad(5.0);
constexpr double same_motion_share = 0.3;  // of the plate's shorter side
constexpr std::size_t most_hypotheses = 600;
constexpr std::size_t most_refined = 4;
constexpr double as_good = 0.8;  // of the best score: then a guess chooses
constexpr double clearly_farther = 3.0;
constexpr double clearly_farther_rad = 0.2;
constexpr double clearly_farther_share = 0.2;  // of the plate's shorter side

struct Match {
  const BoardSighting* a = nullptr;
  const BoardSighting* b = nullptr;
  std::size_t turn_a = 0;
  std::size_t turn_b = 0;
  double score = 0.0;
};

struct Scored {
  SE3 T_a_b;
  double score = 0.0;
  int agreeing = 0;
  std::vector<Match> matches;
};

using Stops = std::map<int, std::pair<std::vector<const BoardSighting*>, std::vector<const BoardSighting*>>>;

double gate_of(const BoardSighting& a, const BoardSighting& b, const BoardModel& board) {
  return std::hypot(agreement_gate(a, board), agreement_gate(b, board));
}

// The best pair of sightings of each stop under a motion; 1 for a perfect one, 0 at the gate.
Scored score_of(const SE3& T_a_b, const Stops& stops, const BoardModel& board) {
  Scored out;
  out.T_a_b = T_a_b;
  for (const auto& [stop, both] : stops) {
    Match best;
    for (const BoardSighting* a : both.first) {
      for (const BoardSighting* b : both.second) {
        const double gate = gate_of(*a, *b, board);
        for (std::size_t i = 0; i < a->alternatives.size(); ++i) {
          const SE3 in_a = a->T_sensor_board * a->alternatives[i];
          for (std::size_t k = 0; k < b->alternatives.size(); ++k) {
            const SE3 in_b = T_a_b * (b->T_sensor_board * b->alternatives[k]);
            const double share = board.corner_distance(in_a, in_b) / gate;
            const double score = 1.0 - share * share;
            if (score > best.score) best = {a, b, i, k, score};
          }
        }
      }
    }
    if (best.a == nullptr) continue;
    out.score += best.score;
    ++out.agreeing;
    out.matches.push_back(best);
  }
  return out;
}

SE3 closed_form_of(const Scored& scored, const BoardModel& board) {
  std::vector<BoardPair> pairs;
  for (const Match& m : scored.matches) {
    pairs.push_back({board_side(m.a->T_sensor_board * m.a->alternatives[m.turn_a], board.plate_corners()),
                     board_side(m.b->T_sensor_board * m.b->alternatives[m.turn_b], board.plate_corners())});
  }
  const auto found = closed_form(pairs);
  return found ? found->T_a_b : scored.T_a_b;
}

bool is_same(const SE3& a, const SE3& b, const BoardModel& board) {
  return rotation_distance(a.R, b.R) < same_motion_rad &&
         (a.t - b.t).norm() < same_motion_share * board.size().minCoeff();
}

// How far a motion is from a guess. Of motions that turn the boards differently the turn tells, since a rough guess is
// better known in it than where boards stand far away; else, where boards look alike, where they are put.
class Closeness {
 public:
  Closeness(const SE3& guess_T_a_b, const Stops& stops, const BoardModel& board)
      : guess_T_a_b_(guess_T_a_b), stops_(stops), board_(board) {}

  [[nodiscard]] bool is_nearer(const SE3& x, const SE3& y) const { return is_nearer(x, y, 1.0, 0.0, 0.0); }

  /// So much nearer that the guess leaves nothing of `y`.
  [[nodiscard]] bool rules_out(const SE3& x, const SE3& y) const {
    return is_nearer(x, y, clearly_farther, clearly_farther_rad, clearly_farther_share * board_.size().minCoeff());
  }

 private:
  [[nodiscard]] bool is_nearer(const SE3& x, const SE3& y, double times, double more_rad, double more_m) const {
    if (rotation_distance(x.R, y.R) > same_motion_rad)
      return times * rotation_distance(x.R, guess_T_a_b_.R) + more_rad < rotation_distance(y.R, guess_T_a_b_.R);
    return times * off_m(x) + more_m < off_m(y);
  }

  [[nodiscard]] double off_m(const SE3& T_a_b) const {
    double sum = 0.0;
    double count = 0.0;
    for (const auto& [stop, both] : stops_) {
      for (const BoardSighting* b : both.second) {
        sum += board_.corner_distance(T_a_b * b->T_sensor_board, guess_T_a_b_ * b->T_sensor_board);
        count += 1.0;
      }
    }
    return sum / count;
  }

  const SE3& guess_T_a_b_;
  const Stops& stops_;
  const BoardModel& board_;
};

std::vector<SE3> hypotheses(const Stops& stops) {
  std::vector<SE3> out;
  for (const auto& [stop, both] : stops) {
    for (const BoardSighting* a : both.first) {
      for (const BoardSighting* b : both.second) {
        for (const SE3& turn_a : a->alternatives) {
          for (const SE3& turn_b : b->alternatives) {
            out.push_back((a->T_sensor_board * turn_a) * (b->T_sensor_board * turn_b).inverse());
          }
        }
      }
    }
  }
  if (out.size() <= most_hypotheses) return out;
  std::vector<SE3> few;
  for (std::size_t k = 0; k < most_hypotheses; ++k) few.push_back(out[k * out.size() / most_hypotheses]);
  return few;
}

// Of those that explain the boards about as well as the first, which is best, the one nearest to the guess.
std::size_t chosen(const std::vector<Scored>& best_first, const std::optional<Closeness>& guess) {
  std::size_t best = 0;
  if (!guess) return best;
  for (std::size_t k = 1; k < best_first.size() && best_first[k].score > as_good * best_first[0].score; ++k) {
    if (guess->is_nearer(best_first[k].T_a_b, best_first[best].T_a_b)) best = k;
  }
  return best;
}

// Of the best, and of what is as good and nearest to the guess, each by all boards that agree with it; best first.
std::vector<Scored> refined_motions(const std::vector<Scored>& scored, const Stops& stops, const BoardModel& board,
                                    const std::optional<Closeness>& guess) {
  std::vector<Scored> refined;
  const auto refine = [&](Scored better) {
    for (int pass = 0; pass < 3; ++pass) {
      Scored next = score_of(closed_form_of(better, board), stops, board);
      if (next.score <= better.score) break;
      better = std::move(next);
    }
    const bool known = std::any_of(refined.begin(), refined.end(),
                                   [&](const Scored& r) { return is_same(r.T_a_b, better.T_a_b, board); });
    if (!known) refined.push_back(std::move(better));
  };
  if (guess) refine(scored[chosen(scored, guess)]);
  for (const Scored& candidate : scored) {
    if (refined.size() >= most_refined) break;
    refine(candidate);
  }
  std::stable_sort(refined.begin(), refined.end(), [](const Scored& x, const Scored& y) { return x.score > y.score; });
  return refined;
}

}  // namespace

double agreement_gate(const BoardSighting& sighting, const BoardModel& board) {
  const double plate = board.size().minCoeff();
  const double least = std::max(least_agree_plate * plate, least_agree_share * sighting.T_sensor_board.t.norm());
  return std::min(std::max(least, agree_sigmas * sighting.corner_sigma_m), most_agree_plate * plate);
}

BoardSighting image_sighting(int sensor, int stop, ImageBoard seen, const ImagePose& pose, const BoardModel& board,
                             const CameraModel& camera) {
  BoardSighting out;
  out.sensor = sensor;
  out.stop = stop;
  out.T_sensor_board = pose.T_camera_board;
  out.alternatives = seen.alternatives;
  // Depth from a small tilted figure: its size in pixels is known to the residual over the number of corners, its tilt
  // less well; a third of a pixel per corner of the plate covers both.
  const double px = std::max(pose.rms_px, 0.1) * pose.T_camera_board.t.norm() / camera.intrinsics().fx;
  const double extent = board.size().maxCoeff() / std::max(board.square(), 1e-9) / std::sqrt(seen.ids.size());
  out.corner_sigma_m = px * std::max(1.0, extent);
  out.image = std::move(seen);
  return out;
}

BoardSighting cloud_sighting(int sensor, int stop, CloudBoard seen, const BoardModel& board) {
  BoardSighting out;
  out.sensor = sensor;
  out.stop = stop;
  out.T_sensor_board = seen.T_lidar_board;
  out.alternatives = board.plate_turns();
  out.corner_sigma_m = seen.squares ? 0.005 : std::max(0.005, seen.border_rms_m);
  out.cloud = std::move(seen);
  const bool tells = out.cloud->squares && (board.columns() + board.rows()) % 2 != 0 && out.alternatives.size() == 2;
  if (!tells) return out;
  // The square inwards of the first corner is dark, and so the one across it.
  return resolved(out, out.cloud->squares->first_is_dark ? 0 : 1, board);
}

BoardSighting resolved(const BoardSighting& sighting, std::size_t alternative, const BoardModel& board) {
  BoardSighting out = sighting;
  const SE3& turn = sighting.alternatives[alternative];
  out.T_sensor_board = sighting.T_sensor_board * turn;
  out.alternatives = {SE3{}};
  const SE3 back = turn.inverse();
  if (out.image) {
    for (int& id : out.image->ids) id = board.id_at(back * board.corner(id));
    out.image->alternatives = {SE3{}};
  }
  if (out.cloud) take_turn(*out.cloud, turn);
  return out;
}

std::optional<PairPlacementByBoards> place_pair(const std::vector<BoardSighting>& sightings, int a, int b,
                                                const BoardModel& board, const std::optional<SE3>& guess_T_a_b) {
  Stops stops;
  for (const BoardSighting& s : sightings) {
    if (s.sensor == a) stops[s.stop].first.push_back(&s);
    if (s.sensor == b) stops[s.stop].second.push_back(&s);
  }
  std::erase_if(stops, [](const auto& entry) { return entry.second.first.empty() || entry.second.second.empty(); });
  if (stops.empty()) return std::nullopt;
  std::optional<Closeness> guess;
  if (guess_T_a_b) guess.emplace(*guess_T_a_b, stops, board);
  std::vector<Scored> scored;
  for (const SE3& T : hypotheses(stops)) scored.push_back(score_of(T, stops, board));
  std::stable_sort(scored.begin(), scored.end(), [](const Scored& x, const Scored& y) { return x.score > y.score; });
  const std::vector<Scored> refined = refined_motions(scored, stops, board, guess);
  const std::size_t best = chosen(refined, guess);
  PairPlacementByBoards out;
  out.T_a_b = closed_form_of(refined[best], board);
  out.agreeing = refined[best].agreeing;
  out.shared = static_cast<int>(stops.size());
  for (std::size_t k = 0; k < refined.size(); ++k) {
    if (k == best || (guess && guess->rules_out(out.T_a_b, refined[k].T_a_b))) continue;
    out.runner_up = refined[best].score > 0.0 ? std::min(1.0, refined[k].score / refined[best].score) : 1.0;
    break;
  }
  return out;
}

}  // namespace rigcal
