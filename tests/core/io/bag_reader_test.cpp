#include "core/io/bag_reader.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <random>

#include "tests/core/io/dump_bytes.h"
#include "tests/support/bag_bytes.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t second = 1'000'000'000;

/// "topic@seconds:bytes" of each message; the last entry starts with "error" where reading ended so.
std::vector<std::string> read_all(BagReader& bag) {
  std::vector<std::string> all;
  for (BagMessage message;;) {
    const Expected<bool> more = bag.next(message);
    if (!more) {
      all.push_back("error: " + more.error().message());
      return all;
    }
    if (!*more) return all;
    all.push_back(message.connection->topic + "@" + std::to_string(message.stamp_ns / second) + ":" +
                  std::string(message.bytes.begin(), message.bytes.end()));
  }
}

void add(BagBytes& bag, const std::string& topic, std::int64_t at_s, const std::string& text) {
  bag.add(topic, "std_msgs/String", "*", at_s * second, BagBytes::text(text));
}

TEST(BagReader, ReadsEveryCompression) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    BagBytes bytes;
    bytes.compression = compression;
    const std::string many(300'000, 'm');
    add(bytes, "/a", 1, "one");
    add(bytes, "/b", 2, many);
    bytes.flush();
    add(bytes, "/a", 3, "three");
    Expected<BagReader> bag = BagReader::open(write_bytes("whole.bag", bytes.finish()));
    ASSERT_TRUE(bag.has_value()) << compression;
    EXPECT_TRUE(bag->indexed());
    EXPECT_EQ(bag->connections().size(), 2U);
    EXPECT_EQ(bag->connections().at(0).type, "std_msgs/String");
    EXPECT_TRUE(read_all(*bag) == (std::vector<std::string>{"/a@1:one", "/b@2:" + many, "/a@3:three"})) << compression;
    EXPECT_THAT(bag->truncation(), IsEmpty());
    EXPECT_EQ(bag->fraction(), 1.0);
  }
}

TEST(BagReader, GivesMessagesInTheOrderOfTimeWhateverTheOrderOfTheChunks) {
  BagBytes bytes;  // one topic after the other, as converters write
  add(bytes, "/a", 1, "");
  add(bytes, "/a", 5, "");
  bytes.flush();
  add(bytes, "/a", 7, "");
  bytes.flush();
  add(bytes, "/b", 6, "");
  add(bytes, "/b", 2, "");
  Expected<BagReader> bag = BagReader::open(write_bytes("mixed.bag", bytes.finish()));
  ASSERT_TRUE(bag.has_value());
  EXPECT_THAT(read_all(*bag), ElementsAre("/a@1:", "/b@2:", "/a@5:", "/b@6:", "/a@7:"));
}

TEST(BagReader, ReadsWhatAKilledRecorderLeft) {
  BagBytes bytes;
  add(bytes, "/a", 1, "x");
  bytes.flush();
  add(bytes, "/b", 2, "y");
  add(bytes, "/a", 3, "z");
  Expected<BagReader> bag = BagReader::open(write_bytes("run.bag.active", bytes.killed()));
  ASSERT_TRUE(bag.has_value());
  EXPECT_FALSE(bag->indexed());
  EXPECT_THAT(read_all(*bag), ElementsAre("/a@1:x", "/b@2:y", "/a@3:z"));
  EXPECT_THAT(bag->truncation(), HasSubstr("rosbag reindex"));
}

TEST(BagReader, ReadsEveryWholeMessageOfACutBag) {
  for (const char* compression : {"none", "lz4"}) {
    BagBytes bytes;
    bytes.compression = compression;
    std::vector<std::size_t> chunk_ends;
    for (int i = 0; i < 6; ++i) {
      add(bytes, "/a", i, std::string(50, 'q'));
      if (i % 2 == 1) {
        bytes.flush();
        chunk_ends.push_back(bytes.size());
      }
    }
    const Bytes whole = bytes.finish();
    for (std::size_t size = 4096 + 13; size < whole.size(); size += 7) {
      Expected<BagReader> bag = BagReader::open(
          write_bytes("cut.bag", Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))));
      ASSERT_TRUE(bag.has_value()) << size;
      const std::vector<std::string> messages = read_all(*bag);
      const auto whole_chunks = static_cast<std::size_t>(
          std::count_if(chunk_ends.begin(), chunk_ends.end(), [&](std::size_t end) { return end <= size; }));
      EXPECT_GE(messages.size(), 2 * whole_chunks) << compression << " cut at " << size;
      EXPECT_LE(messages.size(), 2 * whole_chunks + 1) << "a chunk that is cut holds one whole message at most";
      for (const std::string& message : messages) EXPECT_THAT(message, HasSubstr(std::string(50, 'q')));
      EXPECT_FALSE(bag->truncation().empty());
    }
  }
}

TEST(BagReader, LeavesADamagedChunkOutAndReadsTheOthers) {
  BagBytes bytes;
  bytes.compression = "bz2";
  add(bytes, "/a", 1, "one");
  bytes.flush();
  const std::size_t second_chunk = bytes.size();
  add(bytes, "/a", 2, "two");
  bytes.flush();
  add(bytes, "/a", 3, "three");
  Bytes damaged = bytes.finish();
  damaged[second_chunk + 90] ^= 0xFFU;
  Expected<BagReader> bag = BagReader::open(write_bytes("damaged.bag", damaged));
  ASSERT_TRUE(bag.has_value());
  EXPECT_THAT(read_all(*bag), ElementsAre("/a@1:one", "/a@3:three"));
  EXPECT_THAT(bag->truncation(), HasSubstr("1 part(s) left out, the first at byte " + std::to_string(second_chunk)));
}

