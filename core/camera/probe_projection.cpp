#include "core/camera/probe_projection.h"

#include <algorithm>
#include <cmath>

#include "core/base/wide.h"

namespace rigcal {
namespace {

constexpr float nowhere = -1e9F;

// A radtan camera that stands at a place of the points' frame, in floats.
struct RadtanAt {
  std::array<float, 9> R;  // from the points' frame, by rows
  std::array<float, 3> t;
  std::array<float, 5> d;
  float fx;
  float fy;
  float cx;
  float cy;
  float max_tangent2;

  RadtanAt(const CameraModel& model, const SE3& T) {
    const SE3 back = T.inverse();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        R[static_cast<std::size_t>(3 * row + column)] = static_cast<float>(back.R(row, column));
      t[static_cast<std::size_t>(row)] = static_cast<float>(back.t[row]);
    }
    const CameraIntrinsics& in = model.intrinsics();
    d.fill(0.0F);
    for (std::size_t k = 0; k < std::min(d.size(), in.distortion.size()); ++k)
      d[k] = static_cast<float>(in.distortion[k]);
    fx = static_cast<float>(in.fx);
    fy = static_cast<float>(in.fy);
    cx = static_cast<float>(in.cx);
    cy = static_cast<float>(in.cy);
    max_tangent2 = static_cast<float>(std::pow(std::tan(model.max_angle_rad()), 2));
  }
};

using Coordinates = std::array<const float*, 3>;

// The formulas are those of CameraModel.
RIGCAL_WIDE void project_radtan(const RadtanAt& camera, const Coordinates& points, float* __restrict out_x,
                                float* __restrict out_y, std::size_t count) {
  const RadtanAt at = camera;
  const float* px = points[0];
  const float* py = points[1];
  const float* pz = points[2];
  for (std::size_t i = 0; i < count; ++i) {
    const float z = at.R[6] * px[i] + at.R[7] * py[i] + at.R[8] * pz[i] + at.t[2];
    const float inverse = 1.0F / z;
    const float x = (at.R[0] * px[i] + at.R[1] * py[i] + at.R[2] * pz[i] + at.t[0]) * inverse;
    const float y = (at.R[3] * px[i] + at.R[4] * py[i] + at.R[5] * pz[i] + at.t[1]) * inverse;
    const float s = x * x + y * y;
    const float radial = 1.0F + s * (at.d[0] + s * (at.d[1] + s * at.d[4]));
    const float u = x * radial + 2.0F * at.d[2] * x * y + at.d[3] * (s + 2.0F * x * x);
    const float v = y * radial + at.d[2] * (s + 2.0F * y * y) + 2.0F * at.d[3] * x * y;
    const bool seen = (z > 0.0F) & (s < at.max_tangent2);
    out_x[i] = seen ? at.fx * u + at.cx : nowhere;
    out_y[i] = seen ? at.fy * v + at.cy : nowhere;
  }
}

// From second points to directions; what has none of them is nowhere.
RIGCAL_WIDE void to_directions(float* __restrict x, float* __restrict y, float* __restrict along_x,
                               float* __restrict along_y, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const bool seen = along_x[i] > 0.5F * nowhere;
    const float from_x = x[i];
    const float from_y = y[i];
    x[i] = seen ? from_x : nowhere;
    y[i] = seen ? from_y : nowhere;
    along_x[i] -= from_x;
    along_y[i] -= from_y;
  }
}

Coordinates pointers(const std::array<std::vector<float>, 3>& values, std::size_t begin) {
  return {values[0].data() + begin, values[1].data() + begin, values[2].data() + begin};
}

}  // namespace

void ProbePoints::add(const Vector3d& p, const Vector3d& beside) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    p_[axis].push_back(static_cast<float>(p[static_cast<Eigen::Index>(axis)]));
    beside_[axis].push_back(static_cast<float>(beside[static_cast<Eigen::Index>(axis)]));
  }
}

void ProbePoints::project(const CameraModel& model, const SE3& T, std::size_t begin, std::size_t end,
                          Pixels& pixels) const {
  const std::size_t count = end - begin;
  for (std::vector<float>* values : {&pixels.x, &pixels.y, &pixels.along_x, &pixels.along_y}) values->resize(count);
  if (model.intrinsics().model == DistortionModel::radtan) {
    const RadtanAt camera(model, T);
    project_radtan(camera, pointers(p_, begin), pixels.x.data(), pixels.y.data(), count);
    project_radtan(camera, pointers(beside_, begin), pixels.along_x.data(), pixels.along_y.data(), count);
  } else {
    project_any(model, T, begin, end, pixels);
  }
  to_directions(pixels.x.data(), pixels.y.data(), pixels.along_x.data(), pixels.along_y.data(), count);
}

void ProbePoints::project_any(const CameraModel& model, const SE3& T, std::size_t begin, std::size_t end,
                              Pixels& pixels) const {
  const SE3 back = T.inverse();
  const auto put = [&](const std::array<std::vector<float>, 3>& points, std::size_t i, float& x, float& y) {
    const auto pixel = model.project(back * Vector3d(points[0][i], points[1][i], points[2][i]));
    x = pixel ? static_cast<float>(pixel->x()) : nowhere;
    y = pixel ? static_cast<float>(pixel->y()) : nowhere;
  };
  for (std::size_t i = begin; i < end; ++i) {
    put(p_, i, pixels.x[i - begin], pixels.y[i - begin]);
    put(beside_, i, pixels.along_x[i - begin], pixels.along_y[i - begin]);
  }
}

}  // namespace rigcal
