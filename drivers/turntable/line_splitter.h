#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace rigcal::turntable {

/// Bytes of a serial line as they come, into lines without their ends. Bytes that are no printable ASCII are left out;
/// a line that is longer than any table's is cut, so that noise on the wire costs no memory.
class LineSplitter {
 public:
  static constexpr std::size_t kLongest = 256;

  /// The lines that end within these bytes; empty ones are left out.
  [[nodiscard]] std::vector<std::string> add(std::string_view bytes);

 private:
  std::string line_;
};

/// The number that `text` begins with, after blanks; nothing where there is none or it is out of any table's range
/// (a million degrees).
[[nodiscard]] bool read_number(std::string_view text, double& value);

}  // namespace rigcal::turntable
