#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace rigcal {

/// A summary as `--json` prints it. Paths and names are bytes from outside: those that are no UTF-8 become U+FFFD and
/// are not thrown at us when the work is done.
template <class Json>
[[nodiscard]] std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rigcal
