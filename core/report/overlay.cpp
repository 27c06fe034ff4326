#include "core/report/overlay.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/camera/depth_buffer.h"
#include "core/camera/sample_blocks.h"
#include "core/camera/sightings.h"
#include "core/io/jpeg_file.h"

namespace rigcal {
namespace {

constexpr double edge_stroke_m = 0.025;  // as far apart as samples of an edge lie
constexpr double fine_px = 16.0;         // OpenCV draws at fractions of a pixel: four bits
constexpr double font_scale = 0.45;
constexpr double brightest = 165.0;         // of the image itself
constexpr float min_spread = 8.0F;          // what varies less is shown as it is
constexpr std::size_t counting_stride = 8;  // of the samples that hide edges which are only counted

cv::Scalar scalar(const Rgb& rgb) { return {double(rgb[0]), double(rgb[1]), double(rgb[2])}; }

// A picture under a strip of text; pixels of the image are mapped to it.
class Canvas {
 public:
  Canvas(const GreyImage& grey, OverlayWindow window) : window_(window) {
    if (window_.width <= 0 || window_.height <= 0) window_ = {0, 0, grey.width, grey.height, window.scale};
    const int columns = std::max(1, static_cast<int>(std::lround(window_.width * window_.scale)));
    const int rows = std::max(1, static_cast<int>(std::lround(window_.height * window_.scale)));
    picture_.width = columns;
    picture_.height = rows + overlay_legend_rows;
    picture_.channels = 3;
    picture_.bytes.assign(picture_.row_bytes() * static_cast<std::size_t>(picture_.height), 0);
    all_ = cv::Mat(picture_.height, columns, CV_8UC3, picture_.bytes.data());
    image_ = all_.rowRange(overlay_legend_rows, picture_.height);
    fill(grey);
  }

  [[nodiscard]] cv::Point2d to_picture(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() - window_.x + 0.5) * window_.scale - 0.5, (pixel.y() - window_.y + 0.5) * window_.scale - 0.5};
  }
  [[nodiscard]] bool shows(const Eigen::Vector2d& pixel) const {
    const cv::Point2d p = to_picture(pixel);
    return p.x > -1.0 && p.y > -1.0 && p.x < image_.cols && p.y < image_.rows;
  }
  void stroke(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Rgb& rgb, int thickness) {
    cv::line(image_, fine(a), fine(b), scalar(rgb), thickness, cv::LINE_AA, 4);
  }
  void dot(const Eigen::Vector2d& pixel, const Rgb& rgb, int side) {
    const cv::Point2d p = to_picture(pixel);
    const cv::Rect square(static_cast<int>(std::lround(p.x)) - side / 2, static_cast<int>(std::lround(p.y)) - side / 2,
                          side, side);
    image_(square & cv::Rect(0, 0, image_.cols, image_.rows)).setTo(scalar(rgb));
  }
  /// Text in the strip, behind what stands there already.
  void write(const std::string& text, const Rgb& rgb = {255, 255, 255}) {
    cv::putText(all_, text, {text_x_, overlay_legend_rows - 8}, cv::FONT_HERSHEY_SIMPLEX, font_scale, scalar(rgb), 1,
                cv::LINE_AA);
    int below = 0;
    text_x_ += cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, font_scale, 1, &below).width + 14;
  }
  void swatch(const Rgb& rgb) {
    const cv::Rect square(text_x_, 8, 10, 10);
    all_(square & cv::Rect(0, 0, all_.cols, all_.rows)).setTo(scalar(rgb));
    text_x_ += 14;
  }
  [[nodiscard]] double scale() const { return window_.scale; }
  [[nodiscard]] Image take() { return std::move(picture_); }

 private:
  // Dimmed, so that what is drawn stands out on white walls, too, and stretched, so that dark images show something.
  void fill(const GreyImage& grey) {
    const cv::Rect part = cv::Rect(window_.x, window_.y, window_.width, window_.height);
    const cv::Rect inside = part & cv::Rect(0, 0, grey.width, grey.height);
    if (inside.empty()) return;
    // OpenCV has no views of what may only be read.
    const cv::Mat values(grey.height, grey.width, CV_32F, const_cast<float*>(grey.values.data()));
    std::vector<float> greys = grey.values;
    const float low = quantile(greys, 0.01);
    const float high = quantile(greys, 0.99);
    const bool stretches = high - low >= min_spread;
    const double gain = stretches ? brightest / (high - low) : brightest / 255.0;
    cv::Mat cut(part.height, part.width, CV_32F, cv::Scalar(stretches ? low : 0.0F));
    values(inside).copyTo(cut(cv::Rect(inside.x - part.x, inside.y - part.y, inside.width, inside.height)));
    cv::Mat sized;
    cv::resize(cut, sized, image_.size(), 0.0, 0.0, window_.scale < 1.0 ? cv::INTER_AREA : cv::INTER_NEAREST);
    sized.convertTo(sized, CV_32F, gain, stretches ? -gain * low : 0.0);
    cv::max(cv::min(sized, brightest), 0.0, sized);
    if (stretches) lighten(gain * (quantile(greys, 0.5) - low), sized);
    sized.convertTo(sized, CV_8U);
    cv::cvtColor(sized, image_, cv::COLOR_GRAY2RGB);
  }
  // Under a bright sky all else is dark: a curve lifts what has the median value.
  static void lighten(double median, cv::Mat& values) {
    constexpr double wanted = 0.4;
    constexpr double strongest = 0.4;
    const double share = std::clamp(median / brightest, 1e-3, 0.999);
    const double power = std::max(std::log(wanted) / std::log(share), strongest);
    if (power >= 1.0) return;
    cv::pow(values / brightest, power, values);
    values *= brightest;
  }
  [[nodiscard]] cv::Point fine(const Eigen::Vector2d& pixel) const {
    const cv::Point2d p = to_picture(pixel);
    return {static_cast<int>(std::lround(fine_px * p.x)), static_cast<int>(std::lround(fine_px * p.y))};
  }

  OverlayWindow window_;
  Image picture_;
  cv::Mat all_;    ///< Of the picture's bytes,
  cv::Mat image_;  ///< and without the strip.
  int text_x_ = 8;
};

