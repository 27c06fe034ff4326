#include "core/quality/stop_advice.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/quality/seen_directions.h"

namespace rigcal {
namespace {

constexpr std::size_t most_pieces = 1200;
constexpr double piece_m = 1.5;
constexpr double unevenness_m = 0.002;  // of real surfaces, so that no piece counts for more
constexpr double least_cosine = 0.17;   // flatter incidence returns little
constexpr double step_rad = to_rad(15.0);
constexpr double board_m = 4.0;
constexpr double board_half_m = 0.35;

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

// One reading of a piece's distance along its normal.
struct Reading {
  int stop = 0;
  int lidar = 0;
  double weight = 0.0;
};

// What several looks saw of about the same part of one surface.
struct Piece {
  Vector3d mean = Vector3d::Zero();
  Vector3d normal = Vector3d::Zero();
  std::vector<Reading> readings;
};

// The key of a piece: its cube, and to which of 26 sides it faces.
std::array<int, 4> key_of(const Vector3d& p, const Vector3d& n) {
  const auto cube = [](double x) { return static_cast<int>(std::floor(x / piece_m)); };
  const auto side = [](double x) { return x > 0.4 ? 2 : (x < -0.4 ? 0 : 1); };
  return {cube(p.x()), cube(p.y()), cube(p.z()), (side(n.x()) * 3 + side(n.y())) * 3 + side(n.z())};
}

double weight_of(double variance) { return 1.0 / (variance + unevenness_m * unevenness_m); }

std::vector<Piece> pieces_of(const StopAdviceInput& input) {
  std::map<std::array<int, 4>, Piece> pieces;
  for (const SeenSurface& s : input.surfaces) {
    if (!input.stop_known[static_cast<std::size_t>(s.stop)] || !input.lidar_known[static_cast<std::size_t>(s.lidar)]) {
      continue;
    }
    const SE3 T = input.state.T_G_sensor(s.stop, s.lidar);
    const Vector3d p = T * s.mean;
    const Vector3d n = T.R * s.normal;
    Piece& piece = pieces[key_of(p, n)];
    piece.mean += p;
    piece.normal += n;
    piece.readings.push_back({s.stop, s.lidar, weight_of(s.variance)});
  }
  std::vector<Piece> out;
  const std::size_t count = std::min(most_pieces, pieces.size());
  std::size_t at = 0;
  for (auto& [key, piece] : pieces) {
    // Evenly over all of them.
    const std::size_t before = at++;
    if (before * count / pieces.size() == at * count / pieces.size()) continue;
    piece.mean /= static_cast<double>(piece.readings.size());
    piece.normal.normalize();
    out.push_back(std::move(piece));
  }
  return out;
}

// Information of poses and extrinsics about all but the world's pose: the stops, then the stop to come, and the LiDARs
// last, so that their part of the inverse stands at the end of a decomposition.
class Model {
 public:
  explicit Model(const StopAdviceInput& input)
      : input_(input), stop_index_(input.stop_known.size(), -1), lidar_index_(input.lidar_known.size(), -1) {
    bool is_first = true;
    for (std::size_t j = 0; j < stop_index_.size(); ++j) {
      if (!input.stop_known[j]) continue;
      if (!is_first) stop_index_[j] = add_block();
      is_first = false;
    }
    next_index_ = add_block();
    for (std::size_t i = 0; i < lidar_index_.size(); ++i) {
      if (input.lidar_known[i] && static_cast<int>(i) != input.base) lidar_index_[i] = add_block();
    }
  }

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] int lidar_index(std::size_t lidar) const { return lidar_index_[lidar]; }
  /// Of the first LiDAR; all that was before the stop to come ends at `next_index`.
  [[nodiscard]] int first_lidar() const { return next_index_ + 6; }
  [[nodiscard]] int next_index() const { return next_index_; }

  // What holds everything loosely, so that nothing is singular: a degree and a decimetre of poses, ten degrees and half
  // a metre of extrinsics.
  [[nodiscard]] Matrix loose() const {
    Matrix H = Matrix::Zero(size_, size_);
    const auto hold = [&](int index, double rad, double m) {
      if (index < 0) return;
      H.diagonal().segment<3>(index).setConstant(1.0 / (rad * rad));
      H.diagonal().segment<3>(index + 3).setConstant(1.0 / (m * m));
    };
    for (const int index : stop_index_) hold(index, to_rad(1.0), 0.1);
    for (const int index : lidar_index_) hold(index, to_rad(10.0), 0.5);
    hold(next_index_, to_rad(1.0), 0.1);
    return H;
  }

