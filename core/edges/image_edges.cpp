#include "core/edges/image_edges.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/median.h"
#include "core/edges/image_filter.h"

namespace rigcal {
namespace {

constexpr double blur_px = 1.2;      // Sigma at which the gradient is taken.
constexpr double low_sigmas = 3.0;   // An edge goes on where the gradient is above so much noise,
constexpr double high_sigmas = 8.0;  // and is one if it is above so much somewhere.
// Likewise at least, in grey values a pixel: what is smaller is no edge of a surface.
constexpr double min_gradient = 0.75;
constexpr int min_chain_px = 20;  // Shorter ones are clutter.
constexpr int fit_px = 6;         // Position and normal are those of a line through so many neighbours on either side.

using Eigen::Vector2d;
using Eigen::Vector2f;

constexpr int least_side = 16;

// Sums over some points of a chain.
struct ChainSums {
  Vector2d p = Vector2d::Zero();
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  double count = 0.0;

  ChainSums() = default;
  explicit ChainSums(const Vector2d& at)
      : p(at), xx(at.x() * at.x()), xy(at.x() * at.y()), yy(at.y() * at.y()), count(1.0) {}
  ChainSums operator+(const ChainSums& o) const { return ChainSums(*this, o, 1.0); }
  ChainSums operator-(const ChainSums& o) const { return ChainSums(*this, o, -1.0); }

  // The direction of least scatter: half the angle of (xx - yy, 2 xy), a quarter turn on.
  [[nodiscard]] Vector2d normal(const Vector2d& mean) const {
    const double twice_xy = 2.0 * (xy - count * mean.x() * mean.y());
    const double difference = xx - yy - count * (mean.x() * mean.x() - mean.y() * mean.y());
    const double length = std::sqrt(difference * difference + twice_xy * twice_xy);
    if (!(length > 0.0)) return {0.0, 1.0};
    if (difference >= 0.0) {
      const double cosine = std::sqrt(0.5 * (1.0 + difference / length));
      return {-0.5 * twice_xy / (length * cosine), cosine};
    }
    const double sine = std::copysign(std::sqrt(0.5 * (1.0 - difference / length)), twice_xy);
    return {-sine, 0.5 * twice_xy / (length * sine)};
  }

 private:
  ChainSums(const ChainSums& a, const ChainSums& b, double sign)
      : p(a.p + sign * b.p),
        xx(a.xx + sign * b.xx),
        xy(a.xy + sign * b.xy),
        yy(a.yy + sign * b.yy),
        count(a.count + sign * b.count) {}
};

class EdgeFinder {
 public:
  explicit EdgeFinder(const GreyImage& image) : gradients_(gradient_of(image, blur_px)) {
    const double noise = gradient_noise();
    low_ = static_cast<float>(std::max(min_gradient, low_sigmas * noise));
    high_ = static_cast<float>(std::max(2.0 * min_gradient, high_sigmas * noise));
  }

  std::vector<ImageEdge> run() {
    find_maxima();
    std::vector<ImageEdge> out;
    int chains = 0;
    for (std::size_t i = 0; i < maxima_.size(); ++i) {
      if (maxima_[i].used || maxima_[i].strength < high_) continue;
      const std::vector<int> chain = trace(static_cast<int>(i));
      if (static_cast<int>(chain.size()) < min_chain_px) continue;
      add_chain(chain, chains++, out);
    }
    return out;
  }

 private:
  struct Maximum {
    Vector2f position;
    Vector2f normal;
    float strength = 0.0F;
    int x = 0;
    int y = 0;
    bool used = false;
  };

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(gradient_.width) + static_cast<std::size_t>(x);
  }

  // Of one component: a fifth of any picture is calm, and there the length of the gradient is Rayleigh distributed.
  [[nodiscard]] double gradient_noise() const {
    std::vector<float> values;
    values.reserve(gradient_.values.size() / 7 + 1);
    for (std::size_t i = 0; i < gradient_.values.size(); i += 7) values.push_back(gradient_.values[i]);
    return of_rank(values, values.size() / 5) / std::sqrt(-2.0 * std::log(0.8));
  }

  [[nodiscard]] float interpolated(float x, float y) const {
    const int x0 = static_cast<int>(x);
    const int y0 = static_cast<int>(y);
    const float fx = x - static_cast<float>(x0);
    const float fy = y - static_cast<float>(y0);
    const float top = (1.0F - fx) * gradient_.at(x0, y0) + fx * gradient_.at(x0 + 1, y0);
    const float bottom = (1.0F - fx) * gradient_.at(x0, y0 + 1) + fx * gradient_.at(x0 + 1, y0 + 1);
    return (1.0F - fy) * top + fy * bottom;
  }

