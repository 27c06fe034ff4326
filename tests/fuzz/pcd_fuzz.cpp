// A point cloud of any bytes: no crash, no memory beyond what the file's size allows, every point counted.
#include <cmath>

#include "core/io/pcd_file.h"
#include "tests/fuzz/scratch_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const rigcal::ScratchFile file(bytes, size);
  const rigcal::Expected<rigcal::PcdCloud> cloud = rigcal::read_pcd(file.path());
  if (!cloud) return 0;
  if (cloud->points.size() != cloud->summary.points) __builtin_trap();
  for (const rigcal::Point& point : cloud->points) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) __builtin_trap();
  }
  return 0;
}
