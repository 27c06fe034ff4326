#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"

namespace rigcal {

/// One line of a table of values with commas between them; the views live as long as the text they came from.
struct CsvRow {
  int line = 0;
  std::vector<std::string_view> values;

  /// A value as a whole number (int64, int) or a finite double; nothing where it is none.
  template <class Number>
  [[nodiscard]] std::optional<Number> number(std::size_t column) const;
};

/// The lines after the header, which must be exactly `header`; empty lines are left out. Lines may end in CR LF. There
/// are no quotes: none of our tables has a text with a comma. Errors name "name:line": another header, a line with more
/// or fewer values.
[[nodiscard]] Expected<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view header,
                                                      const std::string& name);

}  // namespace rigcal