  void find_maxima() {
    at_.assign(gradient_.values.size(), -1);
    // At the border the gradient is of what was made up beyond it.
    const int margin = 2 + static_cast<int>(std::ceil(2.0 * blur_px));
    for (int y = margin; y < gradient_.height - margin; ++y) {
      for (int x = margin; x < gradient_.width - margin; ++x) {
        const float m = gradient_.at(x, y);
        if (m < low_) continue;
        const Vector2f n(gradients_.x.at(x, y) / m, gradients_.y.at(x, y) / m);
        const auto px = static_cast<float>(x);
        const auto py = static_cast<float>(y);
        const float before = interpolated(px - n.x(), py - n.y());
        const float after = interpolated(px + n.x(), py + n.y());
        if (m < before || m <= after) continue;
        const float curvature = before - 2.0F * m + after;
        const float shift = curvature < 0.0F ? std::clamp(0.5F * (before - after) / curvature, -0.7F, 0.7F) : 0.0F;
        at_[index(x, y)] = static_cast<int>(maxima_.size());
        maxima_.push_back({Vector2f(px, py) + shift * n, n, m, x, y, false});
      }
    }
  }

  // The free neighbour that goes on best in the direction (+1 or -1 along the edge); -1: the edge ends.
  [[nodiscard]] int next(const Maximum& from, float sign) const {
    const Vector2f along = sign * Vector2f(-from.normal.y(), from.normal.x());
    int best = -1;
    float best_score = 0.0F;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int i = at_[index(from.x + dx, from.y + dy)];
        if (i < 0 || maxima_[static_cast<std::size_t>(i)].used) continue;
        const Maximum& to = maxima_[static_cast<std::size_t>(i)];
        const float same_way = from.normal.dot(to.normal);
        const Vector2f step = to.position - from.position;
        const float length = step.norm();
        if (same_way < 0.85F || length < 1e-3F || along.dot(step) < 0.5F * length) continue;
        const float score = same_way + along.dot(step) / length;
        if (score > best_score) {
          best_score = score;
          best = i;
        }
      }
    }
    return best;
  }

  std::vector<int> trace(int start) {
    std::vector<int> forwards;
    std::vector<int> backwards;
    maxima_[static_cast<std::size_t>(start)].used = true;
    for (const float sign : {1.0F, -1.0F}) {
      std::vector<int>& side = sign > 0.0F ? forwards : backwards;
      for (int at = next(maxima_[static_cast<std::size_t>(start)], sign); at >= 0;
           at = next(maxima_[static_cast<std::size_t>(at)], sign)) {
        maxima_[static_cast<std::size_t>(at)].used = true;
        side.push_back(at);
      }
    }
    std::vector<int> chain(backwards.rbegin(), backwards.rend());
    chain.push_back(start);
    chain.insert(chain.end(), forwards.begin(), forwards.end());
    return chain;
  }

  void add_chain(const std::vector<int>& chain, int number, std::vector<ImageEdge>& out) {
    // Sums from the chain's beginning on: those over any part of it are differences.
    const Vector2d origin = position(chain.front());
    sums_.assign(1, ChainSums{});
    for (const int i : chain) sums_.push_back(sums_.back() + ChainSums(position(i) - origin));
    const auto size = chain.size();
    const auto reach = static_cast<std::size_t>(fit_px);
    for (std::size_t i = 0; i < size; ++i) {
      const Maximum& m = maxima_[static_cast<std::size_t>(chain[i])];
      const std::size_t first = i > reach ? i - reach : 0;
      const std::size_t end = std::min(size, i + reach + 1);
      const ChainSums part = sums_[end] - sums_[first];
      const Vector2d mean = part.p / static_cast<double>(end - first);
      Vector2d normal = part.normal(mean);
      if (normal.dot(m.normal.cast<double>()) < 0.0) normal = -normal;
      const Vector2d p = m.position.cast<double>();
      const double off = normal.dot(p - origin - mean);
      out.push_back({(p - off * normal).cast<float>(), normal.cast<float>(), number});
    }
  }

  [[nodiscard]] Vector2d position(int maximum) const {
    return maxima_[static_cast<std::size_t>(maximum)].position.cast<double>();
  }

  ImageGradient gradients_;
  const GreyImage& gradient_ = gradients_.length;
  float low_ = 0.0F;
  float high_ = 0.0F;
  std::vector<Maximum> maxima_;
  std::vector<int> at_;  // of each pixel: its maximum, or -1
  std::vector<ChainSums> sums_;
};

}  // namespace

std::vector<ImageEdge> find_image_edges(const GreyImage& image) {
  if (image.width < least_side || image.height < least_side) return {};
  return EdgeFinder(image).run();
}

GreyImage blurred(const GreyImage& image, double sigma_px) {
  if (image.width < 1 || image.height < 1 || sigma_px <= 0.0) return image;
  return correlated(image, gaussian(sigma_px));
}

}  // namespace rigcal
