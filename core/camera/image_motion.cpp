#include "core/camera/image_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"
#include "core/camera/sightings.h"
#include "core/geometry/spiral_direction.h"

namespace rigcal {
namespace {

constexpr double least_turn_rad = to_rad(4.0);   // A smaller one tells little of its axis,
constexpr double largest_turn_rad = to_rad(50);  // a larger one leaves little that both images see.
constexpr std::size_t most_neighbours = 2;       // With so many others each image is compared,
constexpr int most_features = 1000;              // by so many features (Rublee et al. 2011: ORB),
constexpr float distinct = 0.8F;                 // each much more like its partner than like the next best.
constexpr std::size_t most_pairs = 2000;

// Features are looked for in images of about this width: what turns and shifts by degrees needs no single pixels.
constexpr int width_looked_at = 800;

constexpr std::size_t directions = 3000;  // about 4 degrees apart
constexpr std::size_t tried_axes = 4;
constexpr double axes_apart_rad = to_rad(15.0);
constexpr std::size_t least_pairs = 30;
// What is near moves so much more or less than the turn, at most, where the camera sits beside the axis.
constexpr double carried_rad = to_rad(12.0);
constexpr double first_carried_rad = to_rad(8.0);
// How far off the side that it is carried to; it narrows while the axis settles.
constexpr std::array<double, 3> beside_rad{to_rad(2.0), to_rad(1.0), to_rad(0.5)};
constexpr int levers = 12;

struct Described {
  std::vector<Vector3d> rays;
  cv::Mat descriptors;  // a row for each ray
};

Described describe(const GreyImage& grey, const CameraModel& model) {
  const cv::Mat values(grey.height, grey.width, CV_32F, const_cast<float*>(grey.values.data()));
  const double scale = std::min(1.0, static_cast<double>(width_looked_at) / grey.width);
  cv::Mat smaller;
  cv::resize(values, smaller, {}, scale, scale, cv::INTER_AREA);
  smaller.convertTo(smaller, CV_8U);
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  cv::ORB::create(most_features, 1.2F, 6, 31, 0, 2, cv::ORB::HARRIS_SCORE, 31, 8)
      ->detectAndCompute(smaller, cv::noArray(), points, descriptors);
  Described out;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector2d pixel((points[k].pt.x + 0.5) / scale - 0.5, (points[k].pt.y + 0.5) / scale - 0.5);
    const auto ray = model.ray(pixel);
    if (!ray) continue;
    out.rays.push_back(*ray);
    out.descriptors.push_back(descriptors.row(static_cast<int>(k)));
  }
  return out;
}

// Partners that are each other's best, and much better than the next.
void append_matches(const Described& first, const Described& second, double turn_rad, std::vector<SeenTwice>& pairs) {
  if (first.rays.size() < 2 || second.rays.size() < 2) return;
  const cv::BFMatcher matcher(cv::NORM_HAMMING);
  std::vector<std::vector<cv::DMatch>> there;
  std::vector<std::vector<cv::DMatch>> back;
  matcher.knnMatch(first.descriptors, second.descriptors, there, 2);
  matcher.knnMatch(second.descriptors, first.descriptors, back, 1);
  for (const std::vector<cv::DMatch>& best : there) {
    if (best.size() < 2 || best[0].distance >= distinct * best[1].distance) continue;
    const auto partner = static_cast<std::size_t>(best[0].trainIdx);
    if (back[partner].empty() || back[partner][0].trainIdx != best[0].queryIdx) continue;
    pairs.push_back({turn_rad, first.rays[static_cast<std::size_t>(best[0].queryIdx)], second.rays[partner]});
  }
}

struct Turned {
  std::size_t first = 0;
  std::size_t second = 0;
  Vector3d rotation_base = Vector3d::Zero();  // vector of the rotation from the second's frame into the first's
};

std::vector<Turned> neighbours_of(const CameraScene& scene, const CameraTask& camera) {
  std::vector<Turned> out;
  const std::vector<CameraView>& views = camera.views;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!is_usable(scene, camera.intrinsics, views[i])) continue;
    std::vector<Turned> own;
    for (std::size_t j = i + 1; j < views.size(); ++j) {
      if (!is_usable(scene, camera.intrinsics, views[j])) continue;
      const Matrix3d& R_i = scene.T_G_base[static_cast<std::size_t>(views[i].stop)].R;
      const Matrix3d& R_j = scene.T_G_base[static_cast<std::size_t>(views[j].stop)].R;
      const Vector3d rotation = log_so3(R_i.transpose() * R_j);
      if (rotation.norm() < least_turn_rad || rotation.norm() > largest_turn_rad) continue;
      own.push_back({i, j, rotation});
    }
    std::stable_sort(own.begin(), own.end(), [](const Turned& a, const Turned& b) {
      return a.rotation_base.squaredNorm() < b.rotation_base.squaredNorm();
    });
    own.resize(std::min(own.size(), most_neighbours));
    out.insert(out.end(), own.begin(), own.end());
  }
  return out;
}

// What is seen along `second` is seen along this from the first image, if it is far away.
Vector3d turned(const SeenTwice& pair, const Vector3d& axis, const Vector3d& ray) {
  const double c = std::cos(pair.turn_rad);
  return c * ray + std::sin(pair.turn_rad) * axis.cross(ray) + (1.0 - c) * axis.dot(ray) * axis;
}

// 1 for what is not off at all, 0 for what is off by the tolerance or more.
double likeness(double off_squared, double tolerance_rad) {
  return std::max(0.0, 1.0 - off_squared / (tolerance_rad * tolerance_rad));
}

