#include "core/camera/joint_histogram.h"

#include <cmath>

namespace rigcal {

// In nats; `of_grey` are the shares of the grey bins.
struct JointHistogram::Entropies {
  double total = 0.0;
  double code = 0.0;
  double grey = 0.0;
  double joint = 0.0;
  std::array<double, grey_bins> of_grey{};

  [[nodiscard]] double distance() const { return joint > 1e-9 ? 2.0 - (code + grey) / joint : 1.0; }
};

JointHistogram& JointHistogram::operator+=(const JointHistogram& other) {
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
  return *this;
}

JointHistogram::Entropies JointHistogram::entropies() const {
  Entropies e;
  const auto plus = [](double share) { return share > 0.0 ? -share * std::log(share) : 0.0; };
  e.total = total();
  if (!(e.total > 0.0)) return e;
  for (std::size_t code = 0; code < surface_codes_count; ++code) {
    double of_code = 0.0;
    for (std::size_t bin = 0; bin < grey_bins; ++bin) {
      const double share = counts_[code * grey_bins + bin] / e.total;
      if (share == 0.0) continue;
      of_code += share;
      e.of_grey[bin] += share;
      e.joint += plus(share);
    }
    e.code += plus(of_code);
  }
  for (const double share : e.of_grey) e.grey += plus(share);
  return e;
}

double JointHistogram::distance() const { return entropies().distance(); }

double JointHistogram::distance(std::vector<float>& by_count) const {
  const Entropies e = entropies();
  by_count.assign(counts_.size(), 0.0F);
  if (!(e.joint > 1e-9)) return 1.0;
  const double ratio = (e.code + e.grey) / e.joint;
  std::array<double, grey_bins> log_grey{};
  for (std::size_t bin = 0; bin < grey_bins; ++bin) log_grey[bin] = std::log(std::max(e.of_grey[bin], 1e-12));
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    // What all counts of one code have in common cancels, as a sample always counts as one; so does its entropy.
    const double log_joint = std::log(std::max(counts_[i] / e.total, 1e-12));
    by_count[i] = static_cast<float>((log_grey[i % grey_bins] - ratio * log_joint) / e.joint);
  }
  return e.distance();
}

double JointHistogram::total() const {
  double sum = 0.0;
  for (const float count : counts_) sum += count;
  return sum;
}

}  // namespace rigcal
