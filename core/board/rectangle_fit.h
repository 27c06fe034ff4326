#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace rigcal {

/// A place on the outline of a plate, in the plane's own two axes, metres.
struct OutlinePoint {
  Eigen::Vector2d at;
  Eigen::Vector2d outward;  ///< Unit, the direction in which the plate ended.
};

/// A rectangle of known size on points of its outline.
struct RectangleFit {
  double angle_rad = 0.0;  ///< From the plane's first axis to the rectangle's.
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  /// How much farther out than the edges at +-x and at +-y the points lie, in the mean.
  Eigen::Vector2d growth = Eigen::Vector2d::Zero();
  double rms_m = 0.0;       ///< Of the points that were used, along the edges' normals.
  double used_share = 0.0;  ///< Of the points: within the gate of an edge that faces their way.
  std::vector<int> edge;    ///< For each point 0: +x, 1: -x, 2: +y, 3: -y, -1: none.
  double runner_up = 0.0;   ///< Cost of the best other place over this one's.
};

/// Fits by distances from the edges (Gauss-Newton on the turn about the plane's normal and the shift, from many starts:
/// all turns in steps of 7.5 degrees, nine shifts). Each point belongs to the nearest edge that faces its way. The
/// growth of the edges is estimated with it, held near zero by `growth_sigma_m`. Nothing for fewer than six points.
[[nodiscard]] std::optional<RectangleFit> fit_rectangle(const std::vector<OutlinePoint>& outline,
                                                        const Eigen::Vector2d& size, double gate_m,
                                                        double growth_sigma_m);

/// Residuals of one placement, for points with an edge, and their derivatives by (angle, center, growth); what the fit
/// is made of.
struct EdgeResidual {
  double value = 0.0;
  Eigen::Matrix<double, 1, 5> by_parameters = Eigen::Matrix<double, 1, 5>::Zero();
};
[[nodiscard]] EdgeResidual edge_residual(const OutlinePoint& point, const Eigen::Vector2d& size,
                                         const RectangleFit& fit, int edge);

/// Area of the convex hull of points, and its corners in order.
[[nodiscard]] std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points);
[[nodiscard]] double area_of(const std::vector<Eigen::Vector2d>& hull);
/// Sides of the smallest rectangle round a hull, the longer first.
[[nodiscard]] Eigen::Vector2d smallest_rectangle(const std::vector<Eigen::Vector2d>& hull);

}  // namespace rigcal
