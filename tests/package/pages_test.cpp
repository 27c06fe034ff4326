// The man pages and completions against what the program itself says with --help.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/files.h"
#include "tests/support/run_program.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::Not;

class Pages : public testing::Test {
 protected:
  [[nodiscard]] ProgramRun run(const std::string& command) const { return run_program(command, scratch); }
  [[nodiscard]] std::string help(const std::string& command) const {
    const ProgramRun said = run_rigcal(command + " --help", scratch);
    EXPECT_EQ(said.code, 0);
    return said.out;
  }
  /// The options in a text; not "---" or what is glued to a word.
  [[nodiscard]] static std::set<std::string> options(const std::string& text) {
    static const std::regex pattern("(^|[\\s,])(--[a-z][a-z-]*)");
    std::set<std::string> names;
    for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) names.insert((*it)[2]);
    return names;
  }
  [[nodiscard]] std::vector<std::string> commands() const {
    std::vector<std::string> names;
    std::istringstream lines(help(""));
    bool listed = false;
    for (std::string line; std::getline(lines, line);) {
      if (line == "Subcommands:" || line == "SUBCOMMANDS:") {  // The latter since CLI11 2.5.
        listed = true;
      } else if (listed && line.rfind("  ", 0) == 0 && line[2] != ' ') {
        names.push_back(line.substr(2, line.find(' ', 2) - 2));
      } else if (line.empty() || line[0] != ' ') {
        listed = false;
      }
    }
    return names;
  }
  /// A page with its hyphens as plain text.
  [[nodiscard]] static std::string page(const std::string& name) {
    return std::regex_replace(text_of(fs::path(RIGCAL_PAGES) / "man/man1" / (name + ".1")), std::regex("\\\\-"), "-");
  }
  /// What bash offers for the last word.
  [[nodiscard]] std::set<std::string> offered(const std::string& words, int count) const {
    const std::string script =
        std::string("source '") + RIGCAL_PAGES + "/bash-completion/completions/rigcal'; COMP_WORDS=(" + words +
        "); COMP_CWORD=" + std::to_string(count - 1) + "; _rigcal; printf \"%s\\n\" \"${COMPREPLY[@]}\"";
    const ProgramRun said =
        run("cd '" + scratch.string() + "' && bash -c '" + std::regex_replace(script, std::regex("'"), "'\\''") + "'");
    EXPECT_EQ(said.code, 0) << said.err;
    std::istringstream lines(said.out);
    std::set<std::string> all;
    for (std::string line; std::getline(lines, line);) all.insert(line);
    return all;
  }

  fs::path scratch = scratch_folder("pages");
};

TEST_F(Pages, HaveEveryCommandAndEveryOptionOfTheHelp) {
  const std::vector<std::string> names = commands();
  EXPECT_THAT(names, Contains("calibrate"));
  const std::string program = page("rigcal");
  for (const std::string& option : options(help(""))) EXPECT_THAT(options(program), Contains(option));
  for (const std::string& name : names) {
    EXPECT_NE(program.find("rigcal-" + name), std::string::npos) << name;
    const std::set<std::string> in_page = options(page("rigcal-" + name));
    for (const std::string& option : options(help(name))) EXPECT_THAT(in_page, Contains(option)) << name;
    EXPECT_NE(page("rigcal-" + name).find(".SH EXAMPLES\n.nf\n  rigcal " + name), std::string::npos) << name;
  }
}

TEST_F(Pages, AreRightTroff) {
  if (run("command -v groff").code != 0) GTEST_SKIP() << "groff is not installed";
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(RIGCAL_PAGES) / "man/man1")) {
    const ProgramRun said = run("groff -man -Tutf8 -ww -z '" + entry.path().string() + "'");
    EXPECT_EQ(said.err, "") << entry.path();
  }
}

TEST_F(Pages, CompleteCommandsOptionsWordsAndFiles) {
  std::ofstream(scratch / "some.pcap") << "x";
  EXPECT_THAT(offered("rigcal cal", 2), testing::ElementsAre("calibrate"));
  EXPECT_THAT(offered("rigcal calibrate so", 3), testing::ElementsAre("some.pcap"));
  EXPECT_THAT(offered("rigcal calibrate some.pcap --st", 4), testing::ElementsAre("--stages"));
  EXPECT_THAT(offered("rigcal export x --format pat", 5), testing::ElementsAre("patches"));
  EXPECT_THAT(offered("rigcal --log-level w", 3), testing::ElementsAre("warning"));
  for (const std::string& name : commands()) {
    const std::set<std::string> all = offered("rigcal " + name + " --", 3);
    for (const std::string& option : options(help(name))) EXPECT_THAT(all, Contains(option)) << name;
    EXPECT_THAT(all, Contains("--json"));
  }
  EXPECT_THAT(offered("rigcal inspect --", 3), Not(Contains("--stages")));
}

TEST_F(Pages, AreKnownToZsh) {
  const std::string path = std::string(RIGCAL_PAGES) + "/zsh/site-functions/_rigcal";
  const std::string text = text_of(path);
  EXPECT_EQ(text.rfind("#compdef rigcal\n", 0), 0U);
  for (const std::string& name : commands()) {
    const std::size_t begin = text.find("\n      " + name + ") _arguments");
    ASSERT_NE(begin, std::string::npos) << name;
    const std::string part = text.substr(begin, text.find(" ;;", begin) - begin);
    for (const std::string& option : options(help(name))) {
      EXPECT_NE(part.find("'*" + option + "["), std::string::npos) << name << option;
    }
  }
  EXPECT_NE(text.find("'*--stages[Stop after poses, extrinsics, joint (all LiDARs) or cameras (default)]:word:(poses "),
            std::string::npos);
  if (run("command -v zsh").code != 0) GTEST_SKIP() << "zsh is not installed";
  EXPECT_EQ(run("zsh -n '" + path + "'").code, 0);
}

TEST_F(Pages, AreKnownToFish) {
  EXPECT_THAT(text_of(fs::path(RIGCAL_PAGES) / "fish/vendor_completions.d/rigcal.fish"),
              testing::HasSubstr("complete -c rigcal -n '__fish_seen_subcommand_from calibrate' -l rig -r"));
  if (run("command -v fish").code != 0) GTEST_SKIP() << "fish is not installed";
  EXPECT_EQ(run(std::string("fish --no-execute '") + RIGCAL_PAGES + "/fish/vendor_completions.d/rigcal.fish'").code, 0);
}

}  // namespace
}  // namespace rigcal
