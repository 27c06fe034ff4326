#include "core/board/charuco_images.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "core/board/image_bytes.h"
#include "core/board/markers.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

constexpr double bent = 0.12;       // of a marker's side: how far its corners may lie off one plane with its neighbour
constexpr double within_gap = 0.7;  // of the way from a corner to the next marker: what is looked at there
constexpr std::size_t least_corners = 4;

struct Cell {
  int column = 0;
  int row = 0;
  friend auto operator<=>(const Cell&, const Cell&) = default;
};

// Bright squares get markers row by row. The upper left square is dark; on boards of OpenCV before 4.6 with an even
// number of rows of squares (`old`) it is bright.
std::map<int, Cell> cells_by_marker(const BoardModel& board, bool old) {
  std::map<int, Cell> out;
  int id = 0;
  for (int row = 0; row <= board.rows(); ++row) {
    for (int column = 0; column <= board.columns(); ++column) {
      if ((row + column) % 2 == (old ? 0 : 1)) out[id++] = {column, row};
    }
  }
  return out;
}

Vector2d middle_of(const BoardModel& board, const Cell& cell) {
  return board.lattice(cell.column - 0.5, cell.row - 0.5).head<2>();
}

// A marker with where its corners are on the board.
struct Seen {
  const ImageMarker* marker = nullptr;
  std::array<Vector2d, 4> on_board;
};
using SeenMarkers = std::map<Cell, Seen>;

SeenMarkers laid_out(const std::vector<ImageMarker>& markers, const BoardModel& board, bool old) {
  const std::map<int, Cell> cells = cells_by_marker(board, old);
  const double half = 0.5 * board.marker();
  SeenMarkers out;
  for (const ImageMarker& marker : markers) {
    const auto cell = cells.find(marker.id);
    if (cell == cells.end()) continue;
    const Vector2d at = middle_of(board, cell->second);
    out[cell->second] = {&marker,
                         {at + Vector2d(-half, -half), at + Vector2d(half, -half), at + Vector2d(half, half),
                          at + Vector2d(-half, half)}};
  }
  return out;
}

// From the board's plane to the image by the markers next to one inner corner.
struct Local {
  cv::Matx33d H;
  double off = 0.0;  // worst corner, of a marker's side

  [[nodiscard]] Vector2d operator()(const Vector2d& p) const {
    const cv::Vec3d q = H * cv::Vec3d(p.x(), p.y(), 1.0);
    return {q[0] / q[2], q[1] / q[2]};
  }
};

std::optional<Local> local_of(const std::vector<const Seen*>& markers) {
  std::vector<cv::Point2d> from;
  std::vector<cv::Point2d> to;
  double side = 0.0;
  for (const Seen* seen : markers) {
    for (std::size_t c = 0; c < 4; ++c) {
      from.emplace_back(seen->on_board[c].x(), seen->on_board[c].y());
      to.emplace_back(seen->marker->corners[c].x(), seen->marker->corners[c].y());
      side = std::max(side, (seen->marker->corners[c] - seen->marker->corners[(c + 1) % 4]).norm());
    }
  }
  const cv::Mat found = cv::findHomography(from, to, 0);
  if (found.empty() || !cv::checkRange(found)) return std::nullopt;
  Local out{found, 0.0};
  for (std::size_t k = 0; k < from.size(); ++k) {
    const Vector2d there = out({from[k].x, from[k].y});
    out.off = std::max(out.off, (there - Vector2d(to[k].x, to[k].y)).norm() / std::max(1.0, side));
  }
  return out;
}

std::vector<const Seen*> next_to(const SeenMarkers& seen, int column, int row) {
  std::vector<const Seen*> out;
  for (const Cell& cell :
       {Cell{column, row}, Cell{column + 1, row}, Cell{column, row + 1}, Cell{column + 1, row + 1}}) {
    const auto found = seen.find(cell);
    if (found != seen.end()) out.push_back(&found->second);
  }
  return out;
}

// Markers that lie on one plane with a neighbour: what was read into clutter, or belongs to another layout, does not.
std::set<const Seen*> trusted(const SeenMarkers& seen, const BoardModel& board) {
  std::set<const Seen*> out;
  for (int id = 0; id < board.corner_count(); ++id) {
    const auto markers = next_to(seen, id % board.columns(), id / board.columns());
    if (markers.size() < 2) continue;
    const auto local = local_of(markers);
    if (local && local->off < bent) out.insert(markers.begin(), markers.end());
  }
  return out;
}

