#include "core/base/sha256.h"

#include <gtest/gtest.h>

#include <string>

namespace rigcal {
namespace {

std::string digest(const std::string& text, std::size_t part) {
  Sha256 sum;
  const ByteView bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  for (std::size_t at = 0; at < bytes.size(); at += part) sum.add(bytes.subspan(at, std::min(part, bytes.size() - at)));
  return sum.finish();
}

// The examples of FIPS 180-4 and of RFC 6234.
TEST(Sha256, GivesThePublishedDigests) {
  EXPECT_EQ(digest("", 1), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(digest("abc", 3), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(digest("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq", 64),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(digest(std::string(1'000'000, 'a'), 4096),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, DoesNotDependOnHowTheBytesCome) {
  for (std::size_t size = 50; size < 135; ++size) {
    const std::string text(size, 'x');
    const std::string whole = digest(text, size);
    for (const std::size_t part : {1, 7, 63, 64, 65}) EXPECT_EQ(digest(text, part), whole) << size << " by " << part;
  }
}

}  // namespace
}  // namespace rigcal
