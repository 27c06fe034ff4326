#include "core/camera/stop_agreement.h"

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

// Poses beside: turned so that pixels move this far, farther than partners reach and than a pose is uncertain by, in so
// many directions each.
constexpr std::array beside_px{12.0, 20.0};
constexpr int directions = 8;

std::vector<CameraState> beside(const CameraIntrinsics& intrinsics, const CameraState& state) {
  std::vector<CameraState> others;
  for (std::size_t ring = 0; ring < beside_px.size(); ++ring) {
    for (int k = 0; k < directions; ++k) {
      const double direction = 2.0 * pi * (k + 0.5 * static_cast<double>(ring)) / directions;
      const Vector3d turn(std::cos(direction) / intrinsics.fy, std::sin(direction) / intrinsics.fx, 0.0);
      CameraState other = state;
      other.T_base_camera.R = state.T_base_camera.R * exp_so3(beside_px[ring] * turn);
      others.push_back(other);
    }
  }
  return others;
}

// Of one line.
struct ShownEdges {
  double segments = 0.0;
  double explained = 0.0;
  double by_chance = 0.0;

  [[nodiscard]] double more_than_chance() const { return explained - by_chance; }
  ShownEdges& operator+=(const ShownEdges& other) {
    segments += other.segments;
    explained += other.explained;
    by_chance += other.by_chance;
    return *this;
  }
  ShownEdges& operator-=(const ShownEdges& other) {
    segments -= other.segments;
    explained -= other.explained;
    by_chance -= other.by_chance;
    return *this;
  }
};

// What a view's images show of each line.
using ShownLines = std::map<int, ShownEdges>;

ShownLines shown_by(const CameraScene& scene, const EdgeView& view, const CameraModel& model, const CameraState& state,
                    std::span<const CameraState> others, const MatchOptions& options) {
  const SE3& T_G_base = scene.T_G_base[static_cast<std::size_t>(view.stop)];
  ShownLines lines;
  for (const EdgeSegment& segment : view.segments) lines[segment.line].segments += view.weight;
  for (const SegmentFit& fit : match_view(scene, view, camera_at(model, state, T_G_base), options)) {
    lines[fit.line].explained += view.weight * fit.explained();
  }
  const double share = view.weight / static_cast<double>(others.size());
  for (const CameraState& other : others) {
    for (const SegmentFit& fit : match_view(scene, view, camera_at(model, other, T_G_base), options)) {
      lines[fit.line].by_chance += share * fit.explained();
    }
  }
  return lines;
}

void add(const ShownLines& from, ShownLines& to) {
  for (const auto& [line, shown] : from) to[line] += shown;
}

ShownEdges sum_of(const ShownLines& lines) {
  ShownEdges sum;
  for (const auto& [line, shown] : lines) sum += shown;
  return sum;
}

// Less than this is left of a sum of weights when all of them are taken out again.
constexpr double no_segments = 1e-6;

// Stops that show less than so much of what is expected of them, where that is so many segments, are no witnesses of
// others: where images of a quarter of all stops are of a camera that was turned, little is expected of each of them
// else.
constexpr double least_of_witness = 0.4;
constexpr double least_expected_of_witness = 1.0;

// What all witnesses show.
class Witnesses {
 public:
  explicit Witnesses(const std::map<int, ShownLines>& stops) : stops_(stops) {
    for (const auto& [stop, lines] : stops) {
      called_.insert(stop);
      add(lines, lines_);
    }
    all_ = sum_of(lines_);
  }

  // A stop is no witness of itself.
  [[nodiscard]] double expected_of(int stop) const {
    const bool is_witness = called_.contains(stop);
    const double usual_share = all_.segments > no_segments ? all_.more_than_chance() / all_.segments : 0.0;
    double expected = 0.0;
    for (const auto& [line, shown] : stops_.at(stop)) {
      ShownEdges elsewhere = lines_.contains(line) ? lines_.at(line) : ShownEdges{};
      if (is_witness) elsewhere -= shown;
      const bool is_seen = elsewhere.segments > no_segments;
      const double share = is_seen ? elsewhere.more_than_chance() / elsewhere.segments : usual_share;
      expected += shown.segments * std::max(share, 0.0);
    }
    return expected;
  }

  // Dismisses those that show too little; false: there were none.
  bool dismiss() {
    std::vector<int> doubtful;
    for (const int stop : called_) {
      const double expected = expected_of(stop);
      const double shown = sum_of(stops_.at(stop)).more_than_chance();
      if (expected >= least_expected_of_witness && shown < least_of_witness * expected) doubtful.push_back(stop);
    }
    for (const int stop : doubtful) {
      called_.erase(stop);
      for (const auto& [line, shown] : stops_.at(stop)) {
        lines_.at(line) -= shown;
        all_ -= shown;
      }
    }
    return !doubtful.empty();
  }

 private:
  const std::map<int, ShownLines>& stops_;
  std::set<int> called_;
  ShownLines lines_;
  ShownEdges all_;
};

}  // namespace

std::vector<StopAgreement> agreement_of_stops(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                              const CameraState& state, const MatchOptions& options,
                                              std::span<const EdgeView> views) {
  const CameraModel model(changed(intrinsics, state));
  const std::vector<CameraState> others = beside(intrinsics, state);
  std::vector<ShownLines> of_view(views.size());
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) of_view[k] = shown_by(scene, views[k], model, state, others, options);
  });
  std::map<int, ShownLines> stops;
  for (std::size_t k = 0; k < views.size(); ++k) add(of_view[k], stops[views[k].stop]);
  Witnesses witnesses(stops);
  while (witnesses.dismiss()) {
  }
  std::vector<StopAgreement> sorted;
  for (const auto& [stop, lines] : stops) {
    const ShownEdges sum = sum_of(lines);
    sorted.push_back({stop, {}, sum.segments, sum.explained, sum.by_chance, witnesses.expected_of(stop)});
  }
  return sorted;
}

}  // namespace rigcal
