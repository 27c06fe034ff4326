#include "core/base/file_descriptor.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace rigcal {
namespace {

int open_null() { return ::open("/dev/null", O_RDONLY | O_CLOEXEC); }
bool is_open(int number) { return ::fcntl(number, F_GETFD) >= 0; }

TEST(FileDescriptor, ClosesWithItsOwner) {
  const int number = open_null();
  {
    const FileDescriptor file(number);
    EXPECT_TRUE(file.is_open());
    EXPECT_EQ(file.get(), number);
    EXPECT_TRUE(is_open(number));
  }
  EXPECT_FALSE(is_open(number));
  EXPECT_FALSE(FileDescriptor().is_open());
}

TEST(FileDescriptor, HasOneOwner) {
  const int first = open_null();
  const int second = open_null();
  FileDescriptor a(first);
  FileDescriptor b(second);
  a = std::move(b);
  EXPECT_FALSE(is_open(first)) << "what it had is closed";
  EXPECT_EQ(a.get(), second);
  EXPECT_TRUE(is_open(second));
  FileDescriptor& same = a;
  a = std::move(same);
  EXPECT_EQ(a.get(), second);
  const FileDescriptor c(std::move(a));
  EXPECT_EQ(c.get(), second);
}

TEST(FileDescriptor, LeavesClosingToWhoeverTakesIt) {
  const int number = open_null();
  {
    FileDescriptor file(number);
    EXPECT_EQ(file.release(), number);
    EXPECT_FALSE(file.is_open());
  }
  EXPECT_TRUE(is_open(number));
  ::close(number);
}

}  // namespace
}  // namespace rigcal
