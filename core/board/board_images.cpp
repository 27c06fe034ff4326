#include "core/board/board_images.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/board/charuco_images.h"
#include "core/board/image_bytes.h"

namespace rigcal {
namespace {

constexpr int least_part = 3;         // corners a side of a board of which only a part is seen
constexpr double quick_side = 960.0;  // pixels: boards are looked for in smaller images first
constexpr double evened_clip = 4.0;   // times the even share of a grey value in a tile
constexpr int evened_tiles = 8;       // along each side of the image
constexpr double irregular = 0.25;    // of the spacing: how far a corner may be from the middle of its neighbours

// A lattice of corners as the detector gives it, row by row.
struct Lattice {
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels;

  [[nodiscard]] const Eigen::Vector2d& at(int column, int row) const {
    return pixels[static_cast<std::size_t>(row * columns + column)];
  }
  // The square beside the corners (column, row) and (column + 1, row + 1) is seen here.
  [[nodiscard]] Eigen::Vector2d middle(int column, int row) const {
    return 0.25 * (at(column, row) + at(column + 1, row) + at(column, row + 1) + at(column + 1, row + 1));
  }
  void turn_columns() {
    for (int row = 0; row < rows; ++row) {
      std::reverse(pixels.begin() + row * columns, pixels.begin() + (row + 1) * columns);
    }
  }
  void swap_axes() {
    Lattice other{rows, columns, {}};
    for (int row = 0; row < other.rows; ++row) {
      for (int column = 0; column < other.columns; ++column) other.pixels.push_back(at(row, column));
    }
    *this = other;
  }
  // Corners in between their neighbours: what was joined from pieces of clutter is not.
  [[nodiscard]] bool is_regular() const {
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        const Eigen::Vector2d& p = at(column, row);
        if (column > 0 && column + 1 < columns) {
          const Eigen::Vector2d step = 0.5 * (at(column + 1, row) - at(column - 1, row));
          if ((p - at(column - 1, row) - step).norm() > irregular * step.norm()) return false;
        }
        if (row > 0 && row + 1 < rows) {
          const Eigen::Vector2d step = 0.5 * (at(column, row + 1) - at(column, row - 1));
          if ((p - at(column, row - 1) - step).norm() > irregular * step.norm()) return false;
        }
      }
    }
    return true;
  }
  // Columns crossed with rows point away from the camera: pixels are right-handed as well, x right and y down.
  void make_right_handed() {
    const Eigen::Vector2d along = at(columns - 1, 0) - at(0, 0);
    const Eigen::Vector2d down = at(0, rows - 1) - at(0, 0);
    if (along.x() * down.y() - along.y() * down.x() < 0.0) turn_columns();
  }
};

// How one try to find a board looks: what makes the detector miss a board differs from image to image.
struct Attempt {
  double scale;
  int flags;
  bool evened = false;  // contrast evened out from place to place: boards before a bright sky, or in the shade
};

std::vector<Attempt> attempts_for(const cv::Mat& image) {
  constexpr int normalised = cv::CALIB_CB_NORMALIZE_IMAGE;
  constexpr int thorough = normalised | cv::CALIB_CB_EXHAUSTIVE;
  const double small = std::min(1.0, quick_side / std::max(image.cols, image.rows));
  std::vector<Attempt> out{{small, normalised}, {small, thorough}};
  if (small < 1.0) out.insert(out.end(), {{1.0, normalised}, {1.0, thorough}, {0.5 * small, thorough}});
  out.push_back({small, thorough | cv::CALIB_CB_ACCURACY});
  out.push_back({small, normalised, true});
  out.push_back({small, thorough, true});
  return out;
}

// An image and the same with its contrast evened out, which is made when it is first asked for.
class Lights {
 public:
  explicit Lights(const cv::Mat& image) : image_(image) {}
  [[nodiscard]] const cv::Mat& of(const Attempt& attempt) {
    if (!attempt.evened) return image_;
    if (evened_.empty()) cv::createCLAHE(evened_clip, cv::Size(evened_tiles, evened_tiles))->apply(image_, evened_);
    return evened_;
  }