// Calls `take(edge, pixel)` for every sample of an edge that is in the image and not hidden.
template <class Take>
void for_seen_edges(const CameraModel& model, const CameraScene& scene, const SE3& T_C_G, const Take& take,
                    std::size_t stride = 1) {
  DepthBufferOptions options;
  options.stride = stride;
  const DepthBuffer depth(model, T_C_G, scene.samples, scene.blocks, options);
  for (const LidarEdge& edge : scene.edges) {
    const Vector3d p_C = T_C_G * edge.p_G;
    const auto pixel = model.project(p_C);
    if (pixel && model.contains(*pixel) && depth.sees(*pixel, p_C.norm(), edge)) take(edge, *pixel);
  }
}

void draw_edges_at(const CameraModel& model, const CameraScene& scene, const SE3& T_C_G, const Rgb& rgb,
                   Canvas& canvas) {
  const int thickness = canvas.scale() >= 3.0 ? 2 : 1;
  for_seen_edges(model, scene, T_C_G, [&](const LidarEdge& edge, const Eigen::Vector2d& pixel) {
    const Vector3d half = 0.5 * edge_stroke_m * edge.direction_G;
    const auto a = model.project(T_C_G * (edge.p_G - half));
    const auto b = model.project(T_C_G * (edge.p_G + half));
    if (a && b && canvas.shows(pixel)) canvas.stroke(*a, *b, rgb, thickness);
  });
}

// Dark blue to yellow, evenly brighter: the map "viridis" (van der Walt and Smith 2015, given to the public), coarsely.
Rgb shade(double share) {
  constexpr std::array<Rgb, 6> colours{
      {{68, 1, 84}, {64, 67, 135}, {41, 120, 142}, {34, 168, 132}, {122, 209, 81}, {253, 231, 37}}};
  const double at = std::clamp(share, 0.0, 1.0) * (colours.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(at), colours.size() - 2);
  const double f = at - static_cast<double>(k);
  Rgb out{};
  for (std::size_t c = 0; c < 3; ++c)
    out[c] = static_cast<std::uint8_t>(std::lround((1.0 - f) * colours[k][c] + f * colours[k + 1][c]));
  return out;
}

struct Dot {
  Eigen::Vector2d pixel;
  double range_m = 0.0;
  double value = 0.0;
};

void write_scale(MapColour colour, const std::array<float, 2>& spread, Canvas& canvas) {
  const bool range = colour == MapColour::range;
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), range ? "%.1f m" : "reflectivity %.0f",
                range ? std::exp(spread[0]) : spread[0]);
  canvas.write(text.data());
  for (int k = 0; k <= 6; ++k) canvas.swatch(shade(k / 6.0));
  std::snprintf(text.data(), text.size(), range ? "%.1f m" : "%.0f", range ? std::exp(spread[1]) : spread[1]);
  canvas.write(text.data());
}

}  // namespace

Image draw_edges(const GreyImage& grey, const CameraModel& model, const CameraScene& scene, const OverlayPoses& poses,
                 const std::string& title, const OverlayWindow& window) {
  Canvas canvas(grey, window);
  canvas.write(title);
  canvas.write("LiDAR edges:");
  if (poses.guess_T_C_G) {
    draw_edges_at(model, scene, *poses.guess_T_C_G, guess_rgb, canvas);
    canvas.swatch(guess_rgb);
    canvas.write("at the guess", guess_rgb);
  }
  if (poses.T_C_G) {
    draw_edges_at(model, scene, *poses.T_C_G, result_rgb, canvas);
    canvas.swatch(result_rgb);
    canvas.write("at the result", result_rgb);
  }
  return canvas.take();
}

