#pragma once

#include <string>

namespace CLI {
class App;
}

namespace rigcal {

/// Scripts that complete commands, options and the words that an option takes; other arguments are files.
[[nodiscard]] std::string bash_completion(const CLI::App& program);
[[nodiscard]] std::string fish_completion(const CLI::App& program);
[[nodiscard]] std::string zsh_completion(const CLI::App& program);

}  // namespace rigcal