 private:
  const cv::Mat& image_;
  cv::Mat evened_;
};

std::optional<Lattice> detect(const cv::Mat& image, int columns, int rows, const Attempt& attempt, bool larger) {
  cv::Mat scaled = image;
  if (attempt.scale < 1.0) cv::resize(image, scaled, {}, attempt.scale, attempt.scale, cv::INTER_AREA);
  std::vector<cv::Point2f> corners;
  cv::Mat meta;
  try {
    const int flags = attempt.flags | (larger ? cv::CALIB_CB_LARGER : 0);
    if (!cv::findChessboardCornersSB(scaled, {columns, rows}, corners, flags, meta)) return std::nullopt;
  } catch (const cv::Exception&) {
    return std::nullopt;  // images of a few pixels
  }
  Lattice out{larger ? meta.cols : columns, larger ? meta.rows : rows, {}};
  if (static_cast<std::size_t>(out.columns * out.rows) != corners.size()) return std::nullopt;
  // Centres of pixels are whole numbers in both images.
  for (const cv::Point2f& p : corners) {
    out.pixels.emplace_back((p.x + 0.5) / attempt.scale - 0.5, (p.y + 0.5) / attempt.scale - 0.5);
  }
  if (!out.is_regular()) return std::nullopt;
  return out;
}

double least_spacing(const Lattice& lattice) {
  double least = 1e9;
  for (int row = 0; row < lattice.rows; ++row) {
    for (int column = 0; column < lattice.columns; ++column) {
      const Eigen::Vector2d& p = lattice.at(column, row);
      if (column > 0) least = std::min(least, (p - lattice.at(column - 1, row)).norm());
      if (row > 0) least = std::min(least, (p - lattice.at(column, row - 1)).norm());
    }
  }
  return least;
}

// Places to a fraction of a pixel: the saddle points of the grey values.
void sharpen(const cv::Mat& image, Lattice& lattice) {
  std::vector<cv::Point2f> corners;
  for (const Eigen::Vector2d& p : lattice.pixels) {
    corners.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  const int half = std::clamp(static_cast<int>(0.3 * least_spacing(lattice)), 2, 11);
  cv::cornerSubPix(image, corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 0.001});
  for (std::size_t k = 0; k < corners.size(); ++k) lattice.pixels[k] = {corners[k].x, corners[k].y};
}

// Whether the squares between the corners are dark and bright in turn, clearly and all of them: noise joins to lattices
// as well.
bool is_checkered(const Lattice& lattice, const cv::Mat& image) {
  std::vector<double> greys[2];
  for (int row = 0; row + 1 < lattice.rows; ++row) {
    for (int column = 0; column + 1 < lattice.columns; ++column) {
      const Eigen::Vector2d p = lattice.middle(column, row);
      const int x = std::clamp(static_cast<int>(std::lround(p.x())), 0, image.cols - 1);
      const int y = std::clamp(static_cast<int>(std::lround(p.y())), 0, image.rows - 1);
      greys[(column + row) % 2].push_back(image.at<std::uint8_t>(y, x));
    }
  }
  double mean[2] = {0.0, 0.0};
  for (int k = 0; k < 2; ++k) {
    for (const double grey : greys[k]) mean[k] += grey / static_cast<double>(greys[k].size());
  }
  if (std::abs(mean[0] - mean[1]) < least_board_contrast) return false;
  std::size_t right = 0;
  for (int k = 0; k < 2; ++k) {
    for (const double grey : greys[k]) right += std::abs(grey - mean[k]) < std::abs(grey - mean[1 - k]) ? 1 : 0;
  }
  return static_cast<double>(right) > 0.85 * static_cast<double>(greys[0].size() + greys[1].size());
}

