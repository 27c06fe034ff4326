#include "core/edges/line_book.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/wide.h"

namespace rigcal {
namespace {

constexpr double parallel_rad = to_rad(4.0);
constexpr double apart_m = 0.02;
constexpr double apart_per_m = 0.01;

// Lines that are looked at together.
constexpr std::size_t at_a_time = 16;

// A sample as lines are compared with it, with some room for rounding.
struct Wanted {
  std::array<float, 3> p;
  std::array<float, 3> direction;
  float cosine = static_cast<float>(std::cos(parallel_rad)) - 1e-5F;
  float apart = static_cast<float>(apart_m) + 1e-3F;
  float apart_per_m = static_cast<float>(rigcal::apart_per_m) + 1e-5F;
};

using Columns = std::array<const float*, 6>;  // of places, then of directions

// The first look from `look` on with a line that may hold the sample; `looks` where there is none.
RIGCAL_WIDE std::size_t first_look(const Columns& lines, std::size_t look, std::size_t looks, const Wanted& wanted) {
  const Wanted at = wanted;
  for (; look < looks; ++look) {
    const std::size_t first = look * at_a_time;
    const float* px = lines[0] + first;
    const float* py = lines[1] + first;
    const float* pz = lines[2] + first;
    const float* tx = lines[3] + first;
    const float* ty = lines[4] + first;
    const float* tz = lines[5] + first;
    std::int32_t any = 0;
    for (std::size_t i = 0; i < at_a_time; ++i) {
      const float cosine = std::abs(tx[i] * at.direction[0] + ty[i] * at.direction[1] + tz[i] * at.direction[2]);
      const float dx = at.p[0] - px[i];
      const float dy = at.p[1] - py[i];
      const float dz = at.p[2] - pz[i];
      const float along = std::abs(tx[i] * dx + ty[i] * dy + tz[i] * dz);
      const float cx = ty[i] * dz - tz[i] * dy;
      const float cy = tz[i] * dx - tx[i] * dz;
      const float cz = tx[i] * dy - ty[i] * dx;
      const float apart = at.apart + at.apart_per_m * along;
      any |= static_cast<std::int32_t>(cosine >= at.cosine) &
             static_cast<std::int32_t>(cx * cx + cy * cy + cz * cz <= apart * apart);
    }
    if (any != 0) return look;
  }
  return looks;
}

}  // namespace

void LineBook::add(const std::vector<LidarEdge>& piece) {
  if (piece.empty()) return;
  const LidarEdge& middle = piece[piece.size() / 2];
  const std::size_t line = line_of(middle);
  if (line == lines_.size()) open_line(middle);
  Line& book = lines_[line];
  for (const LidarEdge& edge : piece) {
    const auto at = static_cast<std::int64_t>(std::floor(book.direction.dot(edge.p_G - book.p) / sample_m_));
    const auto place = std::lower_bound(book.taken.begin(), book.taken.end(), at);
    if (place != book.taken.end() && *place == at) continue;
    book.taken.insert(place, at);
    edges_.push_back(edge);
    edges_.back().line = first_line_ + static_cast<int>(line);
  }
}

std::size_t LineBook::line_of(const LidarEdge& edge) const {
  Columns columns;
  for (std::size_t k = 0; k < columns.size(); ++k) columns[k] = columns_[k].data();
  Wanted wanted;
  for (std::size_t k = 0; k < 3; ++k) {
    wanted.p[k] = static_cast<float>(edge.p_G[static_cast<Eigen::Index>(k)]);
    wanted.direction[k] = static_cast<float>(edge.direction_G[static_cast<Eigen::Index>(k)]);
  }
  const std::size_t looks = (lines_.size() + at_a_time - 1) / at_a_time;
  for (std::size_t look = first_look(columns, 0, looks, wanted); look < looks;
       look = first_look(columns, look + 1, looks, wanted)) {
    const std::size_t end = std::min(lines_.size(), (look + 1) * at_a_time);
    for (std::size_t line = look * at_a_time; line < end; ++line) {
      if (is_on(lines_[line], edge)) return line;
    }
  }
  return lines_.size();
}

void LineBook::open_line(const LidarEdge& edge) {
  const std::size_t at = lines_.size();
  lines_.push_back({edge.p_G, edge.direction_G, {}});
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    // Room for a look is made at once; a line without a direction is parallel to none.
    if (at % at_a_time == 0) columns_[k].resize(at + at_a_time, 0.0F);
    const Vector3d& of = k < 3 ? edge.p_G : edge.direction_G;
    columns_[k][at] = static_cast<float>(of[static_cast<Eigen::Index>(k % 3)]);
  }
}

bool LineBook::is_on(const Line& line, const LidarEdge& edge) {
  if (std::abs(line.direction.dot(edge.direction_G)) < std::cos(parallel_rad)) return false;
  const Vector3d d = edge.p_G - line.p;
  const double along = line.direction.dot(d);
  return (d - along * line.direction).norm() < apart_m + apart_per_m * std::abs(along);
}

}  // namespace rigcal
