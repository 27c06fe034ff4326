#include "core/camera/edge_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/base/parallel.h"
#include "core/camera/edge_proximity.h"
#include "core/camera/probe_projection.h"

namespace rigcal {
namespace {

constexpr double reach_rad = to_rad(6.0);   // Rotations so far from the centre, about each axis,
constexpr double step_rad = to_rad(1.2);    // on a grid like this.
constexpr double apart_rad = to_rad(2.0);   // Minima that lie nearer are one.
constexpr int most_starts = 3;              // How many are wanted.
constexpr std::size_t most_samples = 3000;  // Of all views together, at most.

// Scale of the nearness: what a rotation half a step off and a translation off by some centimetres do to a pixel.
constexpr double scale_px = 8.0;

// The probes of one view: places of edges that it should show.
struct ViewProbes {
  std::size_t view = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

class Search {
 public:
  Search(const CameraScene& scene, const CameraIntrinsics& intrinsics, const SE3& centre, const EdgePriors& priors,
         const std::vector<EdgeView>& views, double finest_px)
      : model_(intrinsics), centre_(centre), priors_(priors), views_(views), finest_px_(finest_px) {
    set_scale(scale_px);
    choose_probes(scene, views);
  }

  [[nodiscard]] std::vector<SE3> run() {
    std::vector<Scored> grid = score_grid();
    std::vector<Scored> starts;
    for (const Scored& candidate : grid) {
      if (static_cast<int>(starts.size()) >= 2 * most_starts) break;
      if (is_new(candidate, starts)) starts.push_back(candidate);
    }
    climb_all(starts);
    for (double scale = 0.5 * scale_px; scale >= finest_px_; scale *= 0.5) {
      set_scale(scale);
      climb_all(starts);
    }
    std::stable_sort(starts.begin(), starts.end(), better);
    std::vector<Scored> distinct;
    for (const Scored& candidate : starts) {
      if (static_cast<int>(distinct.size()) >= most_starts) break;
      if (is_new(candidate, distinct)) distinct.push_back(candidate);
    }
    std::vector<SE3> out;
    for (const Scored& start : distinct) out.push_back(centre_ * SE3::exp(start.xi));
    return out;
  }

 private:
  struct Scored {
    Vector6d xi = Vector6d::Zero();  // centre exp(xi)
    double score = 0.0;
  };
  static bool better(const Scored& a, const Scored& b) { return a.score > b.score; }

  [[nodiscard]] bool is_new(const Scored& candidate, const std::vector<Scored>& among) const {
    return std::none_of(among.begin(), among.end(), [&](const Scored& other) {
      return (other.xi.head<3>() - candidate.xi.head<3>()).norm() < apart_rad;
    });
  }

  void set_scale(double px) {
    proximity_.assign(views_.size(), EdgeProximity(0, 0, EdgeIndex(), px));
    parallel_for(views_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        proximity_[k] = EdgeProximity(model_.intrinsics().width, model_.intrinsics().height, views_[k].index, px);
      }
    });
    first_step_ = px / scale_px;
  }

