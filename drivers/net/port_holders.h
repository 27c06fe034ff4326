#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/records/records.h"

namespace rigcal::net {

/// A socket that is bound to a UDP port of this machine.
struct PortHolder {
  Endpoint local;  ///< Address 0.0.0.0: all of them.
  std::uint32_t uid = 0;
  int pid = 0;          ///< 0: of a program that this user may not look into.
  std::string program;  ///< Its short name; empty where `pid` is 0.
};

/// Who has a UDP port over IPv4, from the tables of the system in `proc`; empty where nobody has it or the system does
/// not say.
[[nodiscard]] std::vector<PortHolder> port_holders(std::uint16_t port, const std::string& proc = "/proc");

/// "ptp4l (process 812) on 0.0.0.0", several parted by commas.
[[nodiscard]] std::string holders_text(const std::vector<PortHolder>& holders);

}  // namespace rigcal::net