  // Derivative of the piece's distance, read at `stop` (-1: the stop to come, at `T_G_next`), into one column.
  void derivative(const Piece& piece, int stop, int lidar, const SE3& T_G_next, Vector& J) const {
    J.setZero();
    const SE3& G = stop < 0 ? T_G_next : input_.state.T_G_base[static_cast<std::size_t>(stop)];
    add_pose(G, piece, stop < 0 ? next_index_ : stop_index_[static_cast<std::size_t>(stop)], J);
    const SE3& E = input_.state.T_base_sensor[static_cast<std::size_t>(lidar)];
    add_pose(G * E, piece, lidar_index_[static_cast<std::size_t>(lidar)], J);
  }

 private:
  int add_block() {
    size_ += 6;
    return size_ - 6;
  }
  static void add_pose(const SE3& T, const Piece& piece, int index, Vector& J) {
    if (index < 0) return;
    const Vector3d m = T.R.transpose() * piece.normal;
    J.segment<3>(index) += (T.inverse() * piece.mean).cross(m);
    J.segment<3>(index + 3) += m;
  }

  const StopAdviceInput& input_;
  std::vector<int> stop_index_;
  std::vector<int> lidar_index_;
  int next_index_ = 0;
  int size_ = 0;
};

// The readings of one piece with its own distance eliminated: A - b b^T / W.
struct PieceSum {
  double W = 0.0;
  Vector b;
};

void add_reading(const Vector& J, double weight, Matrix& A, PieceSum& sum) {
  // J has at most twelve entries that are not zero.
  for (int c = 0; c < J.size(); ++c) {
    if (J[c] != 0.0) A.col(c) += weight * J[c] * J;
  }
  sum.W += weight;
  sum.b += weight * J;
}

PieceSum sum_readings(const Model& model, const Piece& piece, Matrix& A) {
  PieceSum sum{0.0, Vector::Zero(model.size())};
  Vector J(model.size());
  for (const Reading& r : piece.readings) {
    model.derivative(piece, r.stop, r.lidar, SE3{}, J);
    add_reading(J, r.weight, A, sum);
  }
  return sum;
}

// Bounds from covariances scaled by what the model says has changed.
class Judge {
 public:
  Judge(const StopAdviceInput& input, const Model& model, const Matrix& H_now)
      : input_(input), model_(model), now_(covariance_of_lidars(H_now)) {}

  // By the lower triangle.
  [[nodiscard]] PredictedBounds bounds(Matrix H) const { return worst(covariance_of_lidars(std::move(H))); }
  [[nodiscard]] PredictedBounds now() const { return worst(now_); }

 private:
  // The inverse's last block is that of L L^T there: everything else need not be solved for.
  [[nodiscard]] Matrix covariance_of_lidars(Matrix H) const {
    const Eigen::Index count = H.rows() - model_.first_lidar();
    const Eigen::LLT<Eigen::Ref<Matrix>> llt(H);
    Matrix inverse = Matrix::Identity(count, count);
    H.bottomRightCorner(count, count).triangularView<Eigen::Lower>().solveInPlace(inverse);
    return inverse.transpose() * inverse;
  }

  [[nodiscard]] PredictedBounds worst(const Matrix& inverse) const {
    PredictedBounds out;
    for (std::size_t i = 0; i < input_.lidar_known.size(); ++i) {
      if (model_.lidar_index(i) < 0) continue;
      const int index = model_.lidar_index(i) - model_.first_lidar();
      const Matrix6d before = now_.block<6, 6>(index, index);
      const Matrix6d after = inverse.block<6, 6>(index, index);
      const Matrix6d& given = input_.covariances[i].isZero(0.0) ? before : input_.covariances[i];
      PredictedBounds one;
      one.lidar = static_cast<int>(i);
      one.translation_m = translation_bound(given) * translation_bound(after) / translation_bound(before);
      one.rotation_rad = rotation_bound(given) * rotation_bound(after) / rotation_bound(before);
      one.of_goal =
          std::max(one.translation_m / input_.goal.translation_m, one.rotation_rad / input_.goal.rotation_rad);
      if (one.of_goal > out.of_goal) out = one;
    }
    return out;
  }

