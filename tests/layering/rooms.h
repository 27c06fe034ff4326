#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

namespace rigcal::layering {

/// A room and the rooms that it may include directly; it may also include whatever they may.
using Table = std::map<std::string, std::vector<std::string>>;

/// The rooms of this house, as docs/architecture.md describes them.
[[nodiscard]] const Table& rooms();

/// The room itself and all rooms that it may include, directly or through others.
[[nodiscard]] std::set<std::string> may_include(const Table& table, const std::string& room);

/// The rooms of a table that may, in the end, include themselves.
[[nodiscard]] std::vector<std::string> rooms_in_a_circle(const Table& table);

/// What is wrong with the file `path` (from the root, with '/') whose text is `text`: one sentence each, with the
/// place. Looked at: #include lines against the table, third-party headers in public headers, length.
[[nodiscard]] std::vector<std::string> check_file(const Table& table, const std::string& path, const std::string& text);

}  // namespace rigcal::layering