  void climb_all(std::vector<Scored>& starts) const {
    parallel_for(starts.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) climb(starts[k]);
    });
  }

  void choose_probes(const CameraScene& scene, const std::vector<EdgeView>& views) {
    std::size_t all = 0;
    for (const EdgeView& view : views) all += view.samples.size();
    const std::size_t every = std::max<std::size_t>(1, (all + most_samples - 1) / most_samples);
    const SE3 T_C_base = centre_.inverse();
    for (std::size_t k = 0; k < views.size(); ++k) {
      const EdgeView& view = views[k];
      of_view_.push_back({k, points_.size(), 0});
      const SE3 T_C_G = T_C_base * scene.T_G_base[static_cast<std::size_t>(view.stop)].inverse();
      for (const EdgeSegment& segment : view.segments) {
        const std::size_t first = points_.size();
        for (std::uint32_t i = segment.begin; i < segment.end; i += static_cast<std::uint32_t>(every)) {
          const LidarEdge& edge = scene.edges[view.samples[i]];
          const Vector3d p = T_C_G * edge.p_G;
          points_.add(p, p + 0.01 * p.norm() * (T_C_G.R * edge.direction_G));
        }
        const auto count = static_cast<double>(points_.size() - first);
        // A line that is seen along more of the image says more, but not in proportion.
        const double worth = view.weight * std::sqrt(static_cast<double>(segment.end - segment.begin));
        weights_.resize(points_.size(), static_cast<float>(worth / count));
        total_ += worth;
      }
      of_view_.back().end = points_.size();
    }
  }

  // Mean nearness, 0 .. 1, less the prior.
  void score(std::span<Scored> candidates, ProbePoints::Pixels& pixels) const {
    for (Scored& candidate : candidates) candidate.score = 0.0;
    // View by view, as a view's nearness fits into a cache.
    for (const ViewProbes& probes : of_view_) {
      for (Scored& candidate : candidates) candidate.score += nearness(candidate, probes, pixels);
    }
    for (Scored& candidate : candidates) {
      const double off = candidate.xi.head<3>().squaredNorm() / std::pow(priors_.rotation_rad, 2) +
                         candidate.xi.tail<3>().squaredNorm() / std::pow(priors_.translation_m, 2);
      candidate.score = total_ > 0.0 ? candidate.score / total_ - 0.005 * off : 0.0;
    }
  }

  // The sum over one view's probes.
  [[nodiscard]] double nearness(const Scored& candidate, const ViewProbes& probes, ProbePoints::Pixels& pixels) const {
    points_.project(model_, SE3::exp(candidate.xi), probes.begin, probes.end, pixels);
    const float right = static_cast<float>(model_.intrinsics().width) - 1.0F;
    const float bottom = static_cast<float>(model_.intrinsics().height) - 1.0F;
    double sum = 0.0;
    for (std::size_t k = 0; k < probes.end - probes.begin; ++k) {
      const float x = pixels.x[k];
      const float y = pixels.y[k];
      if (!(x >= 0.0F && y >= 0.0F && x <= right && y <= bottom)) continue;
      const float near = proximity_[probes.view].at({x, y}, {pixels.along_x[k], pixels.along_y[k]});
      sum += static_cast<double>(weights_[probes.begin + k] * near);
    }
    return sum;
  }

  [[nodiscard]] std::vector<Scored> score_grid() const {
    const int half = static_cast<int>(std::round(reach_rad / step_rad));
    const int side = 2 * half + 1;
    std::vector<Scored> grid(static_cast<std::size_t>(side * side * side));
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const int k = static_cast<int>(i);
      grid[i].xi.head<3>() = step_rad * Vector3d(k % side - half, k / side % side - half, k / (side * side) - half);
    }
    parallel_for(grid.size(), 64, [&](std::size_t begin, std::size_t end) {
      ProbePoints::Pixels pixels;
      score(std::span(grid).subspan(begin, end - begin), pixels);
    });
    std::stable_sort(grid.begin(), grid.end(), better);
    return grid;
  }

  // Up and down along each parameter, with steps that get shorter.
  void climb(Scored& at) const {
    ProbePoints::Pixels pixels;
    score(std::span(&at, 1), pixels);
    for (double scale = first_step_; scale > 0.06 * first_step_; scale *= 0.5) {
      for (int round = 0; round < 3; ++round) {
        bool moved = false;
        for (int k = 0; k < 6; ++k) {
          const double step = scale * (k < 3 ? 0.5 * step_rad : 0.4 * priors_.translation_m);
          for (const double sign : {1.0, -1.0}) {
            Scored next = at;
            next.xi[k] += sign * step;
            score(std::span(&next, 1), pixels);
            if (next.score <= at.score) continue;
            at = next;
            moved = true;
            break;
          }
        }
        if (!moved) break;
      }
    }
  }

  CameraModel model_;
  SE3 centre_;
  const EdgePriors& priors_;
  const std::vector<EdgeView>& views_;
  double finest_px_;
  double first_step_ = 1.0;
  std::vector<EdgeProximity> proximity_;
  ProbePoints points_;          // in the camera at the centre of the search
  std::vector<float> weights_;  // of the points; all of a segment have one together
  std::vector<ViewProbes> of_view_;
  double total_ = 0.0;
};

}  // namespace

std::vector<SE3> search_edges(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                              const SE3& centre_T_base_camera, const EdgePriors& priors,
                              const std::vector<EdgeView>& views, double finest_px) {
  return Search(scene, intrinsics, centre_T_base_camera, priors, views, finest_px).run();
}

}  // namespace rigcal
