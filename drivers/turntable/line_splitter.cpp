#include "drivers/turntable/line_splitter.h"

#include <charconv>
#include <cmath>
#include <utility>

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
  double read = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), read);
  if (error != std::errc{} || end == text.data() || !std::isfinite(read) || std::abs(read) > most_degrees) return false;
  value = read;
  return true;
}

}  // namespace rigcal::turntable
