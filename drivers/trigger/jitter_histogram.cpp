#include "drivers/trigger/jitter_histogram.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace rigcal::trigger {
namespace {

std::string time_text(double time_ns) {
  char text[32];
  const bool is_long = std::abs(time_ns) >= 1e6;
  std::snprintf(text, sizeof text, "%.4g %s", time_ns / (is_long ? 1e6 : 1e3), is_long ? "ms" : "us");
  return text;
}

}  // namespace

void JitterHistogram::add(std::int64_t off_ns) {
  const auto value = static_cast<double>(off_ns);
  const auto* end =
      std::lower_bound(kEnds_ns.begin(), kEnds_ns.end(), std::abs(value),
                       [](std::int64_t bin, double distance) { return static_cast<double>(bin) < distance; });
  ++bins_[static_cast<std::size_t>(end - kEnds_ns.begin())];
  least_ = count_ == 0 ? off_ns : std::min(least_, off_ns);
  most_ = count_ == 0 ? off_ns : std::max(most_, off_ns);
  ++count_;
  const double before = mean_;
  mean_ += (value - mean_) / static_cast<double>(count_);
  squares_ += (value - before) * (value - mean_);
}

double JitterHistogram::mean_ns() const { return mean_; }

double JitterHistogram::deviation_ns() const {
  return count_ == 0 ? 0.0 : std::sqrt(squares_ / static_cast<double>(count_));
}

std::string JitterHistogram::text() const {
  if (count_ == 0) return "no pulses\n";
  constexpr std::uint64_t widest = 50;
  const auto* const last = std::find_if(bins_.rbegin(), bins_.rend(), [](std::uint64_t bin) { return bin > 0; }).base();
  const auto* const first = std::find_if(bins_.begin(), bins_.end(), [](std::uint64_t bin) { return bin > 0; });
  const std::uint64_t highest = *std::max_element(bins_.begin(), bins_.end());
  std::string text;
  for (const auto* bin = first; bin != last; ++bin) {
    const auto index = static_cast<std::size_t>(bin - bins_.begin());
    const bool is_beyond = index == kEnds_ns.size();
    const std::int64_t end = kEnds_ns[is_beyond ? index - 1 : index];
    char line[64];
    std::snprintf(line, sizeof line, "%s %-8s %8llu ",
                  is_beyond ? "> " : "<=", time_text(static_cast<double>(end)).c_str(),
                  static_cast<unsigned long long>(*bin));
    text += line + std::string((*bin * widest + highest - 1) / highest, '#') + '\n';
  }
  return text + std::to_string(count_) + " pulses: mean " + time_text(mean_) + ", standard deviation " +
         time_text(deviation_ns()) + ", from " + time_text(static_cast<double>(least_)) + " to " +
         time_text(static_cast<double>(most_)) + "\n";
}

}  // namespace rigcal::trigger
