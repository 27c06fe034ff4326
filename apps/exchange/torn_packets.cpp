#include "apps/exchange/torn_packets.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <functional>

#include "core/base/bytes.h"
#include "core/base/text.h"
#include "core/io/capture_file.h"
#include "core/io/output_file.h"
#include "core/io/random_access_file.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

// Zeros not counted, which a power cut leaves of what had not reached the disk. The recorder hands over less than this
// at a time.
constexpr std::uint64_t most_torn_bytes = std::uint64_t{1} << 20U;
// Of a file whose head is gone already: it is kept by another name, which costs nothing.
constexpr std::uint64_t most_torn_head_bytes = 4096;
constexpr std::size_t head_bytes = 28;  // Of a section header, as it is in every packet file.
constexpr std::size_t piece_bytes = std::size_t{1} << 20U;
constexpr std::uint64_t cancel_period = 4096;  // Packets between two looks at whether to stop.

// By a program on another machine: one on this machine has the session's lock.
Error still_written(const std::string& path) {
  return system_error("grew while it was read, so it is still being recorded", path,
                      "wait until that has ended, then repair it");
}

Expected<std::uint64_t> size_of(const std::string& path) {
  std::error_code error;
  const std::uint64_t bytes = fs::file_size(path, error);
  if (error) return cannot_read(path, error.value());
  return bytes;
}

// Gives what stands in a file from `begin` on, piece by piece, until `take` wants no more.
Expected<void> read_from(const std::string& path, std::uint64_t begin, const RunContext& context,
                         const std::function<bool(ByteView)>& take) {
  const Expected<RandomAccessFile> file = RandomAccessFile::open(path);
  if (!file) return file.error();
  std::vector<std::uint8_t> piece(piece_bytes);
  for (std::uint64_t at = begin; at < file->size(); at += piece.size()) {
    if (context.cancelled()) return cancelled_error("stopped", path);
    piece.resize(std::min<std::uint64_t>(piece_bytes, file->size() - at));
    if (!file->read_at(at, piece))
      return read_failure(path, file->failure().empty() ? "it became shorter" : file->failure());
    if (!take(piece)) break;
  }
  return {};
}

Expected<bool> holds_more_than(std::uint64_t most, const std::string& path, std::uint64_t begin,
                               const RunContext& context) {
  std::uint64_t found = 0;
  const auto read = read_from(path, begin, context, [&](ByteView bytes) {
    found += bytes.size() - static_cast<std::uint64_t>(std::count(bytes.begin(), bytes.end(), 0));
    return found <= most;
  });
  if (!read) return read.error();
  return found > most;
}

// Of a file that is `no_dump`: a power cut may leave zeros of its head, and of all that follows.
Expected<std::optional<TornPackets>> find_torn_head(const std::string& path, std::uint64_t bytes, const Error& no_dump,
                                                    const RunContext& context) {
  bool is_zero = false;
  const auto read = read_from(path, 0, context, [&](ByteView begin) {
    const ByteView head = begin.first(std::min(begin.size(), head_bytes));
    is_zero = std::all_of(head.begin(), head.end(), [](std::uint8_t byte) { return byte == 0; });
    return false;
  });
  if (!read) return read.error();
  if (!is_zero) return no_dump;
  const auto kept = holds_more_than(most_torn_head_bytes, path, 0, context);
  if (!kept) return kept.error();
  return std::optional<TornPackets>({path, 0, bytes, "its head is gone", *kept});
}

// One is there where a session was damaged again after it had been mended.
std::string free_tail_name(const std::string& path) {
  std::string name = path + ".tail";
  std::error_code error;
  for (int number = 2; fs::exists(fs::symlink_status(name, error)); ++number)
    name = path + ".tail" + std::to_string(number);
  return name;
}

Expected<void> copy_tail(const TornPackets& torn, const std::string& to, const RunContext& context) {
  Expected<OutputFile> out = OutputFile::create(to);
  if (!out) return out.error();
  const auto read = read_from(torn.path, torn.whole_bytes, context, [&](ByteView bytes) {
    out->write(bytes);
    return out->status().has_value();
  });
  if (!read) return read;
  if (const auto synced = out->sync(); !synced) return synced;
  return out->close();
}

