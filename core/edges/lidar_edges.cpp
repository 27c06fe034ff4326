#include "core/edges/lidar_edges.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/base/parallel.h"
#include "core/edges/edge_candidates.h"
#include "core/edges/edge_points.h"
#include "core/edges/line_book.h"
#include "core/edges/piece_points.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr double reach_m = 0.4;  // How far from the edge the faces are fitted.
// The beam's width rounds the edge: points so near to the other face are not used.
constexpr double footprint_m = 0.06;
constexpr double sample_m = 0.025;
constexpr double max_sigma_m = 0.004;
constexpr double min_points = 25.0;  // Of each face of a piece.

// A face of a piece: a plane fitted to the points around it, and how sure it is where the edge runs.
struct Face {
  WorldPlane plane;
  std::vector<const EdgePoint*> points;  // those that lie on it
  double thickness_m = 0.0;              // rms of their distances
  double offset_variance = 0.0;          // of its distance at the edge's middle, m^2
};

// What a real surface is not, over such a length.
constexpr double flatness_m = 0.001;

// A face begins so many sigmas of a point beyond `footprint_m` from another plane: noise hardly ever brings a point
// of that one as far, and takes hardly any of the face's own into what lies nearer than `footprint_m` to a third.
constexpr double border_sigmas = 2.0;

// While the faces are only drawn near, so many points of each tell enough, evenly spread.
constexpr std::size_t early_points = 600;

// What one thread needs for piece after piece.
struct Workspace {
  PiecePoints points;
  std::vector<std::uint32_t> chosen;
  std::vector<double> variances;  // of a face's points along its normal
  std::vector<Vector3d> places;   // of a face's points, without their noise along its plane
};

class PieceFitter {
 public:
  PieceFitter(const EdgePiece& piece, const EdgePoints& points, const std::vector<NoiseModel>& noise, Workspace& work)
      : piece_(piece), noise_(noise), work_(work) {
    // What lies on a third plane belongs to neither face.
    work_.points.take(piece, points, noise, std::hypot(0.5 * edge_piece_m, reach_m), footprint_m);
    const double range2 = std::pow(work_.points.largest_range_m(), 2);
    for (const NoiseModel& n : noise) {
      largest_variance_ =
          std::max({largest_variance_, n.range_variance(range2, 0.0), n.angle_rad * n.angle_rad * range2});
    }
  }

  // Samples of this piece; none where it is no edge.
  [[nodiscard]] std::vector<LidarEdge> run() {
    Face a{piece_.a, {}, 0.0, 0.0};
    Face b{piece_.b, {}, 0.0, 0.0};
    Line3 line{piece_.middle, piece_.direction};
    // Leaves are metres large: the first gate takes what they are off here, the later ones only noise.
    for (const double slack : {0.03, 0.01, 0.0}) {
      const bool fits = fit(a, b.plane, line, slack) && fit(b, a.plane, line, slack);
      if (!fits || std::abs(a.plane.n.dot(b.plane.n)) > std::cos(least_edge_angle_rad)) return {};
      line = intersect(a.plane, b.plane, piece_.middle);
      if ((line.p - piece_.middle).norm() > 0.15) return {};  // it has left the place where the leaves meet
    }
    return sample(a, b, line);
  }

