// Every rigcal command that the documentation shows is tried: those of the first run to their end, the others as far as
// the program gets without their inputs, or in two seconds, which is past its command line. Those within a sentence are
// only read as command lines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <regex>
#include <string>
#include <vector>

#include "apps/commands/command_line.h"
#include "tests/support/run_program.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

// The arguments of the commands in the shell blocks of a page.
std::vector<std::string> commands_of(const fs::path& page) {
  std::vector<std::string> found;
  std::ifstream in(page);
  bool shell = false;
  std::string open;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("```", 0) == 0) {
      shell = !shell && line == "```sh";
      continue;
    }
    if (!shell) continue;
    open += line;
    if (!open.empty() && open.back() == '\\') {
      open.back() = ' ';
      continue;
    }
    static const std::regex command("^\\s*(?:build/release/)?rigcal\\s+([^#]*)");
    std::smatch match;
    if (std::regex_search(open, match, command)) found.push_back(match[1]);
    open.clear();
  }
  return found;
}

// Those between backticks outside of blocks, which may go on in the next line. One with a word in capitals (SESSION,
// DIR, N) or with "..." is a form, no command.
std::vector<std::string> commands_in_sentences_of(const fs::path& page) {
  std::ifstream in(page);
  std::string text;
  bool block = false;
  for (std::string line; std::getline(in, line);) {
    const bool fence = line.rfind("```", 0) == 0;
    if (fence) block = !block;
    if (!block && !fence) text += line + " ";
  }
  static const std::regex command("`(?:build/release/)?rigcal\\s+([^`]*)`");
  static const std::regex form("\\b[A-Z]+\\b|\\.\\.\\.");
  std::vector<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), command), end; at != end; ++at) {
    const std::string arguments = (*at)[1];
    if (!std::regex_search(arguments, form)) found.push_back(arguments);
  }
  return found;
}

// What is wrong with a command line; empty: nothing. A sentence may leave out what its command asks for.
std::string why_not_taken(const std::string& arguments) {
  ConsoleReporter reporter(std::cerr);
  CommandContext context{reporter, {}, false, false, {}};
  GlobalOptions options;
  CLI::App app;
  describe_command_line(app, context, options);
  try {
    app.parse(arguments);
  } catch (const CLI::RequiredError&) {
    // Thrown before what nobody knows is told.
    return app.remaining_size(true) == 0 ? "" : "there is no '" + app.remaining(true).front() + "'";
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? "" : error.what();
  }
  return {};
}

class DocumentedCommands : public testing::Test {
 protected:
  [[nodiscard]] ProgramRun run(const std::string& arguments, const std::string& before = "") const {
    fs::create_directories(here);
    return run_program("cd '" + here.string() + "' && " + before + " '" + RIGCAL_PROGRAM + "' " + arguments, scratch);
  }

  const fs::path root = RIGCAL_SOURCE_DIR;
  const fs::path scratch = scratch_folder("documented");
  const fs::path here = scratch / "here";
};

TEST_F(DocumentedCommands, AreCommandLinesThatTheProgramTakes) {
  std::vector<fs::path> pages{root / "README.md"};
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md" && entry.path().filename() != "first-run.md") pages.push_back(entry.path());
  }
  std::size_t tried = 0;
  for (const fs::path& page : pages) {
    for (const std::string& arguments : commands_of(page)) {
      ++tried;
      const ProgramRun said = run(arguments, "timeout --preserve-status --signal=INT --kill-after=60 2");
      fs::remove_all(here);  // What one has written is no input of the next.
      EXPECT_THAT(said.code, testing::AnyOf(0, 1, 3)) << page << ": rigcal " << arguments << "\n" << said.err;
    }
  }
  EXPECT_GT(tried, 15U);
}

TEST_F(DocumentedCommands, InSentencesAreCommandLinesToo) {
  std::vector<fs::path> pages{root / "README.md", root / "CONTRIBUTING.md"};
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  std::size_t read = 0;
  for (const fs::path& page : pages) {
    for (const std::string& arguments : commands_in_sentences_of(page)) {
      ++read;
      EXPECT_EQ("", why_not_taken(arguments)) << page << ": rigcal " << arguments;
    }
  }
  EXPECT_GT(read, 30U);
}

// The test above can find something.
TEST(WhyNotTaken, TellsWhatTheProgramDoesNotKnow) {
  EXPECT_EQ("", why_not_taken("experiment bound --rigs 36"));
  EXPECT_EQ("", why_not_taken("simulate --live"));
  EXPECT_NE("", why_not_taken("experiment bound --rigs many"));
  EXPECT_NE("", why_not_taken("experiment bound --basin"));
  EXPECT_NE("", why_not_taken("experiment limits"));
  EXPECT_NE("", why_not_taken("simulate --lives"));
  EXPECT_NE("", why_not_taken("simulated --live"));
}

TEST_F(DocumentedCommands, OfTheFirstRunDoWhatItSays) {
  const std::vector<std::string> commands = commands_of(root / "docs/first-run.md");
  ASSERT_GE(commands.size(), 8U);
  for (const std::string& arguments : commands) {
    const ProgramRun said = run(arguments);
    // Only the comparison is to find something.
    EXPECT_EQ(said.code, &arguments == &commands.back() ? 1 : 0) << "rigcal " << arguments << "\n" << said.err;
  }
  EXPECT_TRUE(fs::exists(here / "result/report.html"));
}

}  // namespace
}  // namespace rigcal
