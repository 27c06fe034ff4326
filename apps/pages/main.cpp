// Writes the man pages and the completions of rigcal into a folder; run when rigcal is built, so that they say what its
// command line really is.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>

#include "apps/commands/command_line.h"
#include "apps/pages/completion.h"
#include "apps/pages/man_page.h"

namespace {

void save(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: rigcal_pages FOLDER\n";
    return 2;
  }
  try {
    rigcal::ConsoleReporter reporter(std::cerr);
    rigcal::CommandContext context{reporter, {}, false, false, {}};
    rigcal::GlobalOptions options;
    CLI::App app;
    rigcal::describe_command_line(app, context, options);
    const std::filesystem::path folder = argv[1];
    save(folder / "man/man1/rigcal.1", rigcal::man_page(app, nullptr));
    for (const CLI::App* command : rigcal::commands_of(app)) {
      save(folder / "man/man1" / ("rigcal-" + command->get_name() + ".1"), rigcal::man_page(app, command));
    }
    save(folder / "bash-completion/completions/rigcal", rigcal::bash_completion(app));
    save(folder / "fish/vendor_completions.d/rigcal.fish", rigcal::fish_completion(app));
    save(folder / "zsh/site-functions/_rigcal", rigcal::zsh_completion(app));
  } catch (const std::exception& error) {
    std::cerr << "rigcal_pages: " << error.what() << "\n";
    return 4;
  }
  return 0;
}
