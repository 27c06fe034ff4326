#include "apps/capture/machine_checks.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>

#include "apps/capture/table_recorder.h"
#include "drivers/camera/aravis/usb_cameras.h"
#include "drivers/net/privileges.h"
#include "drivers/trigger/pps.h"
#include "drivers/turntable/serial_port.h"

namespace rigcal {
namespace {

constexpr int usbfs_needed_mb = 256;  // Two cameras, each with a second of images of 1.3 MB at 60 frames/s.
constexpr const char* trigger_line = "trigger line";

/// What installs the rules, and whom they are for.
struct Mend {
  std::string rules;
  [[nodiscard]] std::string for_group() const { return rules + "; then: sudo adduser $USER plugdev, and log in again"; }
};

Check check_usb_memory(int found_mb, const Mend& mend) {
  const std::string has = "USB devices may have " + std::to_string(found_mb) + " MiB for transfers";
  if (found_mb == 0 || found_mb >= usbfs_needed_mb)
    return {CheckLevel::good, "USB memory", found_mb == 0 ? "USB devices may have any memory for transfers" : has, {}};
  return {CheckLevel::warning, "USB memory", has + ", too little for the images of a USB3 camera",
          "for now: echo 1000 | sudo tee /sys/module/usbcore/parameters/usbfs_memory_mb; for good: " + mend.rules};
}

Check check_realtime(std::optional<int> priority, const Mend& mend) {
  if (!priority) return {CheckLevel::good, "real time", "this user may ask for any priority", {}};
  const std::string may = "this user may ask for a real-time priority of up to " + std::to_string(*priority);
  if (*priority >= net::kRealtimePriority) return {CheckLevel::good, "real time", may, {}};
  return {CheckLevel::warning, "real time",
          *priority == 0
              ? "this user may not ask for real-time priority: pulses and packets can be late by milliseconds"
              : may + ", " + std::to_string(net::kRealtimePriority) + " is needed",
          mend.for_group()};
}

Check check_chip(const trigger::GpioChip& chip, const Mend& mend) {
  const std::string name = "GPIO " + chip.name;
  if (chip.refusal == 0) return {CheckLevel::good, name, chip.label + ", " + std::to_string(chip.lines) + " lines", {}};
  if (chip.refusal == EACCES || chip.refusal == EPERM)
    return {CheckLevel::warning, name, "this user may not use it", mend.for_group()};
  return {CheckLevel::warning, name, "it cannot be opened", "look at what the kernel says of it: sudo dmesg"};
}

Check check_line(const LineFinding& line, const std::vector<trigger::GpioChip>& chips, const Mend& mend) {
  const std::string name = line.address.chip + ", line " + std::to_string(line.address.line);
  if (!line.use) {
    const Error& error = line.use.error();
    const bool is_refused = std::any_of(chips.begin(), chips.end(), [](const trigger::GpioChip& chip) {
      return chip.refusal == EACCES || chip.refusal == EPERM;
    });
    return {CheckLevel::bad, trigger_line, name + ": " + error.what, is_refused ? mend.for_group() : error.mend};
  }
  if (line.use->is_used)
    return {CheckLevel::bad, trigger_line,
            name + " is held by " + (line.use->consumer.empty() ? "another program" : line.use->consumer),
            "end that program, or take another line"};
  return {CheckLevel::good, trigger_line, name + " is free", {}};
}

Check check_pps(const PpsFinding& pps, const Mend& mend) {
  if (pps.is_allowed) return {CheckLevel::good, "PPS", pps.device + " can be read", {}};
  return {CheckLevel::warning, "PPS", "this user may not read " + pps.device, mend.for_group()};
}

// Of the rig's trigger; `/dev/pps0` and `pps0` are the same.
Check check_pps_of_rig(const std::string& wanted, const std::vector<PpsFinding>& found, const Mend& mend) {
  const std::string device = wanted.starts_with("/") ? wanted : "/dev/" + wanted;
  const auto here =
      std::find_if(found.begin(), found.end(), [&](const PpsFinding& pps) { return pps.device == device; });
  if (here != found.end()) {
    Check check = check_pps(*here, mend);
    if (check.level != CheckLevel::good) check.level = CheckLevel::bad;
    return check;
  }
  return {CheckLevel::bad, "PPS", "there is no " + device,
          "load the driver of its input: sudo modprobe pps-gpio, or for a serial port: sudo ldattach PPS /dev/ttyS0"};
}

Check check_table(const Expected<void>& table, const Rig* rig) {
  const std::string port = rig != nullptr && rig->turntable ? rig->turntable->port : "its port";
  if (table) return {CheckLevel::good, "turntable", port + " can be used", {}};
  return {CheckLevel::bad, "turntable", port + ": " + table.error().what, table.error().mend};
}

}  // namespace

MachineFindings find_machine(const Rig* rig) {
  MachineFindings findings;
  findings.chips = trigger::list_chips();
  for (const std::string& device : trigger::list_pps())
    findings.pps.push_back({device, access(device.c_str(), R_OK | W_OK) == 0});
  findings.has_usb_camera = !camera::list_usb_cameras().empty();
  int memory = 0;
  if (std::ifstream("/sys/module/usbcore/parameters/usbfs_memory_mb") >> memory) findings.usbfs_memory_mb = memory;
  rlimit limit{};
  if (geteuid() != 0 && getrlimit(RLIMIT_RTPRIO, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    findings.realtime_priority = static_cast<int>(std::min<rlim_t>(limit.rlim_cur, 99));
  if (const auto table = rig == nullptr ? std::nullopt : table_options(*rig)) {
    const auto port = turntable::SerialPort::open(table->port, table->baud);
    findings.table = port ? Expected<void>() : Expected<void>(port.error());
  }
  if (rig == nullptr || !rig->trigger || rig->trigger->gpiochip.empty()) return findings;
  for (const std::optional<int>& line : {rig->trigger->line, rig->trigger->strobe_line}) {
    if (!line) continue;
    const trigger::LineAddress address{rig->trigger->gpiochip, static_cast<unsigned>(*line)};
    findings.lines.push_back({address, trigger::line_use(address)});
  }
  return findings;
}

std::vector<Check> check_machine(const MachineFindings& findings, const Rig* rig, const std::string& script) {
  const Mend mend{"sudo " + script};
  const bool has_trigger = rig != nullptr && rig->trigger.has_value();
  std::vector<Check> checks;
  if (rig == nullptr) {
    for (const trigger::GpioChip& chip : findings.chips) checks.push_back(check_chip(chip, mend));
    for (const PpsFinding& pps : findings.pps) checks.push_back(check_pps(pps, mend));
  }
  for (const LineFinding& line : findings.lines) checks.push_back(check_line(line, findings.chips, mend));
  if (findings.table) checks.push_back(check_table(*findings.table, rig));
  if (has_trigger && !rig->trigger->pps.empty())
    checks.push_back(check_pps_of_rig(rig->trigger->pps, findings.pps, mend));
  if ((rig == nullptr || findings.has_usb_camera) && findings.usbfs_memory_mb)
    checks.push_back(check_usb_memory(*findings.usbfs_memory_mb, mend));
  if (rig == nullptr || has_trigger) checks.push_back(check_realtime(findings.realtime_priority, mend));
  return checks;
}

}  // namespace rigcal
