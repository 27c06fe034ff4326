#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/pcd_file.h"

namespace rigcal {

/// What is lost of the clouds of a LiDAR, all of them together, by whoever reads them.
class CloudFlaws {
 public:
  void add(const PcdSummary& cloud);
  /// In sentences that begin with the LiDAR's name.
  [[nodiscard]] std::vector<std::string> warnings(const std::string& name) const;

 private:
  IntensityRange intensity_;
  std::uint64_t not_finite_ = 0;
  bool moved_ = false;  ///< A VIEWPOINT that is not the identity.
};

}  // namespace rigcal
