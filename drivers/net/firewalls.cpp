#include "drivers/net/firewalls.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

namespace rigcal::net {
namespace {

namespace fs = std::filesystem;

bool is_ufw_on(const fs::path& root) {
  std::ifstream in(root / "etc/ufw/ufw.conf");
  for (std::string line; std::getline(in, line);) {
    line.erase(std::remove_if(line.begin(), line.end(), [](unsigned char c) { return std::isspace(c) != 0; }),
               line.end());
    if (line == "ENABLED=yes") return true;
  }
  return false;
}

bool has_iptables_rules(const fs::path& root) {
  std::ifstream in(root / "proc/net/ip_tables_names");
  for (std::string table; std::getline(in, table);)
    if (table == "filter") return true;
  return false;
}

}  // namespace

std::vector<Firewall> active_firewalls(const std::string& root) {
  std::vector<Firewall> found;
  std::error_code error;
  if (is_ufw_on(root)) found.push_back({"ufw", "sudo ufw allow in on NAME proto udp from any (NAME: the interface)"});
  if (fs::exists(fs::path(root) / "run/firewalld", error) || fs::exists(fs::path(root) / "run/firewalld.pid", error))
    found.push_back({"firewalld", "sudo firewall-cmd --zone=trusted --change-interface=NAME (NAME: the interface)"});
  if (found.empty() && has_iptables_rules(root))
    found.push_back({"iptables", "sudo iptables -I INPUT -i NAME -p udp -j ACCEPT (NAME: the interface)"});
  return found;
}

}  // namespace rigcal::net
