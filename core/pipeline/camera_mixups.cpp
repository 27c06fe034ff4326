#include "core/pipeline/camera_mixups.h"

#include <algorithm>
#include <functional>
#include <map>
#include <string_view>

#include "core/base/parallel.h"
#include "core/quality/verdict_text.h"

namespace rigcal {
namespace {

// Two cameras stand where the rig file has each other where that fits their places or their turns so many times better
// and both together twice as well, and where their own guesses are off by what is worth a word: together by a sigma in
// the one or the other. Guesses that are merely rough are hardly ever so.
constexpr double clearly_better = 4.0;
constexpr double better_in_all = 2.0;
constexpr double least_off = 0.5;

std::uint64_t mark_of(const GreyImage& grey) {
  const std::string_view bytes(reinterpret_cast<const char*>(grey.values.data()), grey.values.size() * sizeof(float));
  return std::hash<std::string_view>{}(bytes);
}

struct Alike {
  int same = 0;
  int stops = 0;  ///< That both have.
};

Alike compare(const ImageMarks& a, const ImageMarks& b) {
  std::map<int, bool> stops;
  for (const auto& [stop, mark] : a) {
    for (const auto& [other_stop, other_mark] : b) {
      if (stop == other_stop) stops[stop] |= mark == other_mark;
    }
  }
  Alike alike;
  alike.stops = static_cast<int>(stops.size());
  for (const auto& [stop, is_same] : stops) alike.same += is_same ? 1 : 0;
  return alike;
}

// Squared, in sigmas of a guess.
struct Apart {
  double place = 0.0;
  double turn = 0.0;

  [[nodiscard]] double all() const { return place + turn; }
  [[nodiscard]] Apart operator+(const Apart& other) const { return {place + other.place, turn + other.turn}; }
};

Apart apart(const SE3& found, const SE3& guess, const CameraCalibrationOptions& options) {
  const double turn = rotation_distance(found.R, guess.R) / options.guess_sigma_rad;
  return {(found.t - guess.t).squaredNorm() / (options.guess_sigma_m * options.guess_sigma_m), turn * turn};
}

bool is_clear(double own, double swapped) { return own > least_off && own > clearly_better * swapped; }

bool are_swapped(const SensorResult& a, const SensorResult& b, const CameraCalibrationOptions& options) {
  if (!a.T_base_sensor || !b.T_base_sensor || !a.guess_T_base_sensor || !b.guess_T_base_sensor) return false;
  const Apart own_a = apart(*a.T_base_sensor, *a.guess_T_base_sensor, options);
  const Apart own_b = apart(*b.T_base_sensor, *b.guess_T_base_sensor, options);
  const Apart swapped_a = apart(*a.T_base_sensor, *b.guess_T_base_sensor, options);
  const Apart swapped_b = apart(*b.T_base_sensor, *a.guess_T_base_sensor, options);
  if (swapped_a.all() > own_a.all() || swapped_b.all() > own_b.all()) return false;
  // Of cameras that look the same way turns say nothing of who is who, but how rough the guesses are.
  const Apart own = own_a + own_b;
  const Apart swapped = swapped_a + swapped_b;
  return own.all() > better_in_all * swapped.all() &&
         (is_clear(own.place, swapped.place) || is_clear(own.turn, swapped.turn));
}

void tell_first(SensorResult& camera, std::string reason) {
  camera.status = std::max(camera.status, Status::weak);
  camera.reasons.insert(camera.reasons.begin(), std::move(reason));
}

void tell_same(SensorResult& camera, const SensorResult& other, const Alike& alike) {
  tell_first(camera, "its images are those of " + other.name + ", too (the same in " + std::to_string(alike.same) +
                         " of " + std::to_string(alike.stops) +
                         " stops): one of the two reads the other's folder, topic or device; give each its own");
}

void tell_repeated(SensorResult& camera, std::size_t same, std::size_t all) {
  tell_first(camera,
             "it has the same image at " + std::to_string(same) + " of " + std::to_string(all) +
                 " stops: the camera or its driver hung, or one file was copied to all; record its images anew");
}

void tell_swapped(SensorResult& camera, const SensorResult& other) {
  const SE3& found = *camera.T_base_sensor;
  const SE3& guess = *camera.guess_T_base_sensor;
  tell_first(camera, "it stands where the rig file has " + other.name + ", " + mm((found.t - guess.t).norm()) +
                         " and " + deg(rotation_distance(found.R, guess.R)) + " from its own initial_extrinsics, and " +
                         other.name +
                         " where it should: swap their folders, topics or devices, or their initial_extrinsics");
}

}  // namespace

ImageMarks image_marks(const std::vector<CameraView>& views) {
  ImageMarks marks(views.size());
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) marks[k] = {views[k].stop, mark_of(views[k].grey)};
  });
  return marks;
}

std::vector<std::size_t> repeated_images(const ImageMarks& marks) {
  std::map<std::uint64_t, std::vector<std::size_t>> groups;
  for (std::size_t k = 0; k < marks.size(); ++k) {
    std::vector<std::size_t>& group = groups[marks[k].second];
    if (group.empty() || marks[group.back()].first != marks[k].first) group.push_back(k);
  }
  std::vector<std::size_t> largest;
  for (const auto& [mark, group] : groups) {
    const bool is_earlier = group.size() == largest.size() && group.front() < largest.front();
    if (group.size() > 1 && (group.size() > largest.size() || is_earlier)) largest = group;
  }
  return largest;
}

void tell_mixed_up(std::span<const ImageMarks> marks, const CameraCalibrationOptions& options,
                   std::vector<SensorResult>& cameras) {
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    for (std::size_t k = i + 1; k < cameras.size(); ++k) {
      const Alike alike = compare(marks[i], marks[k]);
      if (2 * alike.same > alike.stops) {
        tell_same(cameras[i], cameras[k], alike);
        tell_same(cameras[k], cameras[i], alike);
      } else if (are_swapped(cameras[i], cameras[k], options)) {
        tell_swapped(cameras[i], cameras[k]);
        tell_swapped(cameras[k], cameras[i]);
      }
    }
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::size_t same = repeated_images(marks[i]).size();
    if (2 * same > marks[i].size()) tell_repeated(cameras[i], same, marks[i].size());
  }
}

}  // namespace rigcal