 private:
  bool fit(Face& face, const WorldPlane& other, const Line3& line, double slack) {
    FaceGate gate;
    gate.line = line;
    gate.half_length_m = 0.5 * edge_piece_m;
    gate.reach_m = reach_m;
    gate.own = face.plane;
    gate.own_m = 2.5 * std::sqrt(largest_variance_) + slack + 1e-5;  // rounding
    gate.other = other;
    gate.border_m = footprint_m + border_sigmas * std::sqrt(largest_variance_);
    work_.points.choose(gate, work_.chosen);
    face.points.clear();
    std::vector<double>& variances = work_.variances;
    variances.clear();
    const Vector3d n = face.plane.n;
    const std::size_t every = slack > 0.0 ? std::max<std::size_t>(1, work_.chosen.size() / early_points) : 1;
    for (std::size_t k = 0; k < work_.chosen.size(); k += every) {
      const EdgePoint& point = work_.points[work_.chosen[k]];
      const double variance = point.variance_along(n, noise_[point.lidar]);
      if (std::abs(face.plane.distance(point.p_G.cast<double>())) > 2.5 * std::sqrt(variance) + slack) continue;
      face.points.push_back(&point);
      variances.push_back(variance);
    }
    if (static_cast<double>(face.points.size()) < min_points) return false;
    // Noise along the ray moves a point along the plane as well, and would turn it.
    double weight = 0.0;
    Vector3d q = Vector3d::Zero();
    std::vector<Vector3d>& places = work_.places;
    places.clear();
    for (std::size_t i = 0; i < face.points.size(); ++i) {
      places.push_back(above_its_place(*face.points[i], face.plane, variances[i]));
      const double w = 1.0 / variances[i];
      weight += w;
      q += w * places.back();
    }
    q /= weight;
    Matrix3d scatter = Matrix3d::Zero();
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vector3d d = places[i] - q;
      scatter += d * d.transpose() / variances[i];
    }
    const SymmetricEigen eigen = symmetric_eigen(scatter);
    Vector3d normal = eigen.vectors.col(0);
    if (normal.dot(n) < 0.0) normal = -normal;
    if (normal.dot(n) < std::cos(to_rad(15.0))) return false;
    face.plane = {normal, normal.dot(q)};
    const auto count = static_cast<double>(face.points.size());
    double squares = 0.0;
    for (const EdgePoint* point : face.points) squares += std::pow(face.plane.distance(point->p_G.cast<double>()), 2);
    face.thickness_m = std::sqrt(squares / count);
    // Noise that is larger than the model says counts.
    const double chi2 = std::max(1.0, eigen.values[0] / count);
    face.offset_variance = flatness_m * flatness_m + chi2 / weight;
    for (int k = 1; k < 3; ++k) {
      const double lever = eigen.vectors.col(k).dot(line.p - q);
      face.offset_variance += chi2 * lever * lever / std::max(eigen.values[k], 1.0);
    }
    return true;
  }

  // The place on the plane where a point most likely belongs, p - (n.p - d) S n / n'S n (what its distance from the
  // plane tells of its noise along it taken out), and by that distance above it. `variance` is n'S n, m^2.
  [[nodiscard]] Vector3d above_its_place(const EdgePoint& point, const WorldPlane& plane, double variance) const {
    const Vector3d p = point.p_G.cast<double>();
    const Vector3d from_sensor = static_cast<double>(point.range_m) * point.ray_G.cast<double>();
    const double off = plane.distance(p);
    return p + off * (plane.n - noise_[point.lidar].point_covariance(from_sensor, plane.n) * plane.n / variance);
  }

  // Of the line across itself, from the offsets of both faces.
  static Matrix3d line_covariance(const Face& a, const Face& b, const Line3& line) {
    Matrix3d M;
    M << a.plane.n.transpose(), b.plane.n.transpose(), line.direction.transpose();
    const Matrix3d inverse = M.inverse();
    return inverse * Vector3d(a.offset_variance, b.offset_variance, 0.0).asDiagonal() * inverse.transpose();
  }

  // Of each of `count` samples, whether the face goes on beside the edge there: two of three places next to it have
  // points, on one side at least. The first sample lies at `first_m` from the line's point.
  [[nodiscard]] std::vector<char> occupied(const Face& face, const Line3& line, double first_m, int count) const {
    constexpr double places_m[] = {0.07, 0.11, 0.15};
    constexpr double near_m = 0.03;
    constexpr double along_m = 0.04;
    const double step = sample_m;
    const Vector3d across = face.plane.n.cross(line.direction);
    std::vector<std::array<std::uint8_t, 2>> filled(static_cast<std::size_t>(count));  // a bit for each place, by sides
    for (const EdgePoint* point : face.points) {
      const Vector3d d = point->p_G.cast<double>() - line.p;
      const double c = across.dot(d);
      std::uint8_t places = 0;
      for (unsigned k = 0; k < 3; ++k) {
        if (std::abs(std::abs(c) - places_m[k]) < near_m) places = static_cast<std::uint8_t>(places | 1U << k);
      }
      if (places == 0) continue;
      const double along = line.direction.dot(d) - first_m;
      const int first = std::max(0, static_cast<int>(std::ceil((along - along_m) / step)));
      const int last = std::min(count - 1, static_cast<int>(std::floor((along + along_m) / step)));
      for (int k = first; k <= last; ++k) filled[static_cast<std::size_t>(k)][c > 0.0 ? 1 : 0] |= places;
    }
    std::vector<char> out;
    for (const auto& sides : filled) out.push_back(std::popcount(sides[0]) >= 2 || std::popcount(sides[1]) >= 2);
    return out;
  }

  [[nodiscard]] std::vector<LidarEdge> sample(const Face& a, const Face& b, const Line3& line) const {
    LidarEdge edge;
    edge.direction_G = line.direction;
    edge.normal_a_G = a.plane.n;
    edge.normal_b_G = b.plane.n;
    edge.covariance_G = line_covariance(a, b, line);
    const double worst = symmetric_eigen(edge.covariance_G).values[2];
    if (!(worst < max_sigma_m * max_sigma_m)) return {};
    std::vector<LidarEdge> out;
    const double step = sample_m;
    const int half = static_cast<int>(std::floor(0.5 * edge_piece_m / step));
    const double first_m = (0.5 - half) * step;
    const std::vector<char> of_a = occupied(a, line, first_m, 2 * half);
    const std::vector<char> of_b = occupied(b, line, first_m, 2 * half);
    for (int k = 0; k < 2 * half; ++k) {
      if (!of_a[static_cast<std::size_t>(k)] || !of_b[static_cast<std::size_t>(k)]) continue;
      edge.p_G = line.p + (first_m + k * step) * line.direction;
      out.push_back(edge);
    }
    return out;
  }

  const EdgePiece& piece_;
  const std::vector<NoiseModel>& noise_;
  Workspace& work_;
  double largest_variance_ = 0.0;  // along whatever normal
};

}  // namespace

std::vector<LidarEdge> find_lidar_edges(const std::vector<PlaneFeature>& leaves, const std::vector<PatchCells>& patches,
                                        const RigState& state, const std::vector<NoiseModel>& noise,
                                        const std::vector<char>& use) {
  const std::vector<EdgePiece> pieces = edge_candidates(leaves);
  const double reach = std::hypot(0.5 * edge_piece_m, reach_m);
  const EdgePoints points(pieces, patches, state, use, reach);
  std::vector<std::vector<LidarEdge>> of_piece(pieces.size());
  parallel_for(pieces.size(), 16, [&](std::size_t begin, std::size_t end) {
    Workspace work;
    for (std::size_t i = begin; i < end; ++i) of_piece[i] = PieceFitter(pieces[i], points, noise, work).run();
  });
  LineBook book(sample_m);
  for (const std::vector<LidarEdge>& piece : of_piece) book.add(piece);
  return book.take();
}

}  // namespace rigcal