double share_of_far(const std::vector<SeenTwice>& pairs, const Vector3d& axis) {
  double sum = 0.0;
  for (const SeenTwice& pair : pairs)
    sum += likeness((turned(pair, axis, pair.second) - pair.first).squaredNorm(), first_carried_rad);
  return sum / static_cast<double>(pairs.size());
}

struct Candidate {
  Vector3d axis = Vector3d::UnitZ();
  Vector3d lever = Vector3d::UnitX();  // unit, at right angles to the axis
  double score = 0.0;
};

double share_of(const std::vector<SeenTwice>& pairs, const Candidate& at, double tolerance_rad) {
  double sum = 0.0;
  for (const SeenTwice& pair : pairs) {
    const Vector3d far = turned(pair, at.axis, pair.second);
    const Vector3d off = pair.first - far;
    const double near = likeness(off.squaredNorm(), carried_rad);
    if (near <= 0.0) continue;
    // The first camera sees the second move by (R - I) lever; things move towards that side, and no other.
    const Vector3d carried = (turned(pair, at.axis, at.lever) - at.lever).normalized();
    const Vector3d across = far.cross(carried);
    const double sine = across.norm();
    double beside = off.norm();
    if (sine > 0.05 && off.dot(carried) > -tolerance_rad) beside = std::abs(across.dot(pair.first)) / sine;
    sum += near * likeness(beside * beside, tolerance_rad);
  }
  return sum / static_cast<double>(pairs.size());
}

Candidate moved(const Candidate& from, double about_u, double about_v, double lever_rad) {
  const Vector3d u = from.lever;
  const Vector3d v = from.axis.cross(u);
  Candidate out;
  const Matrix3d R = exp_so3(about_u * u + about_v * v + lever_rad * from.axis);
  out.axis = (R * from.axis).normalized();
  out.lever = R * from.lever;
  out.lever = (out.lever - out.axis * out.axis.dot(out.lever)).normalized();
  return out;
}

// Uphill with steps that get shorter.
void climb(const std::vector<SeenTwice>& pairs, double tolerance_rad, Candidate& at) {
  at.score = share_of(pairs, at, tolerance_rad);
  for (double step = 2.0 * tolerance_rad; step > 0.1 * tolerance_rad; step *= 0.5) {
    int rounds = 0;
    for (bool better = true; better && rounds < 20; ++rounds) {
      better = false;
      for (int k = 0; k < 3; ++k) {
        for (const double sign : {1.0, -1.0}) {
          // The lever's side shows less than the axis.
          Candidate next =
              moved(at, k == 0 ? sign * step : 0.0, k == 1 ? sign * step : 0.0, k == 2 ? 5.0 * sign * step : 0.0);
          next.score = share_of(pairs, next, tolerance_rad);
          if (next.score <= at.score + 1e-9) continue;
          at = next;
          better = true;
        }
      }
    }
  }
}

// Of all sides the best one, and from there to the top.
Candidate settled(const std::vector<SeenTwice>& pairs, const Vector3d& axis) {
  Candidate best;
  best.score = -1.0;
  const Vector3d u = axis.unitOrthogonal();
  for (int k = 0; k < levers; ++k) {
    const double angle = 2.0 * pi * k / levers;
    Candidate tried{axis, std::cos(angle) * u + std::sin(angle) * axis.cross(u), 0.0};
    climb(pairs, beside_rad[0], tried);
    if (tried.score > best.score) best = tried;
  }
  climb(pairs, beside_rad[1], best);
  climb(pairs, beside_rad[2], best);
  return best;
}

}  // namespace

std::vector<SeenTwice> match_images(const CameraScene& scene, const CameraTask& camera) {
  const std::vector<Turned> turned = neighbours_of(scene, camera);
  if (turned.empty() || !scene.turn) return {};
  const CameraModel model(camera.intrinsics);
  std::vector<Described> described(camera.views.size());
  parallel_for(described.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (is_usable(scene, camera.intrinsics, camera.views[k])) described[k] = describe(camera.views[k].grey, model);
    }
  });
  std::vector<std::vector<SeenTwice>> found(turned.size());
  parallel_for(turned.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Turned& t = turned[k];
      append_matches(described[t.first], described[t.second], scene.turn->axis_base.dot(t.rotation_base), found[k]);
    }
  });
  std::size_t all = 0;
  for (const auto& some : found) all += some.size();
  const std::size_t every = std::max<std::size_t>(1, (all + most_pairs - 1) / most_pairs);
  std::size_t count = 0;
  std::vector<SeenTwice> pairs;
  for (const auto& some : found) {
    for (const SeenTwice& pair : some) {
      if (count++ % every == 0) pairs.push_back(pair);
    }
  }
  return pairs;
}

std::optional<CameraAxis> find_camera_axis(const std::vector<SeenTwice>& pairs) {
  if (pairs.size() < least_pairs) return std::nullopt;
  std::vector<Candidate> all(directions);
  parallel_for(directions, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      all[i].axis = spiral_direction(i, directions);
      all[i].score = share_of_far(pairs, all[i].axis);
    }
  });
  const auto near = [](const Candidate& a, const Candidate& b) {
    return a.axis.dot(b.axis) > std::cos(axes_apart_rad);
  };
  std::vector<Candidate> best = best_apart(std::move(all), tried_axes, near);
  parallel_for(best.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) best[i] = settled(pairs, best[i].axis);
  });
  best = best_apart(std::move(best), 1, near);
  CameraAxis out{best[0].axis, best[0].lever, best[0].score};
  if (out.share * static_cast<double>(pairs.size()) < static_cast<double>(least_pairs) / 2) return std::nullopt;
  return out;
}

}  // namespace rigcal
