#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/edges/outlines.h"

namespace rigcal {

/// A straight row of depth steps on a cube's face, all towards the same side: what an outline is made of.
struct StepLine {
  Eigen::Vector2d c = Eigen::Vector2d::Zero();   ///< Mean of its steps in u and v,
  Eigen::Vector2d t = Eigen::Vector2d::UnitX();  ///< and its unit direction; n() points to the far side.
  double low = 0.0;                              ///< Its ends along t from c.
  double high = 0.0;
  double inverse_depth = 0.0;  ///< Of the near surface at c, 1/m,
  double slope = 0.0;          ///< and its change along t.
  double rms = 0.0;            ///< Of the steps' distances across.
  double spacing = 0.0;        ///< Mean distance of the rays around, in u and v.
  double shift = 0.0;          ///< Sigma of where the whole of it lies across, beside the beam's width, in u and v.
  bool painted = false;        ///< The surface goes on, in another colour: no beam is cut in two there.
  std::vector<std::uint32_t> steps;

  [[nodiscard]] Eigen::Vector2d n() const { return {-t.y(), t.x()}; }
};

/// The rows of the steps of one face that pass for outlines, the straightest first. No step is in two of them.
[[nodiscard]] std::vector<StepLine> find_step_lines(int face, const std::vector<DepthStep>& steps,
                                                    const BeamWidth& beam);

/// The rows of a patch, by face.
struct PatchOutlines {
  std::array<std::vector<StepLine>, cube_faces> lines;
};

/// The rows of one patch that pass for outlines, in the sensor's frame. `beams`: see `find_outlines`.
[[nodiscard]] PatchOutlines find_patch_outlines(const PatchCells& patch, const std::vector<BeamWidth>& beams);

/// Half of a beam's width across a line with the unit normal n at a place of a face, in u and v.
[[nodiscard]] double half_beam(int face, const Eigen::Vector2d& at, const Eigen::Vector2d& n, const BeamWidth& beam);

}  // namespace rigcal
