#include "core/board/board_adjustment.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/median.h"
#include "core/board/board_costs.h"
#include "core/board/board_jackknife.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

// As wide as half of a LiDAR's beam, or half a step of its scan, radians.
constexpr double widening_sigma = 0.004;

using board::BorderCost;
using board::ChangingCamera;
using board::PlaneCost;
using board::PlaneMoments7;
using board::SquaresCost;

constexpr double border_loss_sigmas = 2.0;
constexpr double corner_loss_sigmas = 3.0;
constexpr double outlier_ratio = 3.0;
constexpr double least_sigma_px = 0.02;
constexpr double least_sigma_m = 0.001;
// Of the information, unknowns in their own units: directions that hold less are open.
constexpr double least_information = 1e-10;
// A sensor that open directions move by a larger share is open itself; by less it is rounding, and widens its variances
// by a hundred of what they would be alone at most.
constexpr double least_open_share = 1e-8;

/// A residual that holds a parameter near zero.
struct Prior {
  double sigma;
  template <class T>
  bool operator()(const T* x, T* residual) const {
    residual[0] = x[0] / sigma;
    return true;
  }
};

/// Residuals that hold a camera's intrinsics near what was given, by amply what these may be off by: one that saw
/// the board once would slide along what it leaves open, and the adjustment of all come to no rest.
struct IntrinsicsPrior {
  std::array<double, intrinsics_count> given;
  double focal_share = 0.3;
  double middle_share = 0.1;  ///< Of the focal length, too.
  double distortion = 1.0;
  template <class T>
  bool operator()(const T* x, T* residual) const {
    for (std::size_t k = 0; k < given.size(); ++k) {
      const double sigma = k < 2 ? focal_share * given[k] : k < 4 ? middle_share * given[k - 2] : distortion;
      residual[k] = (x[k] - given[k]) / sigma;
    }
    return true;
  }
};

// Before Ceres 2.1 (Ubuntu 22.04) the same things have other names.
#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
void hold_elements(ceres::Problem& problem, double* block, int size, const std::vector<int>& elements) {
  problem.SetManifold(block, new ceres::SubsetManifold(size, elements));
}

int free_elements(const ceres::Problem& problem, const double* block) {
  return problem.ParameterBlockTangentSize(block);
}
#else
void hold_elements(ceres::Problem& problem, double* block, int size, const std::vector<int>& elements) {
  problem.SetParameterization(block, new ceres::SubsetParameterization(size, elements));
}

int free_elements(const ceres::Problem& problem, const double* block) { return problem.ParameterBlockLocalSize(block); }
#endif

/// The unknowns of one sensor.
struct SensorBlock {
  SE3 start;
  double x[6] = {};
  double range_offset = 0.0;
  std::array<double, 2> growth{};
  double widening = 0.0;
  std::array<double, intrinsics_count> intrinsics{};
  std::unique_ptr<ChangingCamera> camera;
};

struct PlaceBlock {
  SE3 start;
  double x[6] = {};
};

// Rotation and translation each by one factor: so few boards do not tell directions apart.
void widen(Matrix6d& covariance, const Matrix6d& between) {
  Vector6d factor = Vector6d::Ones();
  for (int part = 0; part < 6; part += 3) {
    const Matrix3d ratio = covariance.block<3, 3>(part, part).ldlt().solve(between.block<3, 3>(part, part));
    const double mean = ratio.trace() / 3.0;
    if (mean > 1.0) factor.segment<3>(part).setConstant(std::sqrt(mean));  // not where it is no number
  }
  covariance = factor.asDiagonal() * covariance * factor.asDiagonal();
}

class Adjuster {
 public:
  Adjuster(BoardAdjustment& work, const std::vector<BoardSensor>& given, const BoardModel& board,
           const BoardAdjustOptions& options)
      : work_(work), given_(given), board_(board), options_(options) {
    for (const BoardPlace& place : work_.places) {
      auto& list = moments_.emplace_back();
      for (const BoardSighting& s : place.sightings) {
        list.push_back(s.cloud ? board::plane_moments(s.cloud->points) : PlaneMoments7{});
      }
    }
  }

