// Extrinsics, ground truth and trajectories of any bytes: no crash, rotations stay rotations.
#include <string>

#include "core/io/extrinsics_file.h"
#include "core/io/ground_truth.h"
#include "core/io/tum_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string text(bytes, bytes + size);
  const rigcal::Expected<rigcal::ExtrinsicsFile> file = rigcal::parse_extrinsics(text, "e.yaml");
  if (file) {
    for (const auto& [name, T] : file->T_base_sensor) {
      if (!((T.R * T.R.transpose() - rigcal::Matrix3d::Identity()).norm() < 1e-9)) __builtin_trap();
    }
  }
  static_cast<void>(rigcal::parse_ground_truth(text, "g.yaml").has_value());
  static_cast<void>(rigcal::parse_tum(text, "t.tum").has_value());
  return 0;
}
