#include "apps/ingest/point_filter.h"

#include <limits>

#include "drivers/livox_codec/sample_packet.h"

namespace rigcal {
namespace {

constexpr std::array<double, 2> livox_range_m{1.5, 200.0};

const std::array<std::uint8_t, 256>& noise_tags() {
  static const std::array<std::uint8_t, 256> table = [] {
    std::array<std::uint8_t, 256> values{};
    for (unsigned tag = 0; tag < values.size(); ++tag) {
      values[tag] = livox::is_noise(livox::decode_tag(static_cast<std::uint8_t>(tag))) ? 1 : 0;
    }
    return values;
  }();
  return table;
}

}  // namespace

PointFilter::PointFilter(bool livox, const std::optional<std::array<double, 2>>& range_m)
    : most_square_m2_(std::numeric_limits<float>::max()) {
  if (!livox && !range_m) return;
  const std::array<double, 2> range = range_m.value_or(livox_range_m);
  least_square_m2_ = static_cast<float>(range[0] * range[0]);
  most_square_m2_ = static_cast<float>(range[1] * range[1]);
}

// Without branches, as both noise and points out of range come scattered.
PointFilter::LeftOut PointFilter::apply(std::vector<Point>& points) const {
  const std::array<std::uint8_t, 256>& is_noise = noise_tags();
  std::size_t kept = 0;
  std::size_t noise = 0;
  for (const Point point : points) {
    const float square = point.x * point.x + point.y * point.y + point.z * point.z;
    const unsigned in_range =
        static_cast<unsigned>(square >= least_square_m2_) & static_cast<unsigned>(square <= most_square_m2_);
    const unsigned bad = is_noise[point.tag];
    points[kept] = point;
    kept += in_range & (bad ^ 1U);
    noise += bad;
  }
  const std::size_t out_of_range = points.size() - noise - kept;
  points.resize(kept);
  return {noise, out_of_range};
}

}  // namespace rigcal