TEST(BagReader, TellsOnceAChunkOfRecordsThatAreDamaged) {
  for (const auto& [was, is] : std::vector<std::pair<std::string, std::string>>{
           {"time=", "tame="}, {"conn=", "coin="}, {"op=\x02", "op=\x42"}, {"op=\x02", "op=\x04"}}) {
    BagBytes bytes;
    add(bytes, "/a", 1, "one");
    bytes.flush();
    const std::size_t second_chunk = bytes.size();
    for (const int at_s : {2, 3}) add(bytes, "/a", at_s, "more");
    bytes.flush();
    const std::size_t end = bytes.size();
    add(bytes, "/a", 4, "four");
    Bytes damaged = bytes.finish();
    // The headers of both messages in the second chunk.
    const auto stop = damaged.begin() + static_cast<std::ptrdiff_t>(end);
    int spoiled = 0;
    for (auto at = damaged.begin() + static_cast<std::ptrdiff_t>(second_chunk); at != stop; ++spoiled) {
      at = std::search(at, stop, was.begin(), was.end());
      if (at == stop) break;
      at = std::copy(is.begin(), is.end(), at);
    }
    ASSERT_EQ(spoiled, 2);
    Expected<BagReader> bag = BagReader::open(write_bytes("records.bag", damaged));
    ASSERT_TRUE(bag.has_value()) << is;
    EXPECT_THAT(read_all(*bag), ElementsAre("/a@1:one", "/a@4:four")) << is;
    EXPECT_THAT(bag->truncation(), HasSubstr("1 part(s) left out, the first at byte " + std::to_string(second_chunk) +
                                             ": a record in it is damaged"))
        << is;
  }
}

TEST(BagReader, DoesNotBelieveSizes) {
  for (const char* compression : {"bz2", "lz4", "none", "zip"}) {
    BagBytes bytes;
    Bytes bag = bytes.killed();
    for (const std::uint32_t claim : {0xFFFFFFFFU, 200'000'000U}) {
      const Bytes chunk = BagBytes::make_record(
          {{"op", {5}}, {"compression", BagBytes::text(compression)}, {"size", BagBytes::word(claim)}}, Bytes(100, 7));
      bag.insert(bag.end(), chunk.begin(), chunk.end());
    }
    Expected<BagReader> reader = BagReader::open(write_bytes("claims.bag", bag));
    ASSERT_TRUE(reader.has_value());
    EXPECT_THAT(read_all(*reader), IsEmpty());
    EXPECT_THAT(reader->truncation(), HasSubstr("2 part(s) left out")) << compression;
  }
}

TEST(BagReader, RefusesWhatIsNoBag) {
  const auto refusal = [](const std::string& path) {
    const Expected<BagReader> bag = BagReader::open(path);
    return bag ? std::string("opened") : bag.error().message();
  };
  EXPECT_THAT(refusal(fresh_path("missing.bag")), HasSubstr("missing.bag"));
  EXPECT_THAT(refusal(write_text("empty.bag", "")), HasSubstr("is empty"));
  EXPECT_THAT(refusal(std::filesystem::path(fresh_path("x")).parent_path()), HasSubstr("is a folder"));
  EXPECT_THAT(refusal(write_text("text.bag", "a text that is no bag, but long enough")), HasSubstr("is no ROS bag"));
  EXPECT_THAT(refusal(write_text("old.bag", "#ROSRECORD V1.2\n and so on")), HasSubstr("another format version"));
  EXPECT_THAT(refusal(write_text("head.bag", "#ROSBAG V2.0\nabc")), HasSubstr("header is cut"));
  Bytes secret = BagBytes::text("#ROSBAG V2.0\n");
  const Bytes head = BagBytes::make_record({{"op", {3}}, {"encryptor", BagBytes::text("rosbag/AesCbcEncryptor")}}, {});
  secret.insert(secret.end(), head.begin(), head.end());
  EXPECT_THAT(refusal(write_bytes("secret.bag", secret)), HasSubstr("is encrypted"));
}

TEST(BagReader, SurvivesMutations) {
  std::mt19937 random(7);
  for (const char* compression : {"none", "bz2", "lz4"}) {
    BagBytes bytes;
    bytes.compression = compression;
    for (int i = 0; i < 12; ++i) {
      add(bytes, i % 3 == 0 ? "/a" : "/b", i, std::string(static_cast<std::size_t>(i), 'x'));
      if (i % 4 == 3) bytes.flush();
    }
    const Bytes whole = bytes.finish();
    for (int round = 0; round < 200; ++round) {
      Bytes mutated = whole;
      for (unsigned n = 1 + random() % 8; n > 0; --n) {
        // The padding of the header is four fifths of the file: leave most of it alone.
        const std::size_t at = random() % 8 == 0 ? random() % 200 : 4000 + random() % (mutated.size() - 4000);
        mutated[at] = static_cast<std::uint8_t>(random() % 4 == 0 ? 0xFF : random());
      }
      if (round % 5 == 0) mutated.resize(4000 + random() % (mutated.size() - 4000));
      Expected<BagReader> bag = BagReader::open(write_bytes("mutated.bag", mutated));
      if (bag) {
        EXPECT_LE(read_all(*bag).size(), 24U);
      }
    }
  }
}

}  // namespace
}  // namespace rigcal
