#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/edges/lidar_edges.h"

namespace rigcal {

/// Gives the samples of one physical edge the same number, and drops those that two pieces give.
class LineBook {
 public:
  /// Lines are numbered from `first_line` on; two samples of one line within `sample_m` are one.
  explicit LineBook(double sample_m, int first_line = 0) : sample_m_(sample_m), first_line_(first_line) {}

  /// A piece is samples of one straight edge.
  void add(const std::vector<LidarEdge>& piece);

  [[nodiscard]] std::vector<LidarEdge> take() { return std::move(edges_); }

 private:
  struct Line {
    Vector3d p;
    Vector3d direction;
    std::vector<std::int64_t> taken;  // ascending
  };
  [[nodiscard]] static bool is_on(const Line& line, const LidarEdge& edge);
  /// The first line that holds the sample; their number where none does.
  [[nodiscard]] std::size_t line_of(const LidarEdge& edge) const;
  void open_line(const LidarEdge& edge);

  double sample_m_;
  int first_line_;
  std::vector<Line> lines_;
  std::array<std::vector<float>, 6> columns_;  ///< Places and directions of the lines, with room up to a whole look.
  std::vector<LidarEdge> edges_;
};

}  // namespace rigcal
