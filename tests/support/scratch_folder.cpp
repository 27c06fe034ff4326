#include "tests/support/scratch_folder.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <cstdlib>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace rigcal {
namespace {

using std::filesystem::path;

path make_folder(const std::string& name) {
  std::string folder = path(testing::TempDir()) / ("rigcal_" + name + "_XXXXXX");
  if (mkdtemp(folder.data()) == nullptr)
    throw std::filesystem::filesystem_error("no scratch folder", folder, {errno, std::generic_category()});
  return folder;
}

/// Tidies up behind each test and each suite: GoogleTest tells it when all that they hold is gone.
class Tidier : public testing::EmptyTestEventListener {
 public:
  path add(const std::string& name) {
    const bool in_test = testing::UnitTest::GetInstance()->current_test_info() != nullptr;
    return (in_test ? of_test_ : of_suite_).emplace_back(make_folder(name));
  }
  /// One for all files of a test that want no folder of their own.
  path folder_of_files() {
    if (!files_) files_ = add("files");
    return *files_;
  }

  void OnTestEnd(const testing::TestInfo& /*test*/) override { remove(of_test_); }
  void OnTestSuiteEnd(const testing::TestSuite& /*suite*/) override { remove(of_suite_); }

 private:
  void remove(std::vector<path>& folders) {
    std::error_code ignored;
    for (const path& folder : folders)
      if (std::getenv("RIGCAL_KEEP_SCRATCH") == nullptr) std::filesystem::remove_all(folder, ignored);
    folders.clear();
    files_.reset();
  }

  std::vector<path> of_test_, of_suite_;
  std::optional<path> files_;
};

Tidier& tidier() {
  static Tidier* const made = [] {
    auto* listener = new Tidier;
    testing::UnitTest::GetInstance()->listeners().Append(listener);  // which takes it over
    return listener;
  }();
  return *made;
}

}  // namespace

path scratch_folder(const std::string& name) { return tidier().add(name); }

std::string fresh_path(const std::string& name) {
  const path file = tidier().folder_of_files() / name;
  std::filesystem::remove_all(file);
  return file;
}

}  // namespace rigcal
