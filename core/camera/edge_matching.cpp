#include "core/camera/edge_matching.h"

#include <array>

namespace rigcal {
namespace {

constexpr double gate_rad = to_rad(15.0);  // Of a partner's direction, to the projected edge's.
constexpr double outlier = 0.1;            // The likelihood that clutter has everywhere.
constexpr double segment_px = 0.2;         // Sigma of a whole segment: shading, blur, fit.
constexpr double segment_m = 0.0005;       // What its stretch of the line is off in space by itself,
constexpr double line_m = 0.0015;          // and the whole line, in all images alike,
constexpr double line_per_m = 0.0003;      // and so much more for each metre of its range.
constexpr double kernel_sigmas = 1.0;      // Of Geman and McClure (1987) on a segment's mean offset.

// Neighbouring pixels of a chain are at most a diagonal apart, so one of them lies so near to any line across it.
constexpr float half_step_px = 0.75F;

class ViewMatcher {
 public:
  ViewMatcher(const CameraScene& scene, const EdgeView& view, const CameraAtStop& camera, const MatchOptions& options)
      : scene_(scene),
        view_(view),
        camera_(camera),
        options_(options),
        gate_px_(static_cast<float>(options.gate_px)),
        cos_gate_(static_cast<float>(std::cos(gate_rad))) {}

  [[nodiscard]] SegmentFit segment(const EdgeSegment& segment, std::vector<EdgeMatch>* matches) {
    SegmentFit fit;
    fit.line = segment.line;
    double px_per_m = 0.0;
    double range_m = 0.0;
    double shift_m = 0.0;
    double offsets = 0.0;
    for (std::uint32_t k = segment.begin; k < segment.end; ++k) {
      const std::uint32_t sample = view_.samples[k];
      const auto projection = project_edge(camera_, scene_.edges[sample]);
      // Where it stood out of the image nothing can be found.
      if (!projection || !camera_.model.contains(projection->pixel, border_px)) continue;
      ++fit.samples;
      px_per_m += projection->px_per_m;
      range_m += projection->range_m;
      shift_m += scene_.edges[sample].shift_m;
      find_candidates(*projection);
      weigh(*projection);
      double explained = 0.0;
      // Sums over the candidates, in pixels; what moves pixels comes in once.
      Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
      Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
      for (int c = 0; c < count_; ++c) {
        const Candidate& candidate = candidates_[static_cast<std::size_t>(c)];
        normal.noalias() += candidate.weight * candidate.normal * candidate.normal.transpose();
        gradient += candidate.weight * candidate.offset * candidate.normal;
        offsets += candidate.weight * candidate.offset;
        explained += candidate.weight;
        if (matches != nullptr) {
          matches->push_back({sample, candidate.position, candidate.normal, candidate.weight});
        }
      }
      if (count_ > 0) add_sums(*projection, normal, gradient, fit);
      fit.weight += explained;
      if (explained > 0.5) ++fit.matched;
    }
    if (fit.samples == 0) return fit;
    fit.offset_px = fit.weight > 0.0 ? offsets / fit.weight : 0.0;
    fit.sigma_px = std::hypot(segment_px, segment_m * px_per_m / fit.samples);
    // While partners are still sought far away, a segment may be as far off.
    fit.line_variance =
        std::pow(line_m, 2) + std::pow(line_per_m * range_m / fit.samples, 2) + std::pow(shift_m / fit.samples, 2);
    fit.expected_px = std::hypot(fit.sigma_px, std::sqrt(fit.line_variance) * px_per_m / fit.samples);
    const double normalised = fit.offset_px / (kernel_sigmas * std::hypot(fit.expected_px, options_.scale_px));
    fit.robust = 1.0 / std::pow(1.0 + normalised * normalised, 2);
    return fit;
  }

 private:
  struct Candidate {
    Eigen::Vector2d position;
    Eigen::Vector2d normal;
    double offset = 0.0;
    double beside = 0.0;  // how far from the line across
    double weight = 0.0;
    int chain = 0;
  };