  void solve() {
    build();
    if (problem_->NumResidualBlocks() == 0) return;
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering.reset(ordering());
    options.max_num_iterations = 60;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    options.function_tolerance = 1e-12;
    options.gradient_tolerance = 1e-12;
    options.parameter_tolerance = 1e-11;
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem_.get(), &summary);
    if (work_.iterations == 0) work_.cost_before = 2.0 * summary.initial_cost;
    work_.cost_after = 2.0 * summary.final_cost;
    work_.iterations += static_cast<int>(summary.iterations.size());
    work_.converged = summary.termination_type == ceres::CONVERGENCE;
    if (summary.IsSolutionUsable()) take();
  }

  void find_covariances() {
    work_.covariances.assign(work_.sensors.size(), Matrix6d::Zero());
    work_.range_offset_sigma_m.assign(work_.sensors.size(), 0.0);
    work_.focal_sigma.assign(work_.sensors.size(), 0.0);
    work_.growth_sigma_m.assign(work_.sensors.size(), Eigen::Vector2d::Zero());
    // A sensor of which nothing takes part is held by nothing.
    work_.observable.clear();
    for (const BoardSensor& s : work_.sensors) work_.observable.push_back(s.fixed || options_.sensors_fixed ? 1 : 0);
    build();
    std::vector<double*> blocks;
    problem_->GetParameterBlocks(&blocks);
    std::erase_if(blocks, [&](double* b) { return problem_->IsParameterBlockConstant(b); });
    if (blocks.empty()) return;
    // The boards' own poses behind what they share.
    const auto shared_end = std::stable_partition(blocks.begin(), blocks.end(), [&](const double* b) {
      return std::none_of(places_.begin(), places_.end(), [&](const PlaceBlock& place) { return place.x == b; });
    });
    std::map<const double*, int> at;
    int size = 0;
    int shared = 0;
    for (auto b = blocks.begin(); b != blocks.end(); ++b) {
      at[*b] = size;
      size += free_elements(*problem_, *b);
      if (b < shared_end) shared = size;
    }
    ceres::Problem::EvaluateOptions evaluate;
    evaluate.parameter_blocks = blocks;
    evaluate.num_threads = 1;
    ceres::CRSMatrix J;
    double cost = 0.0;
    std::vector<double> residuals;
    if (!problem_->Evaluate(evaluate, &cost, &residuals, nullptr, &J)) return;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
    for (int row = 0; row < J.num_rows; ++row) {
      for (int i = J.rows[row]; i < J.rows[row + 1]; ++i) {
        for (int k = J.rows[row]; k < J.rows[row + 1]; ++k) H(J.cols[i], J.cols[k]) += J.values[i] * J.values[k];
      }
    }
    const Eigen::MatrixXd between = jackknife_covariance(J, residuals, shared);
    work_.chi2 = 2.0 * cost / std::max(1.0, degrees_of_freedom() - size);
    // Unknowns in their own units before the condition is judged.
    const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
    const SymmetricEigenX eigen = symmetric_eigen_x(scaled);
    const Eigen::MatrixXd open = eigen.vectors.leftCols((eigen.values.array() < least_information).count());
    const Eigen::VectorXd inverse = eigen.values.cwiseMax(least_information).cwiseInverse();
    Eigen::MatrixXd covariance = eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose();
    covariance = scale.asDiagonal() * covariance * scale.asDiagonal();
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      if (const auto k = at.find(sensors_[s].x); k != at.end()) {
        work_.covariances[s] = covariance.block<6, 6>(k->second, k->second) * std::max(1.0, work_.chi2);
        if (boards_that_hold(s) >= least_jackknife_boards) {
          widen(work_.covariances[s], between.block<6, 6>(k->second, k->second));
        }
        work_.observable[s] = open.middleRows<6>(k->second).squaredNorm() < least_open_share ? 1 : 0;
      }
      if (const auto k = at.find(&sensors_[s].range_offset); k != at.end()) {
        work_.range_offset_sigma_m[s] =
            std::sqrt(std::max(covariance(k->second, k->second), between(k->second, k->second)));
      }
      if (const auto k = at.find(sensors_[s].intrinsics.data()); k != at.end()) {
        const double sigma = std::sqrt(std::max(covariance(k->second, k->second), between(k->second, k->second)));
        work_.focal_sigma[s] = sigma / sensors_[s].intrinsics[0];
      }
      for (std::size_t axis = 0; axis < 2; ++axis) {
        if (const auto k = at.find(&sensors_[s].growth[axis]); k != at.end()) {
          work_.growth_sigma_m[s][static_cast<int>(axis)] = std::sqrt(covariance(k->second, k->second));
        }
      }
    }
  }

 private:
  [[nodiscard]] static bool takes_part(const BoardPlace& place) { return place.why_out.empty(); }

  [[nodiscard]] int boards_that_hold(std::size_t sensor) const {
    return static_cast<int>(std::count_if(work_.places.begin(), work_.places.end(), [&](const BoardPlace& place) {
      return takes_part(place) && place.sightings.size() > 1 &&
             std::any_of(place.sightings.begin(), place.sightings.end(),
                         [&](const BoardSighting& seen) { return static_cast<std::size_t>(seen.sensor) == sensor; });
    }));
  }

  void build() {
    ceres::Problem::Options keep;
    problem_ = std::make_unique<ceres::Problem>(keep);
    sensors_ = std::vector<SensorBlock>(work_.sensors.size());
    places_ = std::vector<PlaceBlock>(work_.places.size());
    plane_points_ = 0.0;
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      const BoardSensor& sensor = work_.sensors[s];
      SensorBlock& block = sensors_[s];
      block.start = sensor.T_base_sensor;
      block.range_offset = sensor.range_offset_m;
      block.growth = {sensor.growth_m.x(), sensor.growth_m.y()};
      block.widening = sensor.widening;
      if (!sensor.camera) continue;
      block.camera = std::make_unique<ChangingCamera>(*sensor.camera);
      block.intrinsics = ChangingCamera::values_of(*sensor.camera);
    }
    for (std::size_t p = 0; p < places_.size(); ++p) {
      if (!takes_part(work_.places[p])) continue;
      places_[p].start = work_.places[p].T_base_board;
      for (std::size_t k = 0; k < work_.places[p].sightings.size(); ++k) add(p, k);
    }
    for (std::size_t s = 0; s < sensors_.size(); ++s) hold(s);
  }

  void add(std::size_t p, std::size_t k) {
    const BoardSighting& seen = work_.places[p].sightings[k];
    SensorBlock& sensor = sensors_[static_cast<std::size_t>(seen.sensor)];
    const BoardSensor& figures = work_.sensors[static_cast<std::size_t>(seen.sensor)];
    PlaceBlock& place = places_[p];
    if (seen.image && sensor.camera) {
      for (std::size_t c = 0; c < seen.image->ids.size(); ++c) {
        auto* cost =
            board::corner_cost_function({&sensor.start, &place.start, sensor.camera.get(),
                                         board_.corner(seen.image->ids[c]), seen.image->pixels[c], figures.sigma_px});
        problem_->AddResidualBlock(cost, new ceres::HuberLoss(corner_loss_sigmas), sensor.x, place.x,
                                   sensor.intrinsics.data());
      }
    }
    if (!seen.cloud || seen.cloud->points.empty()) return;
    const PlaneMoments7& moments = moments_[p][k];
    const double sigma = std::sqrt(figures.sigma_plane_m * figures.sigma_plane_m +
                                   moments.points * options_.plane_floor_m * options_.plane_floor_m);
    auto* plane = new ceres::AutoDiffCostFunction<PlaneCost, 7, 6, 6, 1>(
        new PlaneCost{&sensor.start, &place.start, &moments, sigma});
    problem_->AddResidualBlock(plane, nullptr, sensor.x, place.x, &sensor.range_offset);
    plane_points_ += moments.points - 7.0;
    if (seen.cloud->squares) {
      const SquareCue& cue = *seen.cloud->squares;
      auto* squares = new ceres::AutoDiffCostFunction<SquaresCost, 4, 6, 6>(new SquaresCost{
          &sensor.start, &place.start, cue.T_lidar_pattern, cue.shift_sigma_m, cue.angle_sigma_rad, cue.scale_sigma});
      problem_->AddResidualBlock(squares, new ceres::HuberLoss(border_loss_sigmas), sensor.x, place.x);
    }
    std::map<std::pair<int, int>, double> of_edge;
    for (const BorderPoint& b : seen.cloud->border) of_edge[{b.axis, b.sign}] += 1.0;
    for (const BorderPoint& b : seen.cloud->border) {
      const double sigma_border =
          std::hypot(figures.sigma_border_m, std::sqrt(of_edge[{b.axis, b.sign}]) * options_.border_floor_m);
      auto* cost = new ceres::AutoDiffCostFunction<BorderCost, 1, 6, 6, 1, 1, 1>(
          new BorderCost{&sensor.start, &place.start, b.p, b.axis, static_cast<double>(b.sign),
                         0.5 * board_.size()[b.axis], figures.usual_range_m, sigma_border});
      problem_->AddResidualBlock(cost, new ceres::CauchyLoss(border_loss_sigmas), sensor.x, place.x,
                                 &sensor.range_offset, &sensor.growth[static_cast<std::size_t>(b.axis)],
                                 &sensor.widening);
    }
  }

  // What is known, or held near zero.
  void hold(std::size_t s) {
    SensorBlock& block = sensors_[s];
    const BoardSensor& sensor = work_.sensors[s];
    const auto is_used = [&](double* b) { return problem_->HasParameterBlock(b); };
    if (is_used(block.x) && (sensor.fixed || options_.sensors_fixed)) problem_->SetParameterBlockConstant(block.x);
    if (is_used(block.intrinsics.data())) hold_intrinsics(block, *given_[s].camera);
    const bool ranges_known = options_.range_offset_sigma_m <= 0.0 || options_.sensors_fixed;
    hold_near(&block.range_offset, options_.range_offset_sigma_m, ranges_known);
    for (double& growth : block.growth) hold_near(&growth, options_.growth_sigma_m, options_.sensors_fixed);
    hold_near(&block.widening, widening_sigma, options_.sensors_fixed);
  }

  void hold_near(double* parameter, double sigma, bool known) {
    if (!problem_->HasParameterBlock(parameter)) return;
    if (known) {
      problem_->SetParameterBlockConstant(parameter);
      return;
    }
    problem_->AddResidualBlock(new ceres::AutoDiffCostFunction<Prior, 1, 1>(new Prior{sigma}), nullptr, parameter);
  }

  void hold_intrinsics(SensorBlock& block, const CameraIntrinsics& given) {
    if ((!options_.refine_intrinsics && !options_.free_focal_lengths) || options_.sensors_fixed) {
      problem_->SetParameterBlockConstant(block.intrinsics.data());
      return;
    }
    if (!options_.refine_intrinsics) {
      hold_elements(*problem_, block.intrinsics.data(), intrinsics_count, {2, 3, 4, 5, 6, 7, 8});
    } else if (distortion_count(given.model) < 5) {
      hold_elements(*problem_, block.intrinsics.data(), intrinsics_count, {8});
    }
    auto* prior = new ceres::AutoDiffCostFunction<IntrinsicsPrior, intrinsics_count, intrinsics_count>(
        new IntrinsicsPrior{ChangingCamera::values_of(given)});
    problem_->AddResidualBlock(prior, nullptr, block.intrinsics.data());
  }

  [[nodiscard]] ceres::ParameterBlockOrdering* ordering() {
    auto* out = new ceres::ParameterBlockOrdering;
    std::vector<double*> blocks;
    problem_->GetParameterBlocks(&blocks);
    for (double* b : blocks) out->AddElementToGroup(b, 1);
    for (PlaceBlock& place : places_) {
      if (problem_->HasParameterBlock(place.x)) out->AddElementToGroup(place.x, 0);
    }
    return out;
  }

  [[nodiscard]] double degrees_of_freedom() const { return problem_->NumResiduals() + plane_points_; }

  void take() {
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      BoardSensor& sensor = work_.sensors[s];
      sensor.T_base_sensor = board::pose_at(sensors_[s].start, sensors_[s].x);
      sensor.range_offset_m = sensors_[s].range_offset;
      sensor.growth_m = {sensors_[s].growth[0], sensors_[s].growth[1]};
      sensor.widening = sensors_[s].widening;
      if (sensor.camera) {
        sensor.camera = ChangingCamera::with_values(*sensor.camera, sensors_[s].intrinsics.data());
      }
    }
    for (std::size_t p = 0; p < places_.size(); ++p) {
      if (takes_part(work_.places[p])) work_.places[p].T_base_board = board::pose_at(places_[p].start, places_[p].x);
    }
  }

  BoardAdjustment& work_;
  const std::vector<BoardSensor>& given_;
  const BoardModel& board_;
  const BoardAdjustOptions& options_;
  std::vector<std::vector<PlaneMoments7>> moments_;
  std::vector<SensorBlock> sensors_;
  std::vector<PlaceBlock> places_;
  std::unique_ptr<ceres::Problem> problem_;
  double plane_points_ = 0.0;
};