double grey_at(const cv::Mat& image, const Vector2d& p) {
  const int x = std::clamp(static_cast<int>(std::lround(p.x())), 0, image.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(p.y())), 0, image.rows - 1);
  return image.at<std::uint8_t>(y, x);
}

// The corner's place to a fraction of a pixel; nothing where dark and bright squares do not meet there.
std::optional<Vector2d> sharpened(const cv::Mat& image, const BoardModel& board, int id, const Local& local,
                                  bool dark_first) {
  const Vector2d on_board = board.corner(id).head<2>();
  const Vector2d rough = local(on_board);
  const double gap = 0.5 * (board.square() - board.marker());
  // The least of the bright squares and the most of the dark ones: at the pattern's end three are bright.
  double greys[4] = {};
  double nearest_px = 1e9;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Vector2d way(quarter % 2 == 0 ? -gap : gap, quarter / 2 == 0 ? -gap : gap);
    nearest_px = std::min(nearest_px, (local(on_board + way) - rough).cwiseAbs().maxCoeff());
    greys[quarter] = grey_at(image, local(on_board + 0.5 * way));
  }
  const bool even = (id % board.columns() + id / board.columns()) % 2 == 0;
  const double first[2] = {std::min(greys[0], greys[3]), std::max(greys[0], greys[3])};
  const double second[2] = {std::min(greys[1], greys[2]), std::max(greys[1], greys[2])};
  const double brighter = even == dark_first ? second[0] - first[1] : first[0] - second[1];
  if (brighter < least_board_contrast) return std::nullopt;
  const int half = std::clamp(static_cast<int>(within_gap * nearest_px), 2, 9);
  const double reach = half + 2.0;
  if (rough.x() < reach || rough.y() < reach || rough.x() > image.cols - 1 - reach ||
      rough.y() > image.rows - 1 - reach)
    return std::nullopt;
  std::vector<cv::Point2f> place{{static_cast<float>(rough.x()), static_cast<float>(rough.y())}};
  cv::cornerSubPix(image, place, {half, half}, {-1, -1}, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 0.001});
  const Vector2d out(place[0].x, place[0].y);
  if ((out - rough).norm() > std::max(0.8, 0.12 * nearest_px)) return std::nullopt;
  return out;
}

// All corners next to markers that are trusted.
ImageBoard corners_of(const cv::Mat& image, const SeenMarkers& seen, const BoardModel& board, bool old) {
  const std::set<const Seen*> good = trusted(seen, board);
  // Our own frame begins at a dark square where the board has one in one corner only.
  const bool turned = old && (board.columns() + board.rows()) % 2 != 0;
  ImageBoard out;
  std::map<int, Vector2d> found;
  for (int id = 0; id < board.corner_count(); ++id) {
    std::vector<const Seen*> markers = next_to(seen, id % board.columns(), id / board.columns());
    std::erase_if(markers, [&](const Seen* s) { return !good.contains(s); });
    if (markers.empty()) continue;
    const auto local = local_of(markers);
    if (!local) continue;
    const auto place = sharpened(image, board, id, *local, !old);
    if (place) found[turned ? board.corner_count() - 1 - id : id] = *place;
  }
  for (const auto& [id, place] : found) {
    out.ids.push_back(id);
    out.pixels.push_back(place);
  }
  out.whole = static_cast<int>(out.ids.size()) == board.corner_count();
  out.alternatives = {SE3{}};
  return out;
}

bool is_in_one_line(const ImageBoard& seen, const BoardModel& board) {
  std::set<int> columns;
  std::set<int> rows;
  for (const int id : seen.ids) {
    columns.insert(id % board.columns());
    rows.insert(id / board.columns());
  }
  return columns.size() < 2 || rows.size() < 2;
}

}  // namespace

ImageBoards find_charuco_board(const GreyImage& grey, const BoardModel& board) {
  ImageBoards out;
  const std::vector<ImageMarker> markers = find_markers(grey, board.dictionary());
  const cv::Mat image = bytes_of(grey);
  ImageBoard best = corners_of(image, laid_out(markers, board, false), board, false);
  if (board.rows() % 2 != 0) {
    ImageBoard other = corners_of(image, laid_out(markers, board, true), board, true);
    if (other.ids.size() > best.ids.size()) best = std::move(other);
  }
  if (best.ids.size() >= least_corners && !is_in_one_line(best, board)) {
    out.boards.push_back(std::move(best));
  } else if (markers.empty()) {
    out.why_none = "no marker of the board's dictionary in it";
  } else {
    out.why_none = "too little of the board in it: markers " + std::to_string(markers.size()) + ", inner corners " +
                   std::to_string(best.ids.size());
  }
  return out;
}

}  // namespace rigcal
