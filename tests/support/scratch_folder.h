#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace rigcal {

/// An empty folder for the test that runs, or for the suite that is set up, and for no other process; whoever asks for
/// it removes it.
[[nodiscard]] inline std::filesystem::path scratch_folder(const std::string& name) {
  std::string folder = "rigcal_" + name + "_" + std::to_string(getpid());
  if (const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info())
    folder += std::string("_") + test->name();
  std::replace(folder.begin(), folder.end(), '/', '_');
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / folder;
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path;
}

}  // namespace rigcal
