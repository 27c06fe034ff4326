#include "core/pipeline/place_findings.h"

#include <algorithm>

namespace rigcal {
namespace {

// No rough pose is as far off: ten degrees and 0.2 m are asked for.
constexpr double astray_rad = to_rad(15.0);
constexpr double astray_m = 0.4;
// Of rotations and places, what counts the same.
constexpr double metres_per_rad = 1.0;
// By how much nearer the inverses must be.
constexpr double clearly_nearer = 0.3;
// Two LiDARs are not mounted nearer to each other.
constexpr double same_rad = to_rad(0.3);
constexpr double same_m = 0.01;

class PlaceFinder {
 public:
  PlaceFinder(const std::vector<std::optional<SE3>>& guess, const LidarSolution& solution, int base)
      : guess_(guess), solution_(solution), base_(base) {}

  [[nodiscard]] std::vector<PlaceFindings> run() const {
    const bool inverse = are_inverses();
    std::vector<PlaceFindings> out(guess_.size());
    for (int i = 0; i < static_cast<int>(guess_.size()); ++i) {
      if (i == base_ || !is_known(i)) continue;
      PlaceFindings& findings = out[index(i)];
      if (guess_[index(i)]) {
        findings.from_guess_rad = angle(i, i);
        findings.from_guess_m = (place(i).t - guess_[index(i)]->t).norm();
        findings.guess_is_inverse = inverse;
        if (!inverse) findings.stands_at = stands_at(i);
      }
      findings.same_place_as = same_place_as(i);
    }
    return out;
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] bool is_known(int i) const { return solution_.start.lidar_known[index(i)] != 0; }
  [[nodiscard]] const SE3& place(int i) const { return solution_.state.T_base_sensor[index(i)]; }
  [[nodiscard]] double angle(int found, int guessed) const {
    return rotation_distance(place(found).R, guess_[index(guessed)]->R);
  }
  [[nodiscard]] bool is_astray(int i) const { return guess_[index(i)] && is_known(i) && angle(i, i) > astray_rad; }

  // Nothing where it stands near its own.
  [[nodiscard]] std::optional<int> stands_at(int lidar) const {
    if (!is_astray(lidar)) return std::nullopt;
    std::optional<int> nearest;
    double least = 0.5 * angle(lidar, lidar);
    for (int k = 0; k < static_cast<int>(guess_.size()); ++k) {
      if (k == lidar || !is_astray(k) || angle(lidar, k) >= least) continue;
      nearest = k;
      least = angle(lidar, k);
    }
    return nearest;
  }

  [[nodiscard]] bool are_inverses() const {
    double own = 0.0;
    double inverse = 0.0;
    bool one_is_astray = false;
    for (int i = 0; i < static_cast<int>(guess_.size()); ++i) {
      if (i == base_ || !guess_[index(i)] || !is_known(i)) continue;
      const SE3 other = guess_[index(i)]->inverse();
      const double off_rad = rotation_distance(place(i).R, other.R);
      const double off_m = (place(i).t - other.t).norm();
      if (off_rad > astray_rad || off_m > astray_m) return false;
      const double own_m = (place(i).t - guess_[index(i)]->t).norm();
      one_is_astray = one_is_astray || angle(i, i) > astray_rad || own_m > astray_m;
      inverse += off_m + metres_per_rad * off_rad;
      own += own_m + metres_per_rad * angle(i, i);
    }
    return one_is_astray && inverse < clearly_nearer * own;
  }

  [[nodiscard]] std::optional<int> same_place_as(int lidar) const {
    for (int k = 0; k < static_cast<int>(guess_.size()); ++k) {
      if (k == lidar || (k != base_ && !is_known(k))) continue;
      if (rotation_distance(place(lidar).R, place(k).R) < same_rad && (place(lidar).t - place(k).t).norm() < same_m)
        return k;
    }
    return std::nullopt;
  }

  const std::vector<std::optional<SE3>>& guess_;
  const LidarSolution& solution_;
  int base_;
};

}  // namespace

std::vector<PlaceFindings> place_findings(const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                          const LidarSolution& solution, int base) {
  return PlaceFinder(guess_T_base_sensor, solution, base).run();
}

}  // namespace rigcal
