#include "core/rig/camera_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Nobody's pinhole sees farther; the tangent grows without bound towards 90 degrees.
constexpr double max_radtan_angle = 85.0 / 180.0 * pi;

// Smallest s in (0, end] where 1 + c1 s + c2 s^2 + ... falls to zero; `end` where it never does.
template <std::size_t n>
double first_zero(const std::array<double, n>& c, double end) {
  const auto value = [&](double s) {
    double sum = 0.0;
    for (std::size_t i = n; i-- > 0;) sum = (sum + c[i]) * s;
    return 1.0 + sum;
  };
  constexpr int steps = 4096;
  for (int i = 1; i <= steps; ++i) {
    double high = end * i / steps;
    if (value(high) > 0.0) continue;
    double low = end * (i - 1) / steps;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (value(middle) > 0.0 ? low : high) = middle;
    }
    return low;
  }
  return end;
}

// Where r (1 + k1 r^2 + k2 r^4 + k3 r^6) stops to grow.
double radtan_max_angle(const std::array<double, 5>& d) {
  const double end = std::pow(std::tan(max_radtan_angle), 2);
  return std::atan(std::sqrt(first_zero<3>({3.0 * d[0], 5.0 * d[1], 7.0 * d[4]}, end)));
}

double equidistant_max_angle(const std::array<double, 5>& d) {
  return std::sqrt(first_zero<4>({3.0 * d[0], 5.0 * d[1], 7.0 * d[2], 9.0 * d[3]}, pi * pi));
}

// theta (1 + k1 theta^2 + ... + k4 theta^8) and its derivative.
std::array<double, 2> distorted_angle(const std::array<double, 5>& d, double theta) {
  const double s = theta * theta;
  const double value = theta * (1.0 + s * (d[0] + s * (d[1] + s * (d[2] + s * d[3]))));
  const double slope = 1.0 + s * (3.0 * d[0] + s * (5.0 * d[1] + s * (7.0 * d[2] + s * 9.0 * d[3])));
  return {value, slope};
}

struct Radtan {
  Vector2d value;
  Matrix2d slope;
};

Vector2d distorted_radtan(const std::array<double, 5>& d, double x, double y, double s) {
  const double p1 = d[2];
  const double p2 = d[3];
  const double radial = 1.0 + s * (d[0] + s * (d[1] + s * d[4]));
  return {x * radial + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x),
          y * radial + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y};
}

Radtan distort_radtan(const std::array<double, 5>& d, const Vector2d& n) {
  const double x = n.x();
  const double y = n.y();
  const double s = n.squaredNorm();
  const double p1 = d[2];
  const double p2 = d[3];
  const double radial = 1.0 + s * (d[0] + s * (d[1] + s * d[4]));
  const double by_s = d[0] + s * (2.0 * d[1] + s * 3.0 * d[4]);
  Radtan out;
  out.value = distorted_radtan(d, x, y, s);
  const double mixed = 2.0 * x * y * by_s + 2.0 * p1 * x + 2.0 * p2 * y;
  out.slope << radial + 2.0 * x * x * by_s + 2.0 * p1 * y + 6.0 * p2 * x, mixed, mixed,
      radial + 2.0 * y * y * by_s + 6.0 * p1 * y + 2.0 * p2 * x;
  return out;
}

}  // namespace

// A point after distortion, before fx fy cx cy.
struct CameraModel::Distorted {
  Vector2d value;
  Matrix23 by_point;
  Eigen::Matrix<double, 2, 5> by_distortion;
};

CameraModel::CameraModel(const CameraIntrinsics& intrinsics) : intrinsics_(intrinsics) {
  std::copy_n(intrinsics.distortion.begin(), std::min(intrinsics.distortion.size(), d_.size()), d_.begin());
  max_angle_rad_ = intrinsics.model == DistortionModel::radtan ? radtan_max_angle(d_) : equidistant_max_angle(d_);
  max_tangent2_ = std::pow(std::tan(max_angle_rad_), 2);
}

template <CameraModel::Wanted wanted>
bool CameraModel::distort(const Vector3d& p, Distorted& out) const {
  if (intrinsics_.model == DistortionModel::equidistant) {
    const double r = p.head<2>().norm();
    const double theta = std::atan2(r, p.z());
    if (!(theta < max_angle_rad_) || (r == 0.0 && p.z() <= 0.0)) return false;
    distort_wide<wanted>(p, r, theta, out);
    return true;
  }
  if (!(p.z() > 0.0)) return false;
  const double x = p.x() / p.z();
  const double y = p.y() / p.z();
  const double s = x * x + y * y;
  if (!(s < max_tangent2_)) return false;
  if constexpr (wanted == Wanted::value) {
    out.value = distorted_radtan(d_, x, y, s);
  } else {
    const Radtan radtan = distort_radtan(d_, {x, y});
    out.value = radtan.value;
    Matrix23 normalised;
    normalised << 1.0, 0.0, -x, 0.0, 1.0, -y;
    out.by_point = radtan.slope * normalised / p.z();
  }
  if constexpr (wanted == Wanted::all) {
    out.by_distortion << x * s, x * s * s, 2.0 * x * y, s + 2.0 * x * x, x * s * s * s,  //
        y * s, y * s * s, s + 2.0 * y * y, 2.0 * x * y, y * s * s * s;
  }
  return true;
}

