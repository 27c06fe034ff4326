// Bare numbers: a line a sensor.
#include "core/base/text.h"
#include "core/report/result_writers.h"

namespace rigcal {

std::string mlcc_lines(const PlacedRig& rig) {
  std::string text;
  for (const PlacedSensor& sensor : rig.sensors) {
    const Vector3d& t = sensor.T_base_sensor.t;
    const Eigen::Vector4d q = xyzw_from_rotation(sensor.T_base_sensor.R);
    std::string line;
    for (const double value : {t.x(), t.y(), t.z(), q[3], q[0], q[1], q[2]}) {
      line += (line.empty() ? "" : " ") + number_text(value);
    }
    // Its reader takes what follows a last line end for one more pose.
    text += (text.empty() ? "" : "\n") + line;
  }
  return text;
}

}  // namespace rigcal