Image draw_map(const GreyImage& grey, const CameraModel& model, const CameraScene& scene, const SE3& T_C_G,
               MapColour colour, const std::string& title, const OverlayWindow& window) {
  Canvas canvas(grey, window);
  const DepthBuffer depth(model, T_C_G, scene.samples, scene.blocks);
  std::vector<Dot> dots;
  const ViewCone cone(T_C_G, model);
  for_each_run(scene.samples.size(), scene.blocks, cone, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const MapSample& sample = scene.samples[k];
      const Vector3d p_C = T_C_G * sample.p_G.cast<double>();
      const auto pixel = model.project(p_C);
      if (!pixel || !canvas.shows(*pixel) || !depth.sees(*pixel, p_C.norm(), sample)) continue;
      const double value =
          colour == MapColour::range ? std::log(std::max(p_C.norm(), 1e-3)) : double(sample.reflectivity);
      dots.push_back({*pixel, p_C.norm(), value});
    }
  });
  // Near ones lie on top.
  std::stable_sort(dots.begin(), dots.end(), [](const Dot& a, const Dot& b) { return a.range_m > b.range_m; });
  std::vector<float> values;
  for (const Dot& dot : dots) values.push_back(static_cast<float>(dot.value));
  if (values.empty()) values = {0.0F};
  const std::array<float, 2> spread{quantile(values, 0.02), quantile(values, 0.98)};
  const double width = std::max(double{spread[1] - spread[0]}, 1e-9);
  const int side = std::max(2, static_cast<int>(std::lround(2.0 * canvas.scale())));
  for (const Dot& dot : dots) canvas.dot(dot.pixel, shade((dot.value - spread[0]) / width), side);
  canvas.write(title);
  canvas.write("LiDAR map:");
  write_scale(colour, spread, canvas);
  return canvas.take();
}

std::vector<std::size_t> choose_views(const CameraScene& scene, const CameraTask& camera, const CameraModel& model,
                                      const SE3& T_base_camera, std::size_t count) {
  struct Candidate {
    std::size_t view = 0;
    std::size_t edges = 0;
    Vector3d axis_G = Vector3d::UnitZ();
  };
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < camera.views.size(); ++k) {
    if (is_usable(scene, camera.intrinsics, camera.views[k])) candidates.push_back({k, 0, Vector3d::UnitZ()});
  }
  parallel_for(candidates.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      Candidate& candidate = candidates[k];
      const SE3 T_G_C = scene.T_G_base[static_cast<std::size_t>(camera.views[candidate.view].stop)] * T_base_camera;
      candidate.axis_G = T_G_C.R.col(2);
      for_seen_edges(
          model, scene, T_G_C.inverse(), [&](const LidarEdge&, const Eigen::Vector2d&) { ++candidate.edges; },
          counting_stride);
    }
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.edges > b.edges; });
  std::vector<Candidate> chosen;
  for (const double apart_rad : {to_rad(30.0), 0.0}) {
    for (const Candidate& candidate : candidates) {
      const bool is_new = std::none_of(chosen.begin(), chosen.end(), [&](const Candidate& c) {
        return camera.views[c.view].stop == camera.views[candidate.view].stop ||
               c.axis_G.dot(candidate.axis_G) > std::cos(apart_rad);
      });
      if (is_new && chosen.size() < count) chosen.push_back(candidate);
    }
  }
  std::vector<std::size_t> out;
  for (const Candidate& candidate : chosen) out.push_back(candidate.view);
  return out;
}

std::vector<Overlay> draw_overlays(const CameraScene& scene, const CameraTask& camera, const CameraEstimate& estimate,
                                   const OverlayBudget& budget) {
  const CameraModel model(estimate.found ? estimate.intrinsics : camera.intrinsics);
  std::optional<SE3> T_base_camera = camera.guess_T_base_camera;
  if (estimate.found) T_base_camera = estimate.pose.T_base_camera;
  if (!T_base_camera) return {};
  const std::vector<std::size_t> views = choose_views(scene, camera, model, *T_base_camera, budget.edge_views);
  // Of each view that of the edges, then that of the map.
  std::vector<std::optional<Overlay>> drawn(2 * views.size());
  parallel_for(drawn.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const bool of_map = k % 2 == 1;
      if (of_map && (k / 2 >= budget.map_views || !estimate.found)) continue;
      const CameraView& view = camera.views[views[k / 2]];
      const SE3 T_base_G = scene.T_G_base[static_cast<std::size_t>(view.stop)].inverse();
      OverlayPoses poses;
      if (camera.guess_T_base_camera) poses.guess_T_C_G = camera.guess_T_base_camera->inverse() * T_base_G;
      if (estimate.found) poses.T_C_G = T_base_camera->inverse() * T_base_G;
      OverlayWindow window;
      window.scale = std::min(1.0, static_cast<double>(budget.max_width) / view.grey.width);
      const Image picture = of_map
                                ? draw_map(view.grey, model, scene, *poses.T_C_G, MapColour::range, camera.name, window)
                                : draw_edges(view.grey, model, scene, poses, camera.name, window);
      auto jpeg = encode_jpeg(picture, budget.jpeg_quality);
      if (jpeg)
        drawn[k] = Overlay{camera.name, view.stop, of_map ? OverlayKind::map : OverlayKind::edges, std::move(*jpeg)};
    }
  });
  std::vector<Overlay> out;
  for (std::optional<Overlay>& overlay : drawn) {
    if (overlay) out.push_back(std::move(*overlay));
  }
  return out;
}

}  // namespace rigcal
