#pragma once

#include <string>

namespace CLI {
class App;
}

namespace rigcal {

/// The man page of the program, or of one of its commands, from what its --help says; troff with the man macros.
[[nodiscard]] std::string man_page(const CLI::App& program, const CLI::App* command);

}  // namespace rigcal
