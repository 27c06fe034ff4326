#include "core/edges/outlines.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/edges/line_book.h"
#include "core/edges/row_lines.h"
#include "core/edges/step_lines.h"

namespace rigcal {
namespace {

constexpr double sample_m = 0.05;     // Samples of a line are so far apart,
constexpr double sample_rad = 0.008;  // and at least so far as seen from the sensor.
// A surface is met while a part of the beam's width still hits it: outlines lie so far outside, in halves of it.
constexpr double beam_share = 1.0;
constexpr double beam_share_sigma = 0.7;

// Sigma of the near surface's range at an outline, where mixed points are: it hardly moves a camera's pixel.
constexpr double range_sigma_m = 0.01;

// Samples of a line in the world.
std::vector<LidarEdge> sample(const StepLine& line, int face, const SE3& T_G_sensor, const BeamWidth& beam) {
  const double half_beam_uv = half_beam(face, line.c, line.n(), beam);
  const double outside_uv = line.painted ? 0.0 : beam_share * half_beam_uv;
  const auto place = [&](double s) {
    const Eigen::Vector2d uv = line.c + s * line.t - outside_uv * line.n();
    return from_face({face, uv.x(), uv.y(), line.inverse_depth + line.slope * s});
  };
  // A row whose depth does not fit a line at all could end behind the sensor.
  if (line.inverse_depth + line.slope * line.low <= 0.0 || line.inverse_depth + line.slope * line.high <= 0.0)
    return {};
  const Vector3d a = place(line.low);
  const Vector3d b = place(line.high);
  const Vector3d direction = (b - a).normalized();
  const double length = (b - a).norm();
  const auto count = static_cast<double>(line.steps.size());
  const double extent = line.high - line.low;
  // Steps lie anywhere between two rays.
  const double sigma = std::max(line.rms, 0.3 * line.spacing);
  std::vector<LidarEdge> out;
  const double step_m = std::max(sample_m, sample_rad / line.inverse_depth);
  const int samples = std::max(2, static_cast<int>(length / step_m));
  for (int k = 0; k < samples; ++k) {
    const double share = (k + 0.5) / samples;
    const Vector3d p = a + share * (b - a);
    const double range = p.norm();
    const Vector3d ray = p / range;
    const Vector3d across = ray.cross(direction).normalized();
    // Places along a line are not equal shares of the angle, but near enough for a sigma.
    const double off = (share - 0.5) * extent;
    const double across_m = range * sigma * std::sqrt((1.0 + 12.0 * off * off / (extent * extent)) / count);
    LidarEdge edge;
    edge.p_G = T_G_sensor * p;
    edge.direction_G = T_G_sensor.R * direction;
    edge.normal_a_G = T_G_sensor.R * direction.cross(across).normalized();
    edge.normal_b_G = edge.normal_a_G;
    const Vector3d across_G = T_G_sensor.R * across;
    const Vector3d ray_G = T_G_sensor.R * ray;
    edge.covariance_G = across_m * across_m * across_G * across_G.transpose() +
                        range_sigma_m * range_sigma_m * ray_G * ray_G.transpose();
    edge.shift_m = std::hypot(beam_share_sigma * half_beam_uv, line.shift) / std::abs(line.inverse_depth);
    out.push_back(edge);
  }
  return out;
}

BeamWidth beam_of(const PatchCells& patch, const std::vector<BeamWidth>& beams) {
  return beams.empty() ? BeamWidth{} : beams[static_cast<std::size_t>(patch.lidar)];
}

}  // namespace

PatchOutlines find_patch_outlines(const PatchCells& patch, const std::vector<BeamWidth>& beams) {
  PatchOutlines out;
  if (const std::vector<ScanRow> rows = find_scan_rows(patch.thinned); !rows.empty()) {
    const auto steps = find_row_steps(rows);
    for (std::size_t face = 0; face < steps.size(); ++face) out.lines[face] = find_row_lines(steps[face]);
    return out;
  }
  const auto steps = find_depth_steps(patch.thinned);
  for (std::size_t face = 0; face < steps.size(); ++face) {
    out.lines[face] = find_step_lines(static_cast<int>(face), steps[face], beam_of(patch, beams));
  }
  return out;
}

std::vector<LidarEdge> find_outlines(const std::vector<PatchCells>& patches, const RigState& state,
                                     const std::vector<char>& use, int first_line, const std::vector<BeamWidth>& beams,
                                     const std::vector<PatchOutlines>* known) {
  std::vector<std::vector<std::vector<LidarEdge>>> of_patch(patches.size());
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!use.empty() && !use[k]) continue;
      const SE3 T = state.T_G_sensor(patches[k].stop, patches[k].lidar);
      PatchOutlines found;
      if (known == nullptr) found = find_patch_outlines(patches[k], beams);
      const auto& faces = (known != nullptr ? (*known)[k] : found).lines;
      for (std::size_t face = 0; face < faces.size(); ++face) {
        for (const StepLine& line : faces[face]) {
          of_patch[k].push_back(sample(line, static_cast<int>(face), T, beam_of(patches[k], beams)));
        }
      }
    }
  });
  LineBook book(sample_m, first_line);
  for (const auto& lines : of_patch) {
    for (const std::vector<LidarEdge>& line : lines) book.add(line);
  }
  return book.take();
}

}  // namespace rigcal
