#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/capture/doctor.h"
#include "drivers/trigger/gpio_line.h"

/// What `rigcal doctor` judges of the machine besides its network: trigger lines, PPS, USB memory, real-time priority,
/// the port of a turntable. Pure but for `find_machine`.
namespace rigcal {

struct PpsFinding {
  std::string device;
  bool is_allowed = false;  ///< This user may open it.
};

/// A line that the rig file names, as it was found.
struct LineFinding {
  trigger::LineAddress address;
  Expected<trigger::LineUse> use = trigger::LineUse{};
};

struct MachineFindings {
  std::vector<trigger::GpioChip> chips;
  std::vector<PpsFinding> pps;
  std::vector<LineFinding> lines;        ///< Of the rig's trigger: output, then strobe.
  std::optional<Expected<void>> table;   ///< Whether the serial port of the rig's turntable can be used.
  bool has_usb_camera = false;           ///< One is plugged in.
  std::optional<int> usbfs_memory_mb;    ///< Nothing: this kernel has no USB; 0: no limit.
  std::optional<int> realtime_priority;  ///< The highest that this user may ask for; nothing: any.
};

/// Looks at this machine; the lines only where the rig has a trigger, the port where it has a table on one. Nothing is
/// taken or changed, but many a table starts anew when its port is opened.
[[nodiscard]] MachineFindings find_machine(const Rig* rig);

/// Without a rig: what is less than good for any. With one: what this rig needs. `script`: what installs the rules.
[[nodiscard]] std::vector<Check> check_machine(const MachineFindings& findings, const Rig* rig,
                                               const std::string& script);

}  // namespace rigcal
