// docs/licences.md has a row for every package that rigcal is built with, and for no other.
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>

namespace rigcal {
namespace {

const std::string root = RIGCAL_SOURCE_DIR;

TEST(Licences, NameEveryPackageWithItsLicence) {
  std::set<std::string> packages;
  std::ifstream list(root + "/cmake/debian-packages.txt");
  for (std::string line; std::getline(list, line);) {
    if (!line.empty() && line[0] != '#') packages.insert(line);
  }
  ASSERT_GT(packages.size(), 5U);
  std::set<std::string> rows;
  std::ifstream page(root + "/docs/licences.md");
  for (std::string line; std::getline(page, line);) {
    if (line.rfind("| `", 0) != 0) continue;
    const std::size_t end = line.find("` | ");
    ASSERT_NE(end, std::string::npos) << line;
    const std::size_t licence_end = line.find(" | ", end + 4);
    ASSERT_NE(licence_end, std::string::npos) << line;
    EXPECT_GT(licence_end, end + 4) << "no licence: " << line;
    EXPECT_TRUE(rows.insert(line.substr(3, end - 3)).second) << "twice: " << line;
  }
  for (const std::string& package : packages) {
    EXPECT_TRUE(rows.contains(package)) << package << ": add its licence to docs/licences.md";
  }
  for (const std::string& row : rows) {
    EXPECT_TRUE(packages.contains(row)) << row << " in docs/licences.md is no package of cmake/debian-packages.txt";
  }
}

}  // namespace
}  // namespace rigcal