// Under its own name only when it is whole.
Expected<void> keep_tail(const TornPackets& torn, const std::string& tail, const RunContext& context) {
  const std::string unfinished = tail + ".part";
  Expected<void> kept = copy_tail(torn, unfinished, context);
  if (kept && std::rename(unfinished.c_str(), tail.c_str()) != 0) kept = cannot_write(tail, errno);
  if (!kept) std::remove(unfinished.c_str());
  return kept;
}

// Cut to nothing it would be no packet file, and the recording torn for good.
Expected<std::string> take_away(const TornPackets& torn) {
  const std::string tail = free_tail_name(torn.path);
  const int done = torn.must_be_kept ? std::rename(torn.path.c_str(), tail.c_str()) : std::remove(torn.path.c_str());
  if (done != 0) return cannot_write(torn.path, errno);
  if (!torn.must_be_kept) return std::string("held nothing whole and is gone");
  return torn.damage + ", so that nothing whole is left in it; it is now " + fs::path(tail).filename().string();
}

}  // namespace

Expected<std::optional<TornPackets>> find_torn_packets(const std::string& path, const RunContext& context) {
  const Expected<std::uint64_t> bytes = size_of(path);
  if (!bytes) return bytes.error();
  Expected<CaptureFile> file = CaptureFile::open(path);
  if (!file && file.error().kind == ErrorKind::input) return find_torn_head(path, *bytes, file.error(), context);
  if (!file) return file.error();
  CapturedFrame frame;
  for (std::uint64_t i = 0; file->next(frame); ++i) {
    if (i % cancel_period != 0) continue;
    if (context.cancelled()) return cancelled_error("stopped", path);
    context.reporter.progress("looking for the last whole packet",
                              static_cast<double>(file->whole_bytes()) / static_cast<double>(*bytes));
  }
  if (!file->failure().empty()) return read_failure(path, file->failure());
  if (const auto now = size_of(path); !now || *now != *bytes) return now ? still_written(path) : now.error();
  if (file->damage().empty()) return std::optional<TornPackets>{};
  const std::uint64_t whole = file->whole_bytes();
  const auto kept = holds_more_than(whole > 0 ? most_torn_bytes : most_torn_head_bytes, path, whole, context);
  if (!kept) return kept.error();
  return std::optional<TornPackets>({path, whole, *bytes - whole, file->damage(), *kept});
}

Expected<void> check_room(const std::vector<TornPackets>& all) {
  std::uint64_t wanted = 0;
  for (const TornPackets& torn : all) wanted += torn.must_be_kept && torn.whole_bytes > 0 ? torn.torn_bytes : 0;
  if (wanted == 0) return {};
  const std::string folder = fs::path(all.front().path).parent_path().string();
  std::error_code error;
  const fs::space_info space = fs::space(folder.empty() ? "." : folder, error);
  // Where that is not known, it shows when it is written.
  if (error || space.available >= wanted) return {};
  return system_error(
      "the disk has no room for the " + counted(wanted, "byte") + " behind the damage, which must be kept",
      all.front().path, "make room, or copy the session to another disk and repair it there");
}

Expected<std::string> cut_torn_packets(const TornPackets& torn, const RunContext& context) {
  if (torn.whole_bytes == 0) return take_away(torn);
  const std::string tail = free_tail_name(torn.path);
  if (torn.must_be_kept) {
    if (const auto kept = keep_tail(torn, tail, context); !kept) return kept.error();
  }
  std::error_code error;
  fs::resize_file(torn.path, torn.whole_bytes, error);
  if (error) {
    if (torn.must_be_kept) std::remove(tail.c_str());
    return cannot_write(torn.path, error.value());
  }
  if (!torn.must_be_kept) return counted(torn.torn_bytes, "byte") + " after the last whole packet cut off";
  return torn.damage + ", far before its end; the " + counted(torn.torn_bytes, "byte") + " from there on are now in " +
         fs::path(tail).filename().string();
}

}  // namespace rigcal
