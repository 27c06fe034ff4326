#pragma once

#include <optional>
#include <string>

#include "core/base/error.h"
#include "drivers/camera/aravis/device.h"
#include "drivers/camera/aravis/settings_log.h"
#include "drivers/camera/camera_config.h"

namespace rigcal::camera {

/// Sets a camera up, in the order in which cameras take it, and writes down what it changes.
class CameraSetter {
 public:
  CameraSetter(Device& device, SettingsLog& log) : device_(device), log_(log) {}

  /// Errors: what the camera cannot do, with what it can. What was set before the error stays set, and in the log.
  [[nodiscard]] Expected<CameraSetup> apply(const CameraConfig& config);

 private:
  struct Selected {
    std::string selector;
    std::string entry;
  };
  Expected<void> set(const std::string& feature, const std::string& value, const Selected& selected = {});
  Expected<void> set_if_there(const std::string& feature, const std::string& value, const Selected& selected = {});
  /// A number within the feature's limits; `what` and `unit` for the message.
  Expected<void> set_within(const std::string& feature, double value, const std::string& what, const std::string& unit);
  Expected<void> select(const std::string& selector, const std::string& entry);

  void end_what_was_left();
  Expected<void> leave_triggers();
  Expected<void> set_format(const std::string& wanted);
  Expected<void> set_region(const Region& region);
  Expected<void> set_light(const CameraConfig& config);
  Expected<void> set_rate(double frame_rate);
  void lift_rate_limit(std::optional<double> pulse_rate);
  Expected<void> set_trigger(const TriggerConfig& trigger);
  Expected<void> set_trigger_delay(double delay_us);
  Expected<void> set_packets(const CameraConfig& config);
  Expected<void> set_chunks();
  Expected<void> set_strobe(const std::string& line);
  Expected<void> set_ptp();
  Expected<CameraSetup> read_back(const CameraConfig& config);
  /// False where it has no such feature.
  [[nodiscard]] bool is_other_than(const std::string& feature, const std::string& value) const;
  [[nodiscard]] Error refused(std::string what, std::string mend) const;

  Device& device_;
  SettingsLog& log_;
  std::vector<std::string> notes_;
};

/// Puts back what a log says, the last change first, and clears it. Gives what could not be put back, a sentence each.
[[nodiscard]] std::vector<std::string> put_back(Device& device, const std::vector<OldSetting>& settings);

}  // namespace rigcal::camera
