#include "tests/apps/real/image_pairs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "core/edges/grey_image.h"
#include "core/io/image_file.h"

namespace rigcal {
namespace {

struct Features {
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
};

Features features_of(const std::filesystem::path& path) {
  Features out;
  const Expected<Image> image = read_image(path.string());
  if (!image) return out;
  GreyImage grey = to_grey(*image, image->bits);
  cv::Mat pixels;
  cv::Mat(grey.height, grey.width, CV_32F, grey.values.data()).convertTo(pixels, CV_8U);
  cv::SIFT::create(5000)->detectAndCompute(pixels, cv::noArray(), out.points, out.descriptors);
  return out;
}

cv::Point2d on_plane(const Vector3d& ray) { return {ray.x() / ray.z(), ray.y() / ray.z()}; }

// The essential matrix that fits all of them, and which of them it fits to a pixel.
cv::Mat essential_of(const std::vector<RayPair>& pairs, double threshold, cv::Mat& fits) {
  std::vector<cv::Point2d> first;
  std::vector<cv::Point2d> second;
  for (const RayPair& pair : pairs) {
    first.push_back(on_plane(pair.first));
    second.push_back(on_plane(pair.second));
  }
  return cv::findEssentialMat(first, second, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.9999, threshold, fits);
}

double median_px(const std::vector<RayPair>& pairs, const Matrix3d& E, double focal_px) {
  std::vector<double> distances;
  for (const RayPair& pair : pairs) {
    const Vector3d a = pair.first / pair.first.z();
    const Vector3d b = pair.second / pair.second.z();
    const double error = std::abs(b.dot(E * a));
    const double of_b = error / (E * a).head<2>().norm();
    const double of_a = error / (E.transpose() * b).head<2>().norm();
    distances.push_back(0.5 * focal_px * (of_a + of_b));
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

}  // namespace

std::vector<RayPair> match_images(const std::filesystem::path& first, const CameraModel& first_camera,
                                  const std::filesystem::path& second, const CameraModel& second_camera) {
  const Features a = features_of(first);
  const Features b = features_of(second);
  if (a.points.empty() || b.points.empty()) return {};
  const cv::BFMatcher matcher(cv::NORM_L2);
  std::vector<std::vector<cv::DMatch>> forth;
  std::vector<std::vector<cv::DMatch>> back;
  matcher.knnMatch(a.descriptors, b.descriptors, forth, 2);
  matcher.knnMatch(b.descriptors, a.descriptors, back, 1);
  std::vector<RayPair> pairs;
  for (const std::vector<cv::DMatch>& two : forth) {
    if (two.size() < 2 || two[0].distance > 0.75F * two[1].distance) continue;
    if (back[static_cast<std::size_t>(two[0].trainIdx)][0].trainIdx != two[0].queryIdx) continue;
    const cv::Point2f p = a.points[static_cast<std::size_t>(two[0].queryIdx)].pt;
    const cv::Point2f q = b.points[static_cast<std::size_t>(two[0].trainIdx)].pt;
    const auto ray_p = first_camera.ray({p.x, p.y});
    const auto ray_q = second_camera.ray({q.x, q.y});
    if (ray_p && ray_q && ray_p->z() > 0.1 && ray_q->z() > 0.1) pairs.push_back({*ray_p, *ray_q});
  }
  if (pairs.size() < 20) return {};
  cv::Mat fits;
  essential_of(pairs, 1.0 / first_camera.intrinsics().fx, fits);
  std::vector<RayPair> out;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (fits.at<unsigned char>(static_cast<int>(k)) != 0) out.push_back(pairs[k]);
  }
  return out;
}

double median_epipolar_px(const std::vector<RayPair>& pairs, const SE3& T_second_first, double focal_px) {
  return median_px(pairs, skew(T_second_first.t) * T_second_first.R, focal_px);
}

double least_epipolar_px(const std::vector<RayPair>& pairs, double focal_px) {
  cv::Mat fits;
  const cv::Mat found = essential_of(pairs, 0.3 / focal_px, fits);
  Matrix3d E;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) E(r, c) = found.at<double>(r, c);
  }
  return median_px(pairs, E, focal_px);
}

}  // namespace rigcal