  const StopAdviceInput& input_;
  const Model& model_;
  Matrix now_;  // Of the LiDARs.
};

// Weight of a typical reading of each LiDAR: the median.
std::vector<double> typical_weights(const StopAdviceInput& input) {
  std::vector<std::vector<double>> all(input.lidar_known.size());
  for (const SeenSurface& s : input.surfaces) all[static_cast<std::size_t>(s.lidar)].push_back(weight_of(s.variance));
  std::vector<double> out(all.size(), 0.0);
  for (std::size_t i = 0; i < all.size(); ++i) out[i] = median(std::move(all[i]));
  return out;
}

bool is_in_view(const SeenDirections& seen, const SE3& T_G_sensor, const Piece& piece) {
  const Vector3d p = T_G_sensor.inverse() * piece.mean;
  const Vector3d n = T_G_sensor.R.transpose() * piece.normal;
  return n.dot(p) < -least_cosine * p.norm() && seen.contains(p);
}

class Advisor {
 public:
  explicit Advisor(const StopAdviceInput& input)
      : input_(input),
        model_(input),
        pieces_(pieces_of(input)),
        weights_(typical_weights(input)),
        A_(model_.loose()),
        H_(model_.size(), model_.size()) {
    for (std::size_t i = 0; i < input.lidar_known.size(); ++i) seen_.emplace_back();
    for (const SeenSurface& s : input.surfaces) seen_[static_cast<std::size_t>(s.lidar)].add(s.mean);
    for (const Piece& piece : pieces_) sums_.push_back(sum_readings(model_, piece, A_));
    Matrix B(model_.size(), static_cast<Eigen::Index>(pieces_.size()));
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      B.col(static_cast<Eigen::Index>(k)) = sums_[k].b / std::sqrt(sums_[k].W);
    }
    H_ = A_;
    if (!pieces_.empty()) H_ -= B * B.transpose();
  }

