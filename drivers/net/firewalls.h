#pragma once

#include <string>
#include <vector>

namespace rigcal::net {

/// A firewall that is switched on, and how it is told to let a network's UDP in.
struct Firewall {
  std::string name;
  std::string mend;
};

/// The usual ones, as far as their files below `root` show it. A system whose rules are loaded by other means is not
/// seen.
[[nodiscard]] std::vector<Firewall> active_firewalls(const std::string& root = "/");

}  // namespace rigcal::net
