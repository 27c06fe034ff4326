// A disk that does not give what a file holds: an error, and never the file's end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cerrno>

#include "core/io/bag_reader.h"
#include "core/io/capture_file.h"
#include "core/io/file_copy.h"
#include "core/io/lvx_reader.h"
#include "core/io/output_file.h"
#include "core/io/pcap_reader.h"
#include "core/io/pcapng_writer.h"
#include "core/rig/text_file.h"
#include "tests/core/io/dump_bytes.h"
#include "tests/support/bag_bytes.h"
#include "tests/support/broken_reads.h"
#include "tests/support/make_lvx.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

/// The system gives EIO where it is read.
constexpr const char* unreadable = "/proc/self/mem";
/// Larger than what readers read ahead.
constexpr int packets = 4000;

void expect_read_failure(const Error& error, const std::string& path) {
  EXPECT_EQ(error.kind, ErrorKind::system);
  EXPECT_EQ(error.where, path);
  EXPECT_THAT(error.what, HasSubstr("cannot be read to its end ("));
}

std::string long_pcap() {
  const Bytes one = pcap_file(1, {ethernet(ip_udp(Bytes(1000, 5)))});
  Bytes file = pcap_file(1, {});
  for (int i = 0; i < packets; ++i) file.insert(file.end(), one.begin() + 24, one.end());
  return write_bytes("long.pcap", file);
}

std::string long_pcapng() {
  const std::string path = fresh_path("long.pcapng");
  auto writer = PcapngWriter::create(path);
  const Bytes payload(1000, 5);
  for (int i = 0; i < packets; ++i)
    EXPECT_TRUE(writer->write({i, {{10, 0, 0, 1}, 60001}, {{10, 0, 0, 2}, 56001}, payload}));
  EXPECT_TRUE(writer->close());
  return path;
}

TEST(ReadFailure, OfWhatWasNotReadYetBlamesNoDisk) {
  for (const int code : {EMFILE, ENOMEM, ENODEV}) {
    const Error error = cannot_read("run.pcap", code);
    EXPECT_EQ(error.kind, ErrorKind::system);
    EXPECT_THAT(error.message(), testing::Not(HasSubstr("ddrescue")));
  }
  EXPECT_THAT(cannot_read("run.pcap", EMFILE).mend, HasSubstr("ulimit -n"));
}

TEST(WriteFailure, HasTheMendOfItsCause) {
  EXPECT_THAT(cannot_write("result", EROFS).mend, HasSubstr("mount it for writing"));
  EXPECT_THAT(cannot_write("result", EDQUOT).mend, HasSubstr("quota"));
  EXPECT_THAT(cannot_write("result", EMFILE).mend, HasSubstr("ulimit -n"));
}

TEST(ReadFailure, EndsNoDump) {
  for (const std::string& path : {long_pcap(), long_pcapng()}) {
    Expected<PcapReader> reader = PcapReader::open(path);
    ASSERT_TRUE(reader);
    Datagram datagram;
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(*reader->next(datagram));
    ASSERT_TRUE(break_reads(path));
    int read = 10;
    Expected<bool> more = reader->next(datagram);
    for (; more && *more; more = reader->next(datagram)) ++read;
    EXPECT_LT(read, packets);
    ASSERT_FALSE(more) << path;
    expect_read_failure(more.error(), path);
    EXPECT_FALSE(reader->truncated());
  }
}

TEST(ReadFailure, IsToldApartFromDamageOfADump) {
  const std::string path = long_pcapng();
  Expected<CaptureFile> file = CaptureFile::open(path);
  ASSERT_TRUE(file);
  CapturedFrame frame;
  ASSERT_TRUE(file->next(frame));
  EXPECT_EQ(file->failure(), "");
  ASSERT_TRUE(break_reads(path));
  while (file->next(frame)) {
  }
  EXPECT_NE(file->failure(), "");
}

TEST(ReadFailure, EndsNoLvxFile) {
  for (const int minor : {0, 1}) {
    LvxDevice device;
    device.broadcast_code = "3JEDHC900100791";
    LvxBuilder lvx(minor, {device});
    Bytes packet(1318, 0);
    packet[0] = 5;
    for (int i = 0; i < packets; ++i) {
      lvx.add_package(0, packet);
      if (i % 100 == 99) lvx.end_frame();
    }
    const std::string path = write_bytes("long.lvx", lvx.bytes());
    Expected<LvxReader> reader = LvxReader::open(path);
    ASSERT_TRUE(reader);
    LvxPackage package;
    ASSERT_TRUE(reader->next(package));
    ASSERT_TRUE(break_reads(path));
    int read = 1;
    while (reader->next(package)) ++read;
    EXPECT_LT(read, packets);
    EXPECT_NE(reader->failure(), "") << minor;
  }
}

/// Three chunks; only a broken disk keeps the last two from being read.
BagBytes three_chunks() {
  BagBytes bytes;
  for (int i = 0; i < 3; ++i) {
    bytes.add("/a", "std_msgs/String", "*", 1'000'000'000LL * (i + 1), Bytes(100'000, 7));
    bytes.flush();
  }
  return bytes;
}

TEST(ReadFailure, EndsNoBag) {
  const std::string indexed = write_bytes("whole.bag", three_chunks().finish());
  const std::string without = write_bytes("killed.bag", three_chunks().killed());
  for (const std::string& path : {indexed, without}) {
    Expected<BagReader> bag = BagReader::open(path);
    ASSERT_TRUE(bag) << bag.error().message();
    EXPECT_EQ(bag->indexed(), path == indexed);
    BagMessage message;
    ASSERT_TRUE(*bag->next(message));
    ASSERT_TRUE(break_reads(path));
    Expected<bool> more = bag->next(message);
    if (more && *more) more = bag->next(message);
    ASSERT_FALSE(more) << path;
    expect_read_failure(more.error(), path);
  }
}

TEST(ReadFailure, OfTheFirstByteIsToldByAllWhoOpenAFile) {
  const auto dump = PcapReader::open(unreadable);
  ASSERT_FALSE(dump);
  expect_read_failure(dump.error(), unreadable);
  const auto lvx = LvxReader::open(unreadable);
  ASSERT_FALSE(lvx);
  expect_read_failure(lvx.error(), unreadable);
  const auto text = read_text_file(unreadable, 100);
  ASSERT_FALSE(text);
  expect_read_failure(text.error(), unreadable);
  const auto copied = copy_file(unreadable, fresh_path("copy"));
  ASSERT_FALSE(copied);
  expect_read_failure(copied.error(), unreadable);
}

TEST(ReadFailure, OfAPipeIsToldByACopyThatWouldWaitForEver) {
  const std::string pipe = fresh_path("pipe.png");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto copied = copy_file(pipe, fresh_path("copy"));
  ASSERT_FALSE(copied) << "nobody writes to it";
  EXPECT_EQ(copied.error().message(), pipe + ": is no regular file; copy it to a file first");
}

TEST(ReadFailure, IsNotWhatTheNameOrThePermissionsOfAFileAreTo) {
  for (const int code : {ENOENT, ENOTDIR, EACCES, EPERM, EISDIR, ELOOP, ENAMETOOLONG})
    EXPECT_EQ(cannot_read("a", code).kind, ErrorKind::input) << code;
  for (const int code : {EIO, ESTALE, ETIMEDOUT, ENOMEM, EMFILE})
    EXPECT_EQ(cannot_read("a", code).kind, ErrorKind::system) << code;
}

}  // namespace
}  // namespace rigcal
