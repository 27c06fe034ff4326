#include "apps/exchange/session_repair.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>

#include "apps/exchange/torn_packets.h"
#include "apps/ingest/lidar_ingest.h"
#include "apps/recording/datagram_file.h"
#include "apps/recording/session_counters.h"
#include "core/base/text.h"
#include "core/base/utc_text.h"
#include "core/base/version.h"
#include "core/io/frame_files.h"
#include "core/io/output_file.h"
#include "core/io/random_access_file.h"
#include "core/io/session_folder.h"
#include "core/io/session_lock.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_table_bytes = std::size_t{256} << 20U;
// What may go of a table, zeros not counted: lines are short, and come to the disk at each stop.
constexpr std::size_t most_torn_bytes = 4096;
constexpr std::size_t most_header_bytes = 80;
constexpr std::uint64_t cancel_period = 4096;  // Packets between two looks at whether to stop.

Expected<bool> is_there(const std::string& path) {
  std::error_code error;
  const bool there = fs::exists(path, error);
  if (error) return cannot_read(path, error.value());
  return there;
}

class Repair {
 public:
  Repair(SessionFolder session, const RunContext& context) : session_(std::move(session)), context_(context) {}

  Expected<std::vector<std::string>> run() {
    if (const auto mended = mend(); !mended) {
      for (const std::string& one : done_) context_.reporter.warn(one);  // It stays as it is.
      return mended.error();
    }
    return done_;
  }

 private:
  Expected<void> mend() {
    if (const auto cut = cut_packets(); !cut) return cut;
    const auto counters = count_packets();
    if (!counters) return counters.error();
    const auto table = [&](const char* name) { return (fs::path(session_.path) / name).string(); };
    if (const auto cut = cut_table(table("trigger.csv"), parse_trigger); !cut) return cut;
    if (const auto cut = cut_table(table("turntable.csv"), parse_turntable); !cut) return cut;
    if (const auto images = mend_images(); !images) return images;
    if (const auto written = write_record(*counters); !written) return written;
    const auto packets = is_there(session_packet_parts(session_packets_path(session_.path)).front());
    if (!packets) return packets.error();
    if (*packets) return {};
    return input_error("no packet of its LiDARs had reached the disk whole; its rig file, tables and images are left",
                       session_.path, "record anew: stops cannot be found without packets");
  }

  std::string short_name(const std::string& path) const {
    return fs::path(path).lexically_relative(session_.path).string();
  }

  // All files are read before the first is touched.
  Expected<void> cut_packets() {
    std::vector<std::string> empty;
    std::vector<TornPackets> torn;
    for (const std::string& part : session_packet_parts(session_.packets)) {
      std::error_code error;
      if (fs::is_empty(part, error) && !error) {
        empty.push_back(part);
        continue;
      }
      Expected<std::optional<TornPackets>> found = find_torn_packets(part, context_);
      if (!found) return found.error();
      if (*found) torn.push_back(**std::move(found));
    }
    if (const auto room = check_room(torn); !room) return room;
    for (const std::string& part : empty) {
      if (const auto removed = remove_file(part, "was empty"); !removed) return removed;
    }
    for (const TornPackets& one : torn) {
      const Expected<std::string> cut = cut_torn_packets(one, context_);
      if (!cut) return cut.error();
      done_.push_back(short_name(one.path) + ": " + *cut);
      if (one.must_be_kept) gaps_.push_back(done_.back());
    }
    return {};
  }

  Expected<void> remove_file(const std::string& path, const std::string& why) {
    std::error_code error;
    if (!fs::remove(path, error) || error) return cannot_write(path, error.value());
    done_.push_back(short_name(path) + ": " + why + " and is gone");
    return {};
  }

  // Also finds out when the recording began and ended.
  Expected<SessionCounters> count_packets() {
    LidarIngest ingest = LidarIngest::of_headers(session_.rig);
    const auto there = is_there(session_packet_parts(session_packets_path(session_.path)).front());
    if (!there) return there.error();
    if (!*there) return SessionCounters{};
    const auto file = open_datagrams(session_packets_path(session_.path));
    if (!file) return file.error();
    Datagram datagram;
    for (std::uint64_t i = 0;; ++i) {
      const Expected<bool> more = (*file)->next(datagram);
      if (!more) return more.error();
      if (!*more) break;
      ingest.add(datagram);
      note(datagram.stamp_ns);
      if (i % cancel_period != 0) continue;
      if (context_.cancelled()) return cancelled();
      context_.reporter.progress("counting packets", (*file)->fraction());
    }
    SessionCounters counters = session_counters(session_.rig, ingest.summary());
    for (auto& [name, values] : counters) {
      values.erase("points");  // Nobody has looked at them.
      values.erase("imu_samples");
    }
    return counters;
  }

  // Cuts what a power cut leaves at the end: part of a line, zeros, lines that make no sense. `parse` is one of those
  // of frame_files.h.
  template <class Parse>
  Expected<void> cut_table(const std::string& path, const Parse& parse) {
    const Expected<bool> there = is_there(path);
    if (!there) return there.error();
    if (!*there) return {};
    const Expected<std::string> text = read_text_file(path, most_table_bytes);
    if (!text) return text.error();
    const std::string lines = text->substr(0, text->find_last_of('\n') + 1);  // 0 where there is no line
    std::size_t kept = lines.size();
    const auto records = parse(lines, path, &kept);
    const auto zeros = std::count(text->begin() + static_cast<std::ptrdiff_t>(kept), text->end(), '\0');
    const std::size_t torn = text->size() - kept;
    if (torn - static_cast<std::size_t>(zeros) > (kept == 0 ? most_header_bytes : most_torn_bytes)) {
      Error damage = records ? input_error("the last line has no end", path) : records.error();
      damage.what += ", and with the " + counted(torn, "byte") + " from there on more would go than a power cut spoils";
      damage.mend = "mend the line by hand, or take away what follows, and repair the session again";
      return damage;
    }
    if (torn == 0 && kept > 0) return {};
    if (kept == 0) return remove_file(path, "held no whole line");
    if (const auto replaced = replace_file(path, text->substr(0, kept)); !replaced) return replaced;
    done_.push_back(short_name(path) + ": " + counted(torn, "byte") + " of unfinished lines cut off");
    return {};
  }