// `quick`: by the first attempt alone, which does for boards beside one that was found.
std::optional<Lattice> detect_whole(const cv::Mat& image, int columns, int rows, bool quick) {
  std::vector<Attempt> attempts = attempts_for(image);
  if (quick) attempts.resize(1);
  Lights lights(image);
  for (const Attempt& attempt : attempts) {
    const cv::Mat& lit = lights.of(attempt);
    std::optional<Lattice> found = detect(lit, columns, rows, attempt, false);
    if (!found || !is_checkered(*found, lit)) continue;
    sharpen(image, *found);
    return found;
  }
  return std::nullopt;
}

// Mean grey value of the squares of one colour less the other's: positive where the first square is bright.
double first_is_brighter(const Lattice& lattice, const cv::Mat& image) {
  double sum = 0.0;
  for (int row = 0; row + 1 < lattice.rows; ++row) {
    for (int column = 0; column + 1 < lattice.columns; ++column) {
      const Eigen::Vector2d p = lattice.middle(column, row);
      const int x = std::clamp(static_cast<int>(std::lround(p.x())), 0, image.cols - 1);
      const int y = std::clamp(static_cast<int>(std::lround(p.y())), 0, image.rows - 1);
      sum += ((column + row) % 2 == 0 ? 1.0 : -1.0) * image.at<std::uint8_t>(y, x);
    }
  }
  return sum;
}

void turn_by_half(Lattice& lattice) { std::reverse(lattice.pixels.begin(), lattice.pixels.end()); }

// So that the square next to the first corner, inwards, is dark where turning the board shows which it is.
ImageBoard whole_board(Lattice lattice, const BoardModel& board, const cv::Mat& image) {
  lattice.make_right_handed();
  const bool tells = (board.columns() + board.rows()) % 2 != 0;
  if (tells && first_is_brighter(lattice, image) > 0.0) turn_by_half(lattice);
  ImageBoard out;
  out.pixels = lattice.pixels;
  for (int id = 0; id < board.corner_count(); ++id) out.ids.push_back(id);
  out.alternatives = board.pattern_turns();
  if (board.columns() == board.rows() && !tells && board.columns() % 2 != 0 &&
      first_is_brighter(lattice, image) > 0.0) {
    // A quarter turn changes the colours: which corner is the first is told but for half a turn.
    Lattice turned = lattice;
    turned.swap_axes();
    turned.turn_columns();
    out.pixels = turned.pixels;
  }
  return out;
}

// All places of a part on the board: by every quarter turn after which it fits. The detector gives a part's rows along
// the board's columns as well as along its rows.
ImageBoard part_of_board(Lattice lattice, const BoardModel& board, const cv::Mat& image) {
  lattice.make_right_handed();
  if (lattice.columns > board.columns() || lattice.rows > board.rows()) {
    lattice.swap_axes();
    lattice.make_right_handed();
  }
  ImageBoard out;
  out.whole = false;
  out.pixels = lattice.pixels;
  for (int row = 0; row < lattice.rows; ++row) {
    for (int column = 0; column < lattice.columns; ++column) out.ids.push_back(row * board.columns() + column);
  }
  // The colour convention of whole boards: the square next to the first corner is dark, unless turning hides it.
  const bool tells = (board.columns() + board.rows()) % 2 != 0;
  const bool is_bright = first_is_brighter(lattice, image) > 0.0;
  const auto middle_of = [&](int column, int row, int columns, int rows) -> Vector3d {
    return 0.5 * (board.lattice(column, row) + board.lattice(column + columns - 1, row + rows - 1));
  };
  const Vector3d first_square = middle_of(0, 0, 2, 2);
  const SE3 from_middle{Matrix3d::Identity(), -middle_of(0, 0, lattice.columns, lattice.rows)};
  for (int quarters = 0; quarters < 4; ++quarters) {
    const SE3 turn = SE3{exp_so3({0.0, 0.0, 0.5 * pi * quarters}), Vector3d::Zero()} * from_middle;
    const int columns = quarters % 2 == 0 ? lattice.columns : lattice.rows;
    const int rows = quarters % 2 == 0 ? lattice.rows : lattice.columns;
    for (int dy = 0; dy + rows <= board.rows(); ++dy) {
      for (int dx = 0; dx + columns <= board.columns(); ++dx) {
        const SE3 place = SE3{Matrix3d::Identity(), middle_of(dx, dy, columns, rows)} * turn;
        const Vector3d square = place * first_square;
        if (tells && (board.colour_at(square.x(), square.y(), 0.0) > 0) == is_bright) continue;
        out.alternatives.push_back(place.inverse());
      }
    }
  }
  return out;
}

