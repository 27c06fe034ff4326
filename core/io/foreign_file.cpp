#include "core/io/foreign_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr const char* convert_bag = "convert it to a ROS 1 bag, which is read (rosbags-convert does that)";
constexpr const char* put_in_folder = "a recording of clouds is a folder, with FOLDER/<sensor>/<stop>.pcd";

struct Kind {
  std::string_view begin;
  const char* what;
  const char* mend;
};
constexpr std::array<Kind, 6> kinds = {{
    {"SQLite format 3", "is a data base, as bags of ROS 2 are (.db3)", convert_bag},
    {"\x89MCAP0", "is an MCAP file, as bags of ROS 2 are", convert_bag},
    {"# .PCD", "is a single cloud (PCD)", put_in_folder},
    {"VERSION ", "is a single cloud (PCD)", put_in_folder},
    {"ply\n", "is a single cloud (PLY)", put_in_folder},
    {"LASF", "is a single cloud (LAS)", put_in_folder},
}};

}  // namespace

std::optional<Error> foreign_file_error(ByteView begin, const std::string& path) {
  for (const Kind& kind : kinds) {
    if (begin.size() >= kind.begin.size() &&
        std::equal(kind.begin.begin(), kind.begin.end(), begin.begin(),
                   [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }))
      return input_error(kind.what, path, kind.mend);
  }
  return std::nullopt;
}

std::optional<Error> foreign_folder_error(const std::string& path) {
  std::error_code error;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error)) {
    const std::string ending = entry->path().extension().string();
    if (ending == ".db3" || ending == ".mcap") return input_error("is a bag of ROS 2", path, convert_bag);
  }
  return std::nullopt;
}

}  // namespace rigcal