  // So small, products are quicker where nothing is packed for them.
  static void add_sums(const EdgeProjection& projection, const Eigen::Matrix2d& normal, const Eigen::Vector2d& gradient,
                       SegmentFit& fit) {
    const Eigen::Matrix<double, camera_parameters, 2> weighted = projection.jacobian.transpose().lazyProduct(normal);
    fit.gradient.noalias() += projection.jacobian.transpose() * gradient;
    fit.normal += weighted.lazyProduct(projection.jacobian);
    fit.shift_gradient.noalias() += projection.by_world.transpose() * gradient;
    fit.shift_normal.noalias() += projection.by_world.transpose() * normal * projection.by_world;
    fit.mixed.noalias() += weighted * projection.by_world;
  }

  void find_candidates(const EdgeProjection& projection) {
    count_ = 0;
    const Eigen::Vector2d n = projection.normal;
    const Eigen::Vector2d reach =
        options_.gate_px * n.cwiseAbs() + Eigen::Vector2d::Constant(static_cast<double>(half_step_px));
    // Most of what is near does not lie on the line across: floats tell.
    const Eigen::Vector2f pixel = projection.pixel.cast<float>();
    const Eigen::Vector2f across = n.cast<float>();
    view_.index.around(projection.pixel, reach, [&](const ImageEdge& edge) {
      const Eigen::Vector2f off = edge.position - pixel;
      const float beside = std::abs(across.x() * off.y() - across.y() * off.x());
      if (beside > half_step_px || std::abs(across.dot(off)) > gate_px_) return;
      if (std::abs(across.dot(edge.normal)) < cos_gate_) return;
      const Eigen::Vector2d position = edge.position.cast<double>();
      const Eigen::Vector2d m = edge.normal.cast<double>();
      add({position, m, -m.dot(position - projection.pixel), static_cast<double>(beside), 0.0, edge.chain});
    });
  }

  // Of each chain the pixel next to the line across, or the line would count a chain twice.
  void add(const Candidate& candidate) {
    for (int c = 0; c < count_; ++c) {
      Candidate& other = candidates_[static_cast<std::size_t>(c)];
      if (other.chain != candidate.chain || (other.position - candidate.position).norm() > 2.0) continue;
      if (candidate.beside < other.beside) other = candidate;
      return;
    }
    if (count_ < static_cast<int>(candidates_.size())) candidates_[static_cast<std::size_t>(count_++)] = candidate;
  }

  void weigh(const EdgeProjection& projection) {
    const double variance = options_.scale_px * options_.scale_px + projection.sigma_px * projection.sigma_px;
    double sum = outlier;
    for (int c = 0; c < count_; ++c) {
      Candidate& candidate = candidates_[static_cast<std::size_t>(c)];
      candidate.weight = std::exp(-0.5 * candidate.offset * candidate.offset / variance);
      sum += candidate.weight;
    }
    for (int c = 0; c < count_; ++c) candidates_[static_cast<std::size_t>(c)].weight /= sum;
  }

  const CameraScene& scene_;
  const EdgeView& view_;
  const CameraAtStop& camera_;
  const MatchOptions& options_;
  float gate_px_;
  float cos_gate_;
  std::array<Candidate, 12> candidates_;  // more than fit a gate's width
  int count_ = 0;
};

}  // namespace

std::vector<SegmentFit> match_view(const CameraScene& scene, const EdgeView& view, const CameraAtStop& camera,
                                   const MatchOptions& options, std::vector<EdgeMatch>* matches) {
  ViewMatcher matcher(scene, view, camera, options);
  std::vector<SegmentFit> fits;
  fits.reserve(view.segments.size());
  for (const EdgeSegment& segment : view.segments) fits.push_back(matcher.segment(segment, matches));
  return fits;
}

}  // namespace rigcal