std::optional<ImageBoard> find_part(const cv::Mat& image, const BoardModel& board) {
  const auto fits = [&](int columns, int rows) { return columns <= board.columns() && rows <= board.rows(); };
  std::optional<Lattice> best;
  for (const Attempt& attempt : attempts_for(image)) {
    if (attempt.evened) continue;  // parts of clutter look like parts of boards then
    const std::optional<Lattice> lattice = detect(image, least_part, least_part, attempt, true);
    if (!lattice || !is_checkered(*lattice, image)) continue;
    if (!fits(lattice->columns, lattice->rows) && !fits(lattice->rows, lattice->columns)) continue;
    if (!best || lattice->pixels.size() > best->pixels.size()) best = lattice;
  }
  if (!best) return std::nullopt;
  sharpen(image, *best);
  if (static_cast<int>(best->pixels.size()) == board.corner_count() && best->columns == board.columns()) {
    return whole_board(*best, board, image);
  }
  ImageBoard part = part_of_board(*best, board, image);
  if (part.alternatives.empty()) return std::nullopt;
  return part;
}

// What has been found is not found again.
void paint_over(const ImageBoard& board, cv::Mat& image) {
  std::vector<cv::Point> outline;
  cv::Point2f middle(0.0F, 0.0F);
  std::vector<cv::Point2f> all;
  for (const Eigen::Vector2d& p : board.pixels) all.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  std::vector<cv::Point2f> hull;
  cv::convexHull(all, hull);
  for (const cv::Point2f& p : all) middle += p * (1.0F / static_cast<float>(all.size()));
  for (const cv::Point2f& p : hull) outline.push_back(middle + (p - middle) * 1.1F);
  cv::fillConvexPoly(image, outline, cv::Scalar(128));
}

bool near_border(const ImageBoard& part, const cv::Mat& image, double reach) {
  return std::any_of(part.pixels.begin(), part.pixels.end(), [&](const Eigen::Vector2d& p) {
    return p.x() < reach || p.y() < reach || p.x() > image.cols - 1 - reach || p.y() > image.rows - 1 - reach;
  });
}

}  // namespace

ImageBoards find_image_boards(const GreyImage& grey, const BoardModel& board, int most) {
  if (board.has_markers()) return find_charuco_board(grey, board);
  ImageBoards out;
  cv::Mat image = bytes_of(grey);
  while (static_cast<int>(out.boards.size()) < most) {
    const std::optional<Lattice> lattice = detect_whole(image, board.columns(), board.rows(), !out.boards.empty());
    if (!lattice) break;
    out.boards.push_back(whole_board(*lattice, board, image));
    paint_over(out.boards.back(), image);
  }
  if (!out.boards.empty()) return out;
  const std::optional<ImageBoard> part = find_part(image, board);
  if (part && part->whole) {
    out.boards.push_back(*part);
    return out;
  }
  if (!part) {
    out.why_none = "no checkerboard of " + std::to_string(board.columns()) + " by " + std::to_string(board.rows()) +
                   " inner corners in it";
    return out;
  }
  const double side = (part->pixels[1] - part->pixels[0]).norm();
  out.why_none = std::string(near_border(*part, image, 2.5 * side) ? "the board is cut by the image border"
                                                                   : "the board is partly hidden") +
                 ": " + std::to_string(part->ids.size()) + " of its " + std::to_string(board.corner_count()) +
                 " inner corners are seen";
  out.boards.push_back(*part);
  return out;
}

}  // namespace rigcal
