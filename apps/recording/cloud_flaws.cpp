#include "apps/recording/cloud_flaws.h"

namespace rigcal {

void CloudFlaws::add(const PcdSummary& cloud) {
  intensity_.add(cloud.intensity);
  not_finite_ += cloud.not_finite;
  moved_ |= cloud.moved;
}

std::vector<std::string> CloudFlaws::warnings(const std::string& name) const {
  std::vector<std::string> out;
  if (const std::string complaint = intensity_.complaint(); !complaint.empty())
    out.push_back(name + ": its " + complaint);
  if (not_finite_ > 0)
    out.push_back(name + ": " + std::to_string(not_finite_) + " points with NaN or infinite coordinates left out");
  if (moved_) {
    out.push_back(name +
                  ": its clouds have a VIEWPOINT, which is not applied: their points are taken to be in the sensor's "
                  "frame");
  }
  return out;
}

}  // namespace rigcal