  StopAdvice advise() const {
    const Judge judge(input_, model_, H_);
    StopAdvice advice;
    advice.now = judge.now();
    for (double angle = step_rad; angle < 2.0 * pi - 0.5 * step_rad; angle += step_rad) {
      advice.turns.push_back({angle, {}});
    }
    parallel_for(advice.turns.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        advice.turns[k].after = judge.bounds(after_turn(advice.turns[k].angle_rad));
      }
    });
    for (std::size_t k = 0; k < advice.turns.size(); ++k) {
      if (advice.turns[k].after.of_goal < advice.turns[advice.best_turn].after.of_goal) advice.best_turn = k;
    }
    advice.surface = best_surface(judge, advice.now);
    return advice;
  }

 private:
  [[nodiscard]] std::size_t last_stop() const {
    std::size_t last = 0;
    for (std::size_t j = 0; j < input_.stop_known.size(); ++j) {
      if (input_.stop_known[j]) last = j;
    }
    return last;
  }

  // The lower triangle.
  [[nodiscard]] Matrix after_turn(double angle_rad) const {
    const SE3 T_G_next = input_.axis.turn(angle_rad) * input_.state.T_G_base[last_stop()];
    Matrix H = H_;
    // What is read anew touches only the stop to come and the LiDARs: of the stops before there only becomes less of
    // what the piece's own distance takes away, and of two large products one thin one is left.
    const Eigen::Index stops = model_.next_index();
    const Eigen::Index rest = model_.size() - stops;
    const auto most = static_cast<Eigen::Index>(pieces_.size());
    Matrix of_stops(stops, most);
    Matrix of_rest(rest, most);
    Matrix gone(rest, most);
    Matrix come(rest, most);
    Eigen::Index columns = 0;
    Vector J(model_.size());
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      PieceSum sum = sums_[k];
      for (std::size_t i = 0; i < input_.lidar_known.size(); ++i) {
        if (!input_.lidar_known[i] || weights_[i] == 0.0) continue;
        if (!is_in_view(seen_[i], T_G_next * input_.state.T_base_sensor[i], pieces_[k])) continue;
        model_.derivative(pieces_[k], -1, static_cast<int>(i), T_G_next, J);
        add_reading(J, weights_[i], H, sum);
      }
      if (sum.W == sums_[k].W) continue;
      const Vector& b = sums_[k].b;
      const double W = sums_[k].W;
      const double less = std::sqrt(1.0 / W - 1.0 / sum.W);
      of_stops.col(columns) = less * b.head(stops);
      of_rest.col(columns) = (b.tail(rest) / W - sum.b.tail(rest) / sum.W) / less;
      gone.col(columns) = b.tail(rest) / std::sqrt(W);
      come.col(columns++) = sum.b.tail(rest) / std::sqrt(sum.W);
    }
    if (columns == 0) return H;  // Eigen divides by the number of columns.
    const auto S = of_stops.leftCols(columns);
    H.topLeftCorner(stops, stops).selfadjointView<Eigen::Lower>().rankUpdate(S);
    H.bottomLeftCorner(rest, stops) += of_rest.leftCols(columns) * S.transpose();
    H.bottomRightCorner(rest, rest) += gone.leftCols(columns) * gone.leftCols(columns).transpose();
    H.bottomRightCorner(rest, rest) -= come.leftCols(columns) * come.leftCols(columns).transpose();
    return H;
  }

  // Four corners of a board, each with a distance of its own: what real boards are bent by is small beside that.
  [[nodiscard]] Matrix with_board(const SurfaceCandidate& board, bool& is_seen, int lidar) const {
    Matrix H = H_;
    const SE3& G = input_.state.T_G_base[last_stop()];
    const Vector3d u = board.normal.unitOrthogonal();
    const Vector3d v = board.normal.cross(u);
    is_seen = false;
    for (const auto& [a, b] : {std::pair{1.0, 1.0}, {1.0, -1.0}, {-1.0, 1.0}, {-1.0, -1.0}}) {
      Piece corner{G * (board.place + board_half_m * (a * u + b * v)), G.R * board.normal, {}};
      for (std::size_t j = 0; j < input_.stop_known.size(); ++j) {
        for (std::size_t i = 0; i < input_.lidar_known.size(); ++i) {
          if (!input_.stop_known[j] || !input_.lidar_known[i] || weights_[i] == 0.0) continue;
          const SE3 T = input_.state.T_G_sensor(static_cast<int>(j), static_cast<int>(i));
          if (!is_in_view(seen_[i], T, corner)) continue;
          corner.readings.push_back({static_cast<int>(j), static_cast<int>(i), weights_[i]});
          is_seen |= static_cast<int>(i) == lidar;
        }
      }
      if (corner.readings.empty()) continue;
      const PieceSum sum = sum_readings(model_, corner, H);
      H -= sum.b * sum.b.transpose() / sum.W;
    }
    return H;
  }

  [[nodiscard]] std::optional<SurfaceCandidate> best_surface(const Judge& judge, const PredictedBounds& now) const {
    std::vector<SurfaceCandidate> boards;
    for (int a = 0; a < 12; ++a) {
      for (const double elevation : {to_rad(-30.0), 0.0, to_rad(30.0)}) {
        const double azimuth = to_rad(30.0 * a);
        const Vector3d d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation));
        const Vector3d side(-std::sin(azimuth), std::cos(azimuth), 0.0);
        const Vector3d over = d.cross(side);
        for (const Vector3d& tilt : {Vector3d(Vector3d::Zero()), side, Vector3d(-side), over, Vector3d(-over)}) {
          boards.push_back({board_m * d, (-d + tilt).normalized(), {}});
        }
      }
    }
    std::vector<char> seen(boards.size(), 0);
    parallel_for(boards.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        bool is_seen = false;
        Matrix H = with_board(boards[k], is_seen, now.lidar);
        if (is_seen) boards[k].after = judge.bounds(std::move(H));
        seen[k] = is_seen;
      }
    });
    std::optional<SurfaceCandidate> best;
    for (std::size_t k = 0; k < boards.size(); ++k) {
      if (seen[k] && (!best || boards[k].after.of_goal < best->after.of_goal)) best = boards[k];
    }
    return best;
  }

  const StopAdviceInput& input_;
  Model model_;
  std::vector<Piece> pieces_;
  std::vector<double> weights_;
  std::vector<SeenDirections> seen_;
  std::vector<PieceSum> sums_;
  Matrix A_;
  Matrix H_;
};

}  // namespace

std::optional<StopAdvice> advise_stop(const StopAdviceInput& input) {
  if (std::count(input.lidar_known.begin(), input.lidar_known.end(), 1) < 2) return std::nullopt;
  if (std::count(input.stop_known.begin(), input.stop_known.end(), 1) < 1) return std::nullopt;
  if (input.surfaces.empty()) return std::nullopt;
  return Advisor(input).advise();
}

}  // namespace rigcal
