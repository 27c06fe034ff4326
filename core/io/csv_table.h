#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/parse_number.h"

namespace rigcal {

/// One line of a table of values with commas between them; the views live as long as the text they came from.
struct CsvRow {
  int line = 0;
  std::size_t begin = 0;  ///< Where it begins in the text.
  std::vector<std::string_view> values;

  /// A value as a whole number (int64, int) or a finite double; nothing where it is none.
  template <class Number>
  [[nodiscard]] std::optional<Number> number(std::size_t column) const {
    return parse_number<Number>(values[column]);
  }
};

/// The lines after the header, which must be exactly `header`; empty lines are left out. Lines may end in CR LF. There
/// are no quotes: none of our tables has a text with a comma. Errors name "name:line": another header, a line with more
/// or fewer values.
[[nodiscard]] Expected<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view header,
                                                      const std::string& name);

/// The same of a table that may be damaged from some line on.
struct CsvTable {
  std::vector<CsvRow> rows;    ///< Before the first line that is wrong.
  std::optional<Error> error;  ///< What is wrong with that; nothing where all are right.
  std::size_t good_bytes = 0;  ///< Where that line begins; all of the text where all are right.
};
[[nodiscard]] CsvTable parse_damaged_csv(std::string_view text, std::string_view header, const std::string& name);

}  // namespace rigcal
