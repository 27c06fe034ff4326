#include "core/pipeline/solving_base.h"

#include <algorithm>
#include <array>
#include <set>
#include <tuple>

#include "core/start/signed_turns.h"

namespace rigcal {
namespace {

// The gyro's own LiDAR needs no rotation that only a guess tells, as long as it sees enough to lay the others on.
constexpr double enough_of_most = 0.5;

// How much a LiDAR saw. The wider its view, the more stops see the same: in how many directions it saw surfaces counts.
// What follows them only parts equals, by the data.
struct Seen {
  std::size_t directions = 0;  // of about six degrees, over all stops
  std::size_t surfels = 0;
  double points = 0.0;

  bool operator<(const Seen& other) const {
    return std::tie(directions, surfels, points) < std::tie(other.directions, other.surfels, other.points);
  }
};

std::size_t directions_of(const PatchSurfels& patch) {
  constexpr double parts = 10.0;
  std::set<std::array<int, 3>> directions;
  for (const Surfel& s : patch.surfels) {
    const Vector3d cell = (parts * s.mean.normalized()).array().floor();
    directions.insert({static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())});
  }
  return directions.size();
}

std::vector<Seen> seen_by_lidars(int lidars, const std::vector<PatchSurfels>& patches) {
  std::vector<Seen> seen(static_cast<std::size_t>(lidars));
  for (const PatchSurfels& patch : patches) {
    Seen& of_lidar = seen[static_cast<std::size_t>(patch.lidar)];
    of_lidar.directions += directions_of(patch);
    of_lidar.surfels += patch.surfels.size();
    for (const Surfel& s : patch.surfels) of_lidar.points += s.N;
  }
  return seen;
}

// The LiDAR whose gyro told every turn.
std::optional<int> gyro_lidar(const StartInput& input, const std::vector<std::optional<GyroTurn>>& gyro_turns) {
  if (input.stops < 2 || static_cast<int>(gyro_turns.size()) != input.stops || !gyro_turns[1]) return std::nullopt;
  const bool is_one = std::all_of(gyro_turns.begin() + 1, gyro_turns.end(),
                                  [&](const auto& turn) { return turn && turn->lidar == gyro_turns[1]->lidar; });
  if (!is_one) return std::nullopt;
  return gyro_turns[1]->lidar;
}

template <class T>
bool is_complete(const std::vector<std::optional<T>>& turns, int stops) {
  return static_cast<int>(turns.size()) == stops &&
         std::all_of(turns.begin() + 1, turns.end(), [](const auto& turn) { return turn.has_value(); });
}

bool has_guesses(const StartInput& input) {
  for (int i = 0; i < input.lidars; ++i) {
    if (i != input.base && input.guess_T_base_sensor[static_cast<std::size_t>(i)]) return true;
  }
  return false;
}

template <class T>
void fill_in(const std::vector<std::optional<T>>& from, std::vector<std::optional<T>>& to) {
  for (std::size_t j = 0; j < std::min(from.size(), to.size()); ++j) {
    if (from[j]) to[j] = from[j];
  }
}

RegistrationResult inverse(const RegistrationResult& match) {
  return {match.X.inverse(), match.score, match.runner_up_score, match.runner_up.inverse()};
}

// T = (X exp(xi))^-1 = X^-1 exp(-Ad(X) xi)
ShapeMatch inverse(const ShapeMatch& match) {
  const Matrix6d A = match.X.adjoint();
  return {match.X.inverse(), match.score, match.runner_up_score, match.runner_up.inverse(),
          A * match.covariance * A.transpose()};
}

template <class Match>
void move(const SE3& T, Match& match) {
  match.X = T * match.X;
  match.runner_up = T * match.runner_up;
}

// Whether another pose of the new base fits as well concerns every other LiDAR's place beside it.
void change_base_of_matches(std::size_t from, std::size_t base, const SE3& T_base_from, Start& start) {
  const RegistrationResult of_base = start.matches[base];
  for (std::size_t i = 0; i < start.matches.size(); ++i) {
    if (i == from || i == base) continue;
    move(T_base_from, start.matches[i]);
    if (of_base.score > 0.0) {
      start.matches[i].runner_up_score =
          std::max(start.matches[i].runner_up_score, start.matches[i].score * of_base.runner_up_score / of_base.score);
    }
    if (start.shape_matches[i]) move(T_base_from, *start.shape_matches[i]);
  }
  start.matches[from] = inverse(of_base);
  start.matches[base] = {};
  if (start.shape_matches[base]) start.shape_matches[from] = inverse(*start.shape_matches[base]);
  start.shape_matches[base].reset();
}

void change_base_of_state(std::size_t base, RigState& state) {
  const SE3 T_from_base = state.T_base_sensor[base];
  const SE3 T_base_from = T_from_base.inverse();
  for (SE3& T : state.T_G_base) {
    const bool is_world = T.R == Matrix3d::Identity() && T.t == Vector3d::Zero();
    T = is_world ? SE3{} : T_base_from * T * T_from_base;
  }
  for (SE3& T : state.T_base_sensor) T = T_base_from * T;
  state.T_base_sensor[base] = SE3{};
}

// At most what both moved by, the base's turn at the other's distance.
void change_base_of_moves(std::size_t base, const RigState& state, std::vector<ExtrinsicMove>& moves) {
  if (moves.empty()) return;
  const ExtrinsicMove of_base = moves[base];
  for (std::size_t i = 0; i < moves.size(); ++i) {
    moves[i].rotation_rad += of_base.rotation_rad;
    moves[i].translation_m += of_base.translation_m + of_base.rotation_rad * state.T_base_sensor[i].t.norm();
  }
  moves[base] = {};
}

// What is not a pose of the rig.
void move_world(const SE3& T_new_old, LidarSolution& solution) {
  for (PlaneFeature& feature : solution.refined.map.features) {
    feature.center_G = T_new_old * feature.center_G;
    feature.normal_G = T_new_old.R * feature.normal_G;
  }
  solution.T_grid_G = solution.T_grid_G * T_new_old.inverse();
}

}  // namespace

