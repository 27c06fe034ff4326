#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"

namespace rigcal::batch {

/// A recording of a batch and the name of its result folder.
struct Session {
  std::string name;
  std::string input;
};

/// The paths in a list: a line each, empty lines and those that begin with '#' left out; "-" is standard input. Errors:
/// unreadable.
[[nodiscard]] Expected<std::vector<std::string>> read_list(const std::string& path);

/// Names the recordings by the last part of their paths ("fleet/car7" is "car7"); those that share it by as many parts
/// as tell them apart ("car7_session"). In the order given. Errors: none given, one given twice, names that no parts
/// tell apart.
[[nodiscard]] Expected<std::vector<Session>> name_sessions(const std::vector<std::string>& inputs);

}  // namespace rigcal::batch