// Medians over the sightings of each sensor, as what one bad sighting tells counts for little.
void estimate_noise(const BoardModel& board, BoardAdjustment& work) {
  for (std::size_t s = 0; s < work.sensors.size(); ++s) {
    std::vector<double> pixels;
    std::vector<double> plane;
    std::vector<double> border;
    for (const BoardPlace& place : work.places) {
      if (!place.why_out.empty()) continue;
      for (const BoardSighting& seen : place.sightings) {
        if (static_cast<std::size_t>(seen.sensor) != s) continue;
        const SightingResiduals r = residuals_of(seen, work.sensors[s], place.T_base_board, board);
        // The six unknowns of the board take their share of so few residuals.
        if (seen.image) pixels.push_back(r.pixels / std::sqrt(2.0));
        if (seen.cloud) plane.push_back(r.plane_m);
        if (seen.cloud) border.push_back(r.border_m);
      }
    }
    BoardSensor& sensor = work.sensors[s];
    if (!pixels.empty()) sensor.sigma_px = std::max(least_sigma_px, 1.05 * median(pixels));
    if (!plane.empty()) sensor.sigma_plane_m = std::max(least_sigma_m, median(plane));
    if (!border.empty()) sensor.sigma_border_m = std::max(least_sigma_m, 1.1 * median(border));
  }
}

