#include "core/board/image_bytes.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/median.h"

namespace rigcal {
namespace {

// 1 for all but dark images.
float gain_of(const GreyImage& grey) {
  std::vector<float> values;
  for (std::size_t k = 0; k < grey.values.size(); k += 7) values.push_back(grey.values[k]);
  if (values.empty()) return 1.0F;
  const float bright = of_rank(values, values.size() * 49 / 50);
  constexpr float dark = 100.0F;
  return bright < dark ? std::min(20.0F, 204.0F / std::max(1.0F, bright)) : 1.0F;
}

}  // namespace

cv::Mat bytes_of(const GreyImage& grey) {
  const float gain = gain_of(grey);
  cv::Mat out(grey.height, grey.width, CV_8UC1);
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      out.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(gain * grey.at(x, y));
    }
  }
  return out;
}

}  // namespace rigcal
