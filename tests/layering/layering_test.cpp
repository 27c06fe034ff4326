// The arrows between the rooms of the house, read off the #include lines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/layering/rooms.h"
#include "tests/support/files.h"

namespace rigcal::layering {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const Table small{{"core/base", {}}, {"core/io", {"core/base"}}, {"core/report", {"core/io"}}, {"drivers/net", {}}};

TEST(Layering, HoldsInEveryFileOfTheTree) {
  const std::filesystem::path root = RIGCAL_SOURCE_DIR;
  int files = 0;
  for (const char* top : {"core", "drivers", "simdata", "apps", "tests"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / top)) {
      const std::string ending = entry.path().extension();
      if (ending != ".h" && ending != ".cpp") continue;
      const std::string path = std::filesystem::relative(entry.path(), root).generic_string();
      EXPECT_THAT(check_file(rooms(), path, text_of(entry.path())), IsEmpty());
      ++files;
    }
  }
  // A wrong root would check nothing and pass.
  EXPECT_GT(files, 30);
}

TEST(Layering, HasNoCircleInItsTable) { EXPECT_THAT(rooms_in_a_circle(rooms()), IsEmpty()); }

TEST(Layering, KeepsDriversAndAppsOutOfTheCore) {
  for (const auto& [room, _] : rooms()) {
    if (room.rfind("core/", 0) != 0) continue;
    for (const std::string& reached : may_include(rooms(), room)) EXPECT_EQ(reached.rfind("core/", 0), 0U) << room;
  }
}

TEST(LayeringCheck, FindsAnArrowThatGoesUp) {
  EXPECT_THAT(check_file(small, "core/io/pcap.cpp", "#include <vector>\n#include \"core/report/html.h\"\n"),
              ElementsAre("core/io/pcap.cpp:2: core/io may not include core/report"));
}

TEST(LayeringCheck, FindsADriverInTheCore) {
  EXPECT_THAT(check_file(small, "core/io/a.h", "  #  include \"drivers/net/socket.h\"\n"),
              ElementsAre(HasSubstr("core/io may not include drivers/net")));
}

TEST(LayeringCheck, AllowsARoomReachedThroughAnother) {
  EXPECT_THAT(check_file(small, "core/report/a.cpp", "#include \"core/base/error.h\"\n#include <yaml-cpp/yaml.h>\n"),
              IsEmpty());
}

TEST(LayeringCheck, FindsARoomThatIsMissingInTheTable) {
  EXPECT_THAT(check_file(small, "core/magic/a.cpp", ""), ElementsAre(HasSubstr("is no room")));
  EXPECT_THAT(check_file(small, "core/io/a.cpp", "#include \"core/magic/b.h\"\n"),
              ElementsAre(HasSubstr("names no room")));
}

TEST(LayeringCheck, FindsAnIncludeThatDoesNotStartAtTheRoot) {
  EXPECT_THAT(check_file(small, "core/io/a.cpp", "#include \"b.h\"\n"), ElementsAre(HasSubstr("names no room")));
}

TEST(LayeringCheck, FindsThirdPartyAndSystemHeadersInPublicHeaders) {
  EXPECT_THAT(check_file(small, "core/io/a.h", "#include <yaml-cpp/yaml.h>\n"),
              ElementsAre(HasSubstr("public header")));
  EXPECT_THAT(check_file(small, "drivers/net/a.h", "#include <pcap.h>\n"), ElementsAre(HasSubstr("public header")));
  EXPECT_THAT(check_file(small, "core/io/a.h", "#include <Eigen/Core>\n#include <vector>\n"), IsEmpty());
  EXPECT_THAT(check_file(small, "core/base/a.h", "#include <Eigen/Core>\n"),
              ElementsAre(HasSubstr("standard library")));
}

TEST(LayeringCheck, FindsAFileThatIsTooLong) {
  std::string text;
  for (int i = 0; i < 600; ++i) text += "\n";
  EXPECT_THAT(check_file(small, "core/io/a.cpp", text), IsEmpty());
  EXPECT_THAT(check_file(small, "core/io/a.cpp", text + "\n"), ElementsAre(HasSubstr("601 lines")));
  EXPECT_THAT(check_file(small, "tests/a_test.cpp", text + "\n"), ElementsAre(HasSubstr("601 lines")));
}

TEST(LayeringCheck, FindsACircle) {
  EXPECT_THAT(rooms_in_a_circle({{"core/a", {"core/b"}}, {"core/b", {"core/a"}}, {"core/c", {}}}),
              ElementsAre("core/a", "core/b"));
}

}  // namespace
}  // namespace rigcal::layering
