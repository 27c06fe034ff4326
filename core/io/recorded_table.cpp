#include "core/io/recorded_table.h"

#include <string_view>

#include "core/io/session_folder.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

constexpr std::size_t max_bytes = std::size_t{256} << 20U;

// Zeros with a whole line behind them are no torn end but damage, which the parser names.
bool ends_in_zeros(std::string_view text) {
  const std::size_t zero = text.find('\0');
  return zero != std::string_view::npos && text.find('\n', zero) >= text.size() - 1;
}

std::size_t whole_bytes(std::string_view text, const std::string& session) {
  if (ends_in_zeros(text)) return text.rfind('\n', text.find('\0')) + 1;  // 0 where there is none
  if (text.empty() || text.back() == '\n' || !is_unfinished_session(session)) return text.size();
  return text.rfind('\n') + 1;
}

}  // namespace

Expected<RecordedTable> read_recorded_table(const std::string& path, const std::string& session) {
  Expected<std::string> text = read_text_file(path, max_bytes);
  if (!text) return text.error();
  RecordedTable table{*std::move(text), {}};
  const std::size_t whole = whole_bytes(table.text, session);
  if (whole == table.text.size()) return table;
  table.torn = path + ": its last line is not whole, as a power cut leaves it, and was left out";
  table.text.resize(whole);
  return table;
}

}  // namespace rigcal
