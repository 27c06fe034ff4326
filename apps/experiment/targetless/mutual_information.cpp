#include "apps/experiment/targetless/mutual_information.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core/optim.hpp>

#include "core/base/parallel.h"
#include "core/base/seconds.h"
#include "core/camera/sightings.h"

namespace rigcal::targetless {
namespace {

constexpr int grey_bins = 32;
constexpr std::size_t most_sightings = 20000;
constexpr std::size_t least_sightings = 500;
constexpr double margin_px = -60.0;
constexpr std::size_t grain = 2048;

struct Level {
  double blur_px;
  double rotation_rad;
  double translation_m;
  int iterations;
};

// The simplex is as wide as these at first.
constexpr std::array<Level, 3> levels{
    {{6.0, to_rad(3.0), 0.06, 200}, {3.0, to_rad(1.0), 0.03, 150}, {1.0, to_rad(0.3), 0.01, 150}}};

// Counts of ranks by grey values.
struct Counts {
  std::array<double, static_cast<std::size_t>(reflectivity_ranks) * grey_bins> of{};

  Counts& operator+=(const Counts& other) {
    for (std::size_t k = 0; k < of.size(); ++k) of[k] += other.of[k];
    return *this;
  }

  // A grey value counts in the two bins that it lies between.
  void add(int rank, double grey) {
    const double place = std::clamp(grey / 255.0, 0.0, 1.0) * (grey_bins - 1);
    const int bin = std::min(static_cast<int>(place), grey_bins - 2);
    double* row = of.data() + static_cast<std::ptrdiff_t>(rank) * grey_bins + bin;
    row[0] += 1.0 - (place - bin);
    row[1] += place - bin;
  }

  // H(rank) + H(grey) - H(both), nats.
  [[nodiscard]] double information() const {
    std::array<double, reflectivity_ranks> ranks{};
    std::array<double, grey_bins> greys{};
    double total = 0.0;
    for (std::size_t k = 0; k < of.size(); ++k) {
      ranks[k / grey_bins] += of[k];
      greys[k % grey_bins] += of[k];
      total += of[k];
    }
    if (total < static_cast<double>(least_sightings)) return 0.0;
    const auto entropy = [&](const auto& counts) {
      double sum = 0.0;
      for (const double count : counts) sum -= count > 0.0 ? count / total * std::log(count / total) : 0.0;
      return sum;
    };
    return entropy(ranks) + entropy(greys) - entropy(of);
  }
};

double bilinear(const GreyImage& image, const Eigen::Vector2d& pixel) {
  const int x = std::min(static_cast<int>(pixel.x()), image.width - 2);
  const int y = std::min(static_cast<int>(pixel.y()), image.height - 2);
  const double fx = pixel.x() - x;
  const double fy = pixel.y() - y;
  return (1.0 - fy) * ((1.0 - fx) * image.at(x, y) + fx * image.at(x + 1, y)) +
         fy * ((1.0 - fx) * image.at(x, y + 1) + fx * image.at(x + 1, y + 1));
}

// What is minimised: the information, negative, by a right perturbation [rad; m] of a pose.
class Objective final : public cv::MinProblemSolver::Function {
 public:
  Objective(const CameraModel& model, const std::vector<Sighting>& sightings, const std::vector<GreyImage>& images,
            const SE3& T_base_camera)
      : model_(model), sightings_(sightings), images_(images), T_base_camera_(T_base_camera) {}

  [[nodiscard]] int getDims() const override { return 6; }

  double calc(const double* x) const override {
    ++evaluations_;
    const SE3 T_camera_base = moved(x).inverse();
    const Counts counts = parallel_sum(sightings_.size(), grain, Counts{}, [&](std::size_t begin, std::size_t end) {
      Counts part;
      for (std::size_t i = begin; i < end; ++i) {
        const Sighting& sighting = sightings_[i];
        const auto pixel = model_.project(T_camera_base * sighting.p_base.cast<double>());
        if (!pixel || !model_.contains(*pixel)) continue;
        part.add(sighting.code % reflectivity_ranks, bilinear(images_[sighting.view], *pixel));
      }
      return part;
    });
    return -counts.information();
  }

  [[nodiscard]] SE3 moved(const double* x) const { return T_base_camera_ * SE3::exp(Eigen::Map<const Vector6d>(x)); }
  [[nodiscard]] int evaluations() const { return evaluations_; }

 private:
  const CameraModel& model_;
  const std::vector<Sighting>& sightings_;
  const std::vector<GreyImage>& images_;
  SE3 T_base_camera_;
  mutable int evaluations_ = 0;
};

std::vector<GreyImage> blurred_views(const CameraTask& camera, double sigma_px) {
  std::vector<GreyImage> out(camera.views.size());
  parallel_for(out.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) out[k] = blurred(camera.views[k].grey, sigma_px);
  });
  return out;
}

}  // namespace

std::optional<MutualInformation> maximise_information(const CameraScene& scene, const CameraTask& camera,
                                                      const SE3& guess_T_base_camera) {
  const CameraModel model(camera.intrinsics);
  const SurfaceCodes codes = surface_codes(scene.samples);
  MutualInformation out;
  out.T_base_camera = guess_T_base_camera;
  for (const Level& level : levels) {
    const auto begin = SteadyClock::now();
    SightingOptions seen;
    seen.max_sightings = most_sightings;
    seen.margin_px = &level == &levels.front() ? margin_px : 0.0;
    const std::vector<Sighting> sightings = find_sightings(scene, codes, camera, model, out.T_base_camera, seen);
    if (sightings.size() < least_sightings) return std::nullopt;
    const std::vector<GreyImage> images = blurred_views(camera, level.blur_px);
    const auto matched = SteadyClock::now();
    const cv::Ptr<Objective> objective = cv::makePtr<Objective>(model, sightings, images, out.T_base_camera);
    cv::Mat step(1, 6, CV_64F);
    for (int k = 0; k < 6; ++k) step.at<double>(k) = k < 3 ? level.rotation_rad : level.translation_m;
    const auto solver = cv::DownhillSolver::create(
        objective, step, cv::TermCriteria(cv::TermCriteria::MAX_ITER + cv::TermCriteria::EPS, level.iterations, 1e-7));
    cv::Mat x = cv::Mat::zeros(1, 6, CV_64F);
    out.information = -solver->minimize(x);
    out.T_base_camera = objective->moved(x.ptr<double>());
    out.evaluations += objective->evaluations();
    out.match_s += seconds_between(begin, matched);
    out.solve_s += seconds_since(matched);
  }
  return out;
}

}  // namespace rigcal::targetless