  Expected<void> mend_images() {
    for (const Sensor& sensor : session_.rig.sensors) {
      const fs::path folder = fs::path(session_.path) / "images" / sensor.name;
      const std::string table = (folder / "frames.csv").string();
      if (sensor.is_lidar()) continue;
      if (const auto cut = cut_table(table, parse_frames); !cut) return cut;
      const Expected<bool> there = is_there(table);
      if (!there) return there.error();
      if (!*there) continue;
      const auto frames = read_frames(table);
      if (!frames) return frames.error();
      if (const auto mended = mend_images(folder, *frames); !mended) return mended;
    }
    return {};
  }

  Expected<void> mend_images(const fs::path& folder, const std::vector<FrameRecord>& frames) {
    std::vector<FrameRecord> kept;
    std::set<std::string> listed;
    for (const FrameRecord& frame : frames) {
      const Expected<bool> is_whole = is_whole_image((folder / frame.file).string());
      if (!is_whole) return is_whole.error();
      if (!*is_whole) continue;
      kept.push_back(frame);
      listed.insert(frame.file);
      note(frame.stamp_ns);
    }
    const std::string camera = folder.filename().string();
    if (kept.size() < frames.size()) {
      if (const auto written = write_frames((folder / "frames.csv").string(), kept); !written) return written;
      done_.push_back(camera + ": " + counted(frames.size() - kept.size(), "image") +
                      " that had not reached the disk taken out of frames.csv");
    }
    std::uint64_t unlisted = 0;
    std::error_code error;
    for (fs::directory_iterator file(folder, error), end; !error && file != end; file.increment(error))
      unlisted += file->path().extension() == ".png" && !listed.contains(file->path().filename().string()) ? 1 : 0;
    if (unlisted > 0)
      done_.push_back(camera + ": " + counted(unlisted, "image") + " without a line in frames.csv left aside");
    return {};
  }

  // One that cannot be looked at for another reason may be whole. Other formats are not written by us.
  static Expected<bool> is_whole_image(const std::string& path) {
    static constexpr std::array<std::uint8_t, 12> png_end{0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xAE, 0x42, 0x60, 0x82};
    const Expected<bool> there = is_there(path);
    if (!there || !*there) return there;
    if (fs::path(path).extension() != ".png") return true;
    std::error_code error;
    if (fs::file_size(path, error) < png_end.size() && !error) return false;
    const Expected<RandomAccessFile> file = RandomAccessFile::open(path);
    if (!file) return file.error();
    std::array<std::uint8_t, png_end.size()> end{};
    if (file->read_at(file->size() - end.size(), end)) return end == png_end;
    return file->failure().empty() ? Expected<bool>(false) : read_failure(path, file->failure());
  }

  Expected<void> write_record(const SessionCounters& counters) {
    SessionRecord record = session_.record.value_or(SessionRecord{});
    if (!session_.record) {
      record.software = version();
      record.start_ns = first_ns_.value_or(0);
      done_.push_back("session.json: made anew");
    }
    for (const auto& [name, values] : counters) {
      for (const auto& [key, value] : values) record.counters[name][key] = value;
    }
    record.end_ns = std::max(record.start_ns, last_ns_.value_or(record.start_ns));
    const std::string text = utc_text(*record.end_ns) + " recording: was cut short here";
    record.gaps.push_back(text);
    record.gaps.insert(record.gaps.end(), gaps_.begin(), gaps_.end());
    record.events.push_back(text + ", and finished by inspect --repair");
    done_.push_back("session.json: its end is " + utc_text(*record.end_ns) + " UTC, the packets are counted anew");
    return write_session_record(session_.path, record);
  }

  void note(std::int64_t stamp_ns) {
    first_ns_ = std::min(first_ns_.value_or(stamp_ns), stamp_ns);
    last_ns_ = std::max(last_ns_.value_or(stamp_ns), stamp_ns);
  }
  Error cancelled() const { return cancelled_error("stopped", session_.path); }

  SessionFolder session_;
  const RunContext& context_;
  std::vector<std::string> done_;
  std::vector<std::string> gaps_;  ///< Those of them after which something may be missing.
  std::optional<std::int64_t> first_ns_;
  std::optional<std::int64_t> last_ns_;
};

}  // namespace

Expected<std::vector<std::string>> repair_session(const std::string& path, const RunContext& context) {
  // Before it is looked at: who records it may just be writing its end.
  const std::optional<SessionLock> lock = SessionLock::take(path);
  Expected<SessionFolder> session = open_session(path);
  if (!session) return session.error();
  if (session->packets.empty())
    return input_error("has no packets to be finished", path, "patches are whole as they are");
  if (session->record && session->record->end_ns) return std::vector<std::string>{};
  if (!lock)
    return system_error("is still being recorded, or mended by another program", path,
                        "wait until that has ended, then repair it");
  return Repair(*std::move(session), context).run();
}

}  // namespace rigcal
