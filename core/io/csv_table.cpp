#include "core/io/csv_table.h"

#include <algorithm>

namespace rigcal {
namespace {

std::vector<std::string_view> split(std::string_view line, std::size_t most) {
  std::vector<std::string_view> values;
  for (;;) {
    const std::size_t comma = line.find(',');
    values.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos || values.size() > most) return values;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

CsvTable parse_damaged_csv(std::string_view text, std::string_view header, const std::string& name) {
  const auto columns = static_cast<std::size_t>(std::count(header.begin(), header.end(), ',')) + 1;
  CsvTable table;
  bool begun = false;
  int number = 0;
  const auto fail = [&](const std::string& what, const std::string& mend) {
    table.error = input_error(what, name + ":" + std::to_string(number), mend);
    return table;
  };
  while (table.good_bytes < text.size()) {
    ++number;
    const std::size_t begin = table.good_bytes;
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = text.substr(begin, end - begin);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty() && !begun) {
      if (line != header) return fail("the first line is not the header", "write " + std::string(header));
      begun = true;
    } else if (!line.empty()) {
      CsvRow row{number, begin, split(line, columns)};
      if (row.values.size() != columns) {
        return fail("the line has not " + std::to_string(columns) + " values",
                    "write " + std::string(header) + ", with nothing between the commas where it is not known");
      }
      table.rows.push_back(std::move(row));
    }
    table.good_bytes = std::min(end + 1, text.size());
  }
  if (!begun) table.error = input_error("is empty", name, "begin it with the line " + std::string(header));
  return table;
}

Expected<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view header, const std::string& name) {
  CsvTable table = parse_damaged_csv(text, header, name);
  if (table.error) return *table.error;
  return std::move(table.rows);
}

}  // namespace rigcal