int solving_lidar(const StartInput& input, const std::vector<std::optional<GyroTurn>>& gyro_turns,
                  const std::vector<PatchSurfels>& patches) {
  if (!input.trajectory.empty()) return input.base;
  const std::optional<int> by_gyro = gyro_lidar(input, gyro_turns);
  // A single stop has no turns that the base's frame would have to hold.
  if (!by_gyro && input.stops > 1) {
    if (is_complete(input.R_previous_this, input.stops)) return input.base;
    if (input.axis && !is_complete(input.turned_rad, input.stops)) return input.base;
  }
  const bool guesses = has_guesses(input);
  const auto is_eligible = [&](int lidar) {
    return !guesses || lidar == input.base || input.guess_T_base_sensor[static_cast<std::size_t>(lidar)];
  };
  const std::vector<Seen> seen = seen_by_lidars(input.lidars, patches);
  int most = input.base;
  for (int i = 0; i < input.lidars; ++i) {
    if (is_eligible(i) && seen[static_cast<std::size_t>(most)] < seen[static_cast<std::size_t>(i)]) most = i;
  }
  if (!by_gyro || !is_eligible(*by_gyro)) return most;
  const auto enough = enough_of_most * static_cast<double>(seen[static_cast<std::size_t>(most)].directions);
  return static_cast<double>(seen[static_cast<std::size_t>(*by_gyro)].directions) >= enough ? *by_gyro : most;
}

std::vector<std::optional<double>> with_signs(std::vector<std::optional<double>> turned_rad,
                                              const std::vector<std::optional<GyroTurn>>& gyro_turns) {
  std::set<int> lidars;
  for (const auto& turn : gyro_turns) {
    if (turn) lidars.insert(turn->lidar);
  }
  for (const int lidar : lidars) {
    std::vector<std::optional<Matrix3d>> of_lidar(gyro_turns.size());
    for (std::size_t j = 0; j < gyro_turns.size(); ++j) {
      if (gyro_turns[j] && gyro_turns[j]->lidar == lidar) of_lidar[j] = gyro_turns[j]->R_previous_this;
    }
    fill_in(signed_turns(of_lidar), turned_rad);
  }
  return turned_rad;
}

StartInput seen_from(int lidar, const StartInput& input, const std::vector<std::optional<GyroTurn>>& gyro_turns) {
  StartInput out = input;
  out.turns_are_own = gyro_lidar(input, gyro_turns) == lidar;
  if (lidar == input.base) return out;
  out.base = lidar;
  out.axis.reset();
  const std::optional<SE3> T_base_this = input.guess_T_base_sensor[static_cast<std::size_t>(lidar)];
  out.guess_T_base_sensor[static_cast<std::size_t>(input.base)] = SE3{};
  for (auto& T : out.guess_T_base_sensor) {
    if (T) T = T_base_this ? std::optional(T_base_this->inverse() * *T) : std::nullopt;
  }
  out.guess_T_base_sensor[static_cast<std::size_t>(lidar)] = SE3{};
  out.R_previous_this.resize(static_cast<std::size_t>(input.stops));
  out.turned_rad.resize(static_cast<std::size_t>(input.stops));
  std::vector<std::optional<double>> turned = signed_turns(out.R_previous_this);
  fill_in(out.turned_rad, turned);
  out.turned_rad = std::move(turned);
  for (std::size_t j = 1; j < out.R_previous_this.size(); ++j) {
    std::optional<Matrix3d>& R = out.R_previous_this[j];
    if (out.turns_are_own) {
      R = gyro_turns[j]->R_previous_this;
    } else if (R && T_base_this) {
      R = Matrix3d(T_base_this->R.transpose() * *R * T_base_this->R);
    } else {
      R.reset();
    }
  }
  return out;
}

void change_base(int from, int base, LidarSolution& solution) {
  if (from == base) return;
  const auto sb = static_cast<std::size_t>(base);
  const SE3 T_base_from = solution.state.T_base_sensor[sb].inverse();
  change_base_of_state(sb, solution.state);
  change_base_of_state(sb, solution.start.state);
  change_base_of_matches(static_cast<std::size_t>(from), sb, T_base_from, solution.start);
  change_base_of_moves(sb, solution.state, solution.refined.last_moves);
  change_base_of_moves(sb, solution.state, solution.moves_on_one_grid);
  if (!solution.frozen.empty()) {
    solution.frozen[static_cast<std::size_t>(from)] = T_base_from.R.transpose() * solution.frozen[sb];
    solution.frozen[sb].setZero();
  }
  move_world(T_base_from, solution);  // The world's frame is the base's where it began.
}

void begin_at_first_stop(LidarSolution& solution) {
  const std::vector<char>& known = solution.start.stop_known;
  const auto first = static_cast<std::size_t>(std::find(known.begin(), known.end(), 1) - known.begin());
  if (first == known.size()) return;
  const SE3 T_G_first = solution.state.T_G_base[first];
  if (T_G_first.R == Matrix3d::Identity() && T_G_first.t == Vector3d::Zero()) return;
  const SE3 T_first_G = T_G_first.inverse();
  for (std::vector<SE3>* poses :
       {&solution.state.T_G_base, &solution.start.state.T_G_base, &solution.start.given_T_G_base}) {
    for (SE3& T : *poses) T = T_first_G * T;
  }
  solution.state.T_G_base[first] = SE3{};
  move_world(T_first_G, solution);
}

}  // namespace rigcal