template <CameraModel::Wanted wanted>
void CameraModel::distort_wide(const Vector3d& p, double r, double theta, Distorted& out) const {
  const auto [angle, slope] = distorted_angle(d_, theta);
  const double square = p.squaredNorm();
  // scale = angle / r, and its derivative by r over r; both have limits on the axis.
  const bool on_axis = r < 1e-6 * std::abs(p.z());
  const double scale = on_axis ? 1.0 / p.z() : angle / r;
  const Vector2d xy = p.head<2>();
  out.value = scale * xy;
  if constexpr (wanted != Wanted::value) {
    const double scale_by_r_over_r =
        on_axis ? 2.0 * (d_[0] - 1.0 / 3.0) / (p.z() * square) : (slope * p.z() / square - scale) / (r * r);
    out.by_point.leftCols<2>() = scale * Matrix2d::Identity() + scale_by_r_over_r * xy * xy.transpose();
    out.by_point.col(2) = -slope / square * xy;
  }
  if constexpr (wanted == Wanted::all) {
    out.by_distortion.setZero();
    double power = theta;
    for (int i = 0; i < 4; ++i) {
      power *= theta * theta;
      if (r > 0.0) out.by_distortion.col(i) = power / r * xy;
    }
  }
}

std::optional<Vector2d> CameraModel::project(const Vector3d& p_camera) const {
  Distorted d;
  if (!distort<Wanted::value>(p_camera, d)) return std::nullopt;
  return Vector2d(intrinsics_.fx * d.value.x() + intrinsics_.cx, intrinsics_.fy * d.value.y() + intrinsics_.cy);
}

std::optional<Vector2d> CameraModel::project(const Vector3d& p_camera, Matrix23& by_point) const {
  Distorted d;
  if (!distort<Wanted::by_point>(p_camera, d)) return std::nullopt;
  const Vector2d focal(intrinsics_.fx, intrinsics_.fy);
  by_point = focal.asDiagonal() * d.by_point;
  return Vector2d(focal.cwiseProduct(d.value) + Vector2d(intrinsics_.cx, intrinsics_.cy));
}

std::optional<Vector2d> CameraModel::project(const Vector3d& p_camera, PixelDerivatives& derivatives) const {
  Distorted d;
  if (!distort<Wanted::all>(p_camera, d)) return std::nullopt;
  const Vector2d focal(intrinsics_.fx, intrinsics_.fy);
  derivatives.by_point = focal.asDiagonal() * d.by_point;
  derivatives.by_intrinsics.setZero();
  derivatives.by_intrinsics(0, 0) = d.value.x();
  derivatives.by_intrinsics(1, 1) = d.value.y();
  derivatives.by_intrinsics(0, 2) = 1.0;
  derivatives.by_intrinsics(1, 3) = 1.0;
  derivatives.by_intrinsics.rightCols<5>() = focal.asDiagonal() * d.by_distortion;
  return Vector2d(focal.cwiseProduct(d.value) + Vector2d(intrinsics_.cx, intrinsics_.cy));
}

std::optional<Vector3d> CameraModel::undistort_radtan(const Vector2d& distorted) const {
  const double max_r = std::tan(max_angle_rad_);
  Vector2d n = distorted;
  if (n.norm() > max_r) n *= 0.9 * max_r / n.norm();
  for (int i = 0; i < 50; ++i) {
    const Radtan radtan = distort_radtan(d_, n);
    const Vector2d error = radtan.value - distorted;
    if (error.norm() < 1e-14 * (1.0 + distorted.norm())) break;
    Vector2d step = radtan.slope.inverse() * error;
    // Near the fold the slope vanishes; short steps stay on this side of it.
    if (!step.allFinite()) return std::nullopt;
    const double longest = 0.3 * (0.1 + n.norm());
    if (step.norm() > longest) step *= longest / step.norm();
    n -= step;
  }
  if (!(n.norm() < max_r) || !((distort_radtan(d_, n).value - distorted).norm() < 1e-9)) return std::nullopt;
  return Vector3d(n.x(), n.y(), 1.0).normalized();
}

std::optional<Vector3d> CameraModel::undistort_equidistant(const Vector2d& distorted) const {
  const double wanted = distorted.norm();
  if (!(wanted < distorted_angle(d_, max_angle_rad_)[0])) return std::nullopt;
  if (wanted == 0.0) return Vector3d::UnitZ();
  // Newton inside a bracket: the distorted angle grows up to the largest one.
  double low = 0.0;
  double high = max_angle_rad_;
  double theta = std::min(wanted, 0.5 * (low + high));
  for (int i = 0; i < 100 && high - low > 0.0; ++i) {
    const auto [value, slope] = distorted_angle(d_, theta);
    (value < wanted ? low : high) = theta;
    const double newton = theta - (value - wanted) / slope;
    const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
    if (std::abs(next - theta) < 1e-16 * theta || next == theta) break;
    theta = next;
  }
  const Vector2d across = distorted / wanted * std::sin(theta);
  return Vector3d(across.x(), across.y(), std::cos(theta));
}

std::optional<Vector3d> CameraModel::ray(const Vector2d& pixel) const {
  const Vector2d distorted((pixel.x() - intrinsics_.cx) / intrinsics_.fx,
                           (pixel.y() - intrinsics_.cy) / intrinsics_.fy);
  if (!distorted.allFinite()) return std::nullopt;
  return intrinsics_.model == DistortionModel::radtan ? undistort_radtan(distorted) : undistort_equidistant(distorted);
}

double CameraModel::widest_cos() const {
  double least = 1.0;
  for (const double x : {-0.05, 0.5, 1.05}) {
    for (const double y : {-0.05, 0.5, 1.05}) {
      const auto seen = ray({x * intrinsics_.width, y * intrinsics_.height});
      if (!seen) return -1.0;
      least = std::min(least, seen->z());
    }
  }
  return least - 0.02;
}

bool CameraModel::contains(const Vector2d& pixel, double margin) const {
  return pixel.x() >= margin && pixel.y() >= margin && pixel.x() <= intrinsics_.width - 1 - margin &&
         pixel.y() <= intrinsics_.height - 1 - margin;
}

}  // namespace rigcal
