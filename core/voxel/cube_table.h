#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/voxel/cell_sums.h"
#include "core/voxel/key_numbers.h"

namespace rigcal {

/// Of the points of a block: their cubes, where they lie in them, and in which 2 cm cube.
struct PlacedInCubes {
  std::array<EachOfBlock<std::int32_t>, 3> cube;
  std::array<EachOfBlock<double>, 3> off;  ///< From the cube's middle, m.
  EachOfBlock<std::uint64_t> key;
  EachOfBlock<std::int32_t> thin_cube;
};

/// Sums the points of one patch by the cubes of the sensor's grid.
class CubeTable {
 public:
  /// Forgets what was added and not finished; the memory stays.
  void begin(const CellOptions& options);
  /// Points in metres, all within the options' range.
  void add(const PointBlock& block);
  /// The cells in the order in which they were first hit, and the points that are kept. The table is empty afterwards.
  void finish(PatchCells& out);

 private:
  struct Place {
    std::int32_t x = 0, y = 0, z = 0;
  };

  void add_cube(std::size_t i);
  [[nodiscard]] std::uint64_t& thin_word(std::uint32_t number, std::int32_t cube) {
    return thin_bits_[number][static_cast<std::size_t>(cube) / 64];
  }

  CellOptions options_;
  KeyNumbers numbers_;
  std::vector<Place> places_;  // of each cube
  std::vector<CellSums> sums_;
  std::vector<std::array<std::uint64_t, 16>> thin_bits_;  // a bit for each 2 cm cube of a cube
  std::vector<Point> thinned_;
  PlacedInCubes placed_{};
};

}  // namespace rigcal
