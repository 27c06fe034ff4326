#include "core/camera/information_cost.h"

#include <Eigen/Geometry>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

constexpr std::size_t chunk = 8192;
// Of the sightings every so many tell the shape well enough.
constexpr std::size_t shape_stride = 8;
// Of an image, each way.
constexpr int tiles = 4;

struct GradientSum {
  Vector6d gradient = Vector6d::Zero();
  Matrix6d shape = Matrix6d::Zero();
  GradientSum& operator+=(const GradientSum& o) {
    gradient += o.gradient;
    shape += o.shape;
    return *this;
  }
};

}  // namespace

// What one sighting adds to the gradient.
struct InformationCost::Slope {
  Eigen::Matrix<float, 6, 1> by_pose;  // of the grey value
  GreySpread spread{0.0F};
  std::uint32_t tile = 0;  // of all images
  std::uint8_t code = 0;
  bool seen = false;
};

InformationCost::Value InformationCost::value(const SE3& T_base_camera) const {
  const SE3 T = T_base_camera.inverse();
  JointHistogram histogram;
  for (const Sighting& s : sightings_) {
    const auto pixel = model_.project(T * s.p_base.cast<double>());
    if (!pixel || !model_.contains(*pixel)) continue;
    histogram.add(s.code, GreySpread(images_[s.view].value(*pixel)));
  }
  return {histogram.distance(), histogram.total()};
}

JointHistogram InformationCost::histogram(const SE3& T_camera_base, std::vector<Slope>& slopes) const {
  slopes.resize(sightings_.size());
  return parallel_sum(sightings_.size(), chunk, JointHistogram{}, [&](std::size_t begin, std::size_t end) {
    JointHistogram part;
    for (std::size_t k = begin; k < end; ++k) {
      const Sighting& s = sightings_[k];
      Slope& slope = slopes[k];
      slope.seen = false;
      const Vector3d p = T_camera_base * s.p_base.cast<double>();
      Eigen::Matrix<double, 2, 3> by_point;
      const auto pixel = model_.project(p, by_point);
      if (!pixel || !model_.contains(*pixel)) continue;
      const GreySample grey = images_[s.view].at(*pixel);
      slope.seen = true;
      slope.code = s.code;
      const int column = static_cast<int>(tiles * pixel->x() / model_.intrinsics().width);
      const int row = static_cast<int>(tiles * pixel->y() / model_.intrinsics().height);
      slope.tile = static_cast<std::uint32_t>((s.view * tiles + row) * tiles + column);
      slope.spread = GreySpread(grey.value);
      // p moves by -phi x p - tau.
      const Eigen::RowVector3d by_p = grey.slope.cast<double>().transpose() * by_point;
      slope.by_pose << Vector3d(by_p.transpose().cross(p)).cast<float>(), -by_p.transpose().cast<float>();
      part.add(s.code, slope.spread);
    }
    return part;
  });
}

Vector6d InformationCost::gradient_of(const Slope& slope, const std::vector<float>& by_count) {
  const float* row = by_count.data() + static_cast<std::size_t>(slope.code) * grey_bins + slope.spread.first;
  const std::array<float, 3>& by_grey = slope.spread.slope;
  return static_cast<double>(row[0] * by_grey[0] + row[1] * by_grey[1] + row[2] * by_grey[2]) *
         slope.by_pose.cast<double>();
}

InformationCost::Derivatives InformationCost::derivatives(const SE3& T_base_camera) const {
  std::vector<Slope> slopes;
  const JointHistogram joint = histogram(T_base_camera.inverse(), slopes);
  std::vector<float> by_count;
  Derivatives out;
  out.value = joint.distance(by_count);
  out.seen = joint.total();
  if (!(out.seen > 0.0)) return out;
  const GradientSum sum = parallel_sum(slopes.size(), chunk, GradientSum{}, [&](std::size_t begin, std::size_t end) {
    GradientSum part;
    for (std::size_t k = begin; k < end; ++k) {
      const Slope& s = slopes[k];
      if (!s.seen) continue;
      part.gradient += gradient_of(s, by_count);
      if (k % shape_stride > 0) continue;
      const Vector6d by_pose = s.by_pose.cast<double>();
      part.shape += by_pose * by_pose.transpose();
    }
    return part;
  });
  out.gradient = sum.gradient / out.seen;
  out.shape = static_cast<double>(shape_stride) * sum.shape / out.seen;
  return out;
}

Matrix6d InformationCost::gradient_scatter(const SE3& T_base_camera) const {
  std::vector<Slope> slopes;
  const JointHistogram joint = histogram(T_base_camera.inverse(), slopes);
  std::vector<float> by_count;
  joint.distance(by_count);
  std::vector<Vector6d> of_tile(images_.size() * tiles * tiles, Vector6d::Zero());
  for (const Slope& s : slopes) {
    if (s.seen) of_tile[s.tile] += gradient_of(s, by_count);
  }
  Matrix6d scatter = Matrix6d::Zero();
  for (const Vector6d& g : of_tile) scatter += g * g.transpose();
  const double seen = std::max(1.0, joint.total());
  return scatter / (seen * seen);
}

}  // namespace rigcal
