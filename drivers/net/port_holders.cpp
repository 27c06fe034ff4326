#include "drivers/net/port_holders.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "core/base/parse_number.h"

namespace rigcal::net {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_holders = 16;

// "0100007F:D6D8": the address as the machine's own number (little-endian here), the port as a number.
bool parse_local(std::string_view text, Endpoint& local) {
  const std::size_t colon = text.find(':');
  if (colon == text.npos) return false;
  const auto address = parse_number<std::uint32_t>(text.substr(0, colon), 16);
  const auto port = parse_number<std::uint16_t>(text.substr(colon + 1), 16);
  if (!address || !port) return false;
  for (std::size_t i = 0; i < local.ip.size(); ++i) local.ip[i] = static_cast<std::uint8_t>(*address >> (8U * i));
  local.port = *port;
  return true;
}

// The number in "socket:[12345]".
std::uint64_t socket_of(const fs::path& link) {
  std::error_code error;
  const std::string target = fs::read_symlink(link, error).string();
  if (error || !target.starts_with("socket:[") || !target.ends_with("]")) return 0;
  return parse_number<std::uint64_t>(std::string_view(target).substr(8, target.size() - 9)).value_or(0);
}

void find_programs(const std::string& proc, std::map<std::uint64_t, PortHolder>& by_inode) {
  std::error_code error;
  for (fs::directory_iterator process(proc, error), end; !error && process != end; process.increment(error)) {
    const auto pid = parse_number<int>(process->path().filename().string());
    if (!pid) continue;
    std::error_code closed;  // Of another user, or ended meanwhile.
    for (fs::directory_iterator entry(process->path() / "fd", closed); !closed && entry != end;
         entry.increment(closed)) {
      const auto found = by_inode.find(socket_of(entry->path()));
      if (found == by_inode.end() || found->second.pid != 0) continue;
      found->second.pid = *pid;
      std::ifstream name(process->path() / "comm");
      std::getline(name, found->second.program);
    }
  }
}

}  // namespace

std::vector<PortHolder> port_holders(std::uint16_t port, const std::string& proc) {
  std::ifstream table(fs::path(proc) / "net" / "udp");
  std::map<std::uint64_t, PortHolder> by_inode;
  std::string line;
  std::getline(table, line);  // The names of the columns.
  while (std::getline(table, line) && by_inode.size() < most_holders) {
    std::istringstream words(line);
    std::vector<std::string> columns;
    for (std::string word; columns.size() < 10 && words >> word;) columns.push_back(std::move(word));
    PortHolder holder;
    if (columns.size() < 10 || !parse_local(columns[1], holder.local) || holder.local.port != port) continue;
    const auto uid = parse_number<decltype(holder.uid)>(columns[7]);
    const auto inode = parse_number<std::uint64_t>(columns[9]);
    if (!uid || !inode) continue;
    holder.uid = *uid;
    by_inode[*inode] = holder;
  }
  if (!by_inode.empty()) find_programs(proc, by_inode);
  std::vector<PortHolder> holders;
  for (const auto& [inode, holder] : by_inode) holders.push_back(holder);
  return holders;
}

std::string holders_text(const std::vector<PortHolder>& holders) {
  std::string text;
  for (const PortHolder& holder : holders) {
    text += (text.empty() ? "" : ", ") +
            (holder.pid == 0 ? "a program of user " + std::to_string(holder.uid)
                             : holder.program + " (process " + std::to_string(holder.pid) + ")") +
            " on " + to_string(holder.local.ip);
  }
  return text;
}

}  // namespace rigcal::net
