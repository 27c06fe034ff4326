#include "core/corner/plane_votes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/median.h"
#include "core/start/surfels.h"

namespace rigcal {
namespace {

constexpr double enough_share = 0.4;  // of all points on surfels: their size fits the cloud
constexpr double same_way_cos = 0.95;
constexpr std::size_t most_asked = 400;
constexpr std::size_t least_surfels = 4;

struct Ballot {
  std::vector<Surfel> surfels;
  double size_m = 0.5;
  double sigma_m = 0.02;

  // A surfel's own mean is better known than its points; the plane may bend a little.
  [[nodiscard]] double gate_m() const { return 0.03 + 1.5 * sigma_m; }
};

double typical_sigma(const std::vector<Surfel>& surfels) {
  std::vector<double> variances;
  for (const Surfel& s : surfels) variances.push_back(s.variance);
  return std::sqrt(median(std::move(variances)));
}

Ballot open_ballot(const PatchCells& cells) {
  double total = 0.0;
  for (const Cell& cell : cells.cells) total += cell.N;
  Ballot ballot;
  for (const double size_m : {0.5, 1.0, 2.0}) {
    SurfelOptions options;
    options.size_m = size_m;
    options.min_points = 12.0;
    options.max_thickness_m = 0.3;
    std::vector<Surfel> surfels = extract_surfels(cells, options).surfels;
    double on_surfels = 0.0;
    for (const Surfel& s : surfels) on_surfels += s.N;
    if (surfels.size() > ballot.surfels.size() || on_surfels >= enough_share * total) {
      ballot.surfels = std::move(surfels);
      ballot.size_m = size_m;
    }
    if (on_surfels >= enough_share * total) break;
  }
  if (!ballot.surfels.empty()) ballot.sigma_m = typical_sigma(ballot.surfels);
  return ballot;
}

bool votes_for(const Surfel& s, const FittedPlane& plane, double gate_m) {
  return std::abs(s.normal.dot(plane.normal)) > same_way_cos && std::abs(plane.distance(s.mean)) < gate_m;
}

// A near surface has more points, not more surface.
double voice(const Surfel& s) { return std::sqrt(s.N); }

double voices_for(const Ballot& ballot, const std::vector<char>& taken, const FittedPlane& plane) {
  double sum = 0.0;
  for (std::size_t i = 0; i < ballot.surfels.size(); ++i) {
    if (!taken[i] && votes_for(ballot.surfels[i], plane, ballot.gate_m())) sum += voice(ballot.surfels[i]);
  }
  return sum;
}

FittedPlane plane_of(const Surfel& s) {
  FittedPlane plane;
  plane.normal = s.normal;
  plane.offset_m = s.normal.dot(s.mean);
  return plane;
}

std::optional<FittedPlane> best_candidate(const Ballot& ballot, const std::vector<char>& taken) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (!taken[i]) left.push_back(i);
  }
  const std::size_t count = std::min(left.size(), most_asked);
  std::optional<FittedPlane> best;
  double most = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const FittedPlane plane = plane_of(ballot.surfels[left[k * left.size() / count]]);
    const double voices = voices_for(ballot, taken, plane);
    if (voices <= most) continue;
    most = voices;
    best = plane;
  }
  return best;
}

// Fitted to the means of those that vote for it, until these stay the same.
std::optional<FittedPlane> elected(const Ballot& ballot, const std::vector<char>& taken, FittedPlane plane) {
  std::size_t before = 0;
  for (int k = 0; k < 8; ++k) {
    PointCluster means;
    std::size_t count = 0;
    double variance = 0.0;
    for (std::size_t i = 0; i < ballot.surfels.size(); ++i) {
      const Surfel& s = ballot.surfels[i];
      if (taken[i] || !votes_for(s, plane, ballot.gate_m())) continue;
      PointCluster one;
      one.add(s.mean);
      means += one.scaled(voice(s));
      variance += voice(s) * s.variance;
      ++count;
    }
    const auto fitted = count >= least_surfels ? fit_plane(means) : std::nullopt;
    if (!fitted) return std::nullopt;
    plane = *fitted;
    plane.sigma_m = std::sqrt(variance / means.N);
    if (count == before) break;
    before = count;
  }
  return plane;
}

}  // namespace

PlaneVotes vote_for_planes(const PatchCells& cells, std::size_t most) {
  const Ballot ballot = open_ballot(cells);
  PlaneVotes votes;
  votes.surfel_m = ballot.size_m;
  std::vector<char> taken(ballot.surfels.size(), 0);
  // Some candidates lead to nothing; their surfels are set aside.
  for (std::size_t round = 0; round < 3 * most && votes.planes.size() < most; ++round) {
    const auto candidate = best_candidate(ballot, taken);
    if (!candidate) break;
    const auto plane = elected(ballot, taken, *candidate);
    if (plane) votes.planes.push_back(*plane);
    const FittedPlane& done = plane ? *plane : *candidate;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      if (votes_for(ballot.surfels[i], done, 2.0 * ballot.gate_m())) taken[i] = 1;
    }
  }
  return votes;
}

}  // namespace rigcal