// The distance at which the plates' growth is told: that of the borders which a LiDAR saw, in the mean.
void set_usual_ranges(BoardAdjustment& work) {
  for (std::size_t s = 0; s < work.sensors.size(); ++s) {
    if (work.sensors[s].usual_range_m > 0.0) continue;
    double sum = 0.0;
    double count = 0.0;
    for (const BoardPlace& place : work.places) {
      for (const BoardSighting& seen : place.sightings) {
        if (static_cast<std::size_t>(seen.sensor) != s || !seen.cloud) continue;
        for (const BorderPoint& b : seen.cloud->border) sum += b.p.norm();
        count += static_cast<double>(seen.cloud->border.size());
      }
    }
    work.sensors[s].usual_range_m = count > 0.0 ? sum / count : 0.0;
  }
}

// True where a sighting was thrown out; the worst one at a time.
bool drop_worst(const BoardModel& board, BoardAdjustment& work) {
  std::map<int, std::vector<double>> by_sensor;
  for (const BoardPlace& place : work.places) {
    if (!place.why_out.empty()) continue;
    for (const BoardSighting& seen : place.sightings) {
      const auto& sensor = work.sensors[static_cast<std::size_t>(seen.sensor)];
      by_sensor[seen.sensor].push_back(residuals_of(seen, sensor, place.T_base_board, board).normalised);
    }
  }
  BoardPlace* worst = nullptr;
  std::size_t which = 0;
  double ratio = outlier_ratio;
  for (BoardPlace& place : work.places) {
    if (!place.why_out.empty()) continue;
    for (std::size_t k = 0; k < place.sightings.size(); ++k) {
      const BoardSighting& seen = place.sightings[k];
      const auto& sensor = work.sensors[static_cast<std::size_t>(seen.sensor)];
      const double usual = std::max(1.0, median(by_sensor[seen.sensor]));
      const double now = residuals_of(seen, sensor, place.T_base_board, board).normalised / usual;
      if (now > ratio) {
        ratio = now;
        worst = &place;
        which = k;
      }
    }
  }
  if (worst == nullptr) return false;
  const std::string name = work.sensors[static_cast<std::size_t>(worst->sightings[which].sensor)].name;
  const std::string why = "what " + name + " saw of the board does not go with the other poses";
  // A board that only two saw: which of them is wrong nobody can tell.
  worst->sightings.erase(worst->sightings.begin() + static_cast<std::ptrdiff_t>(which));
  if (worst->sightings.size() < 2) worst->why_out = why;
  return true;
}

}  // namespace

BoardAdjustment adjust_boards(std::vector<BoardSensor> sensors, std::vector<BoardPlace> places, const BoardModel& board,
                              const BoardAdjustOptions& options) {
  BoardAdjustment work;
  const std::vector<BoardSensor> given = sensors;
  work.sensors = std::move(sensors);
  work.places = std::move(places);
  set_usual_ranges(work);
  for (int pass = 0; pass < std::max(1, options.noise_passes); ++pass) {
    Adjuster(work, given, board, options).solve();
    if (options.noise_passes > 0 && !options.sensors_fixed) estimate_noise(board, work);
  }
  const int most = static_cast<int>(work.places.size()) / 3;
  for (int k = 0; options.drop_outliers && k < most && drop_worst(board, work); ++k) {
    Adjuster(work, given, board, options).solve();
    estimate_noise(board, work);
    Adjuster(work, given, board, options).solve();
  }
  Adjuster(work, given, board, options).find_covariances();
  return work;
}

}  // namespace rigcal
