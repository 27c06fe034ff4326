#include "drivers/turntable/line_splitter.h"

#include <cmath>
#include <utility>

#include "core/base/parse_number.h"

namespace rigcal::turntable {
namespace {

constexpr double most_degrees = 1e6;

}  // namespace

std::vector<std::string> LineSplitter::add(std::string_view bytes) {
  std::vector<std::string> lines;
  for (const char c : bytes) {
    if (c == '\n' || c == '\r') {
      if (!line_.empty()) lines.push_back(std::exchange(line_, {}));
    } else if (c >= ' ' && c <= '~' && line_.size() < kLongest) {
      line_ += c;
    }
  }
  return lines;
}

bool read_number(std::string_view text, double& value) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  if (text.starts_with('+')) text.remove_prefix(1);
  const std::optional<double> read = take_number<double>(text);
  if (!read || std::abs(*read) > most_degrees) return false;
  value = *read;
  return true;
}

}  // namespace rigcal::turntable
