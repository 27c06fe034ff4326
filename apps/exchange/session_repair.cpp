#include "apps/exchange/session_repair.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>

#include "apps/ingest/lidar_ingest.h"
#include "apps/recording/datagram_file.h"
#include "apps/recording/session_counters.h"
#include "core/base/utc_text.h"
#include "core/base/version.h"
#include "core/io/capture_file.h"
#include "core/io/frame_files.h"
#include "core/io/output_file.h"
#include "core/io/session_folder.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_table_bytes = std::size_t{256} << 20U;
// What may go of a table, zeros not counted: lines are short, and come to the disk at each stop.
constexpr std::size_t most_torn_bytes = 4096;
constexpr std::size_t most_header_bytes = 80;
constexpr std::uint64_t cancel_period = 4096;  // Packets between two looks at whether to stop.

std::string count_of(std::uint64_t count, const std::string& one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

class Repair {
 public:
  Repair(SessionFolder session, const RunContext& context) : session_(std::move(session)), context_(context) {}

  Expected<std::vector<std::string>> run() {
    for (const std::string& part : session_packet_parts(session_.packets)) {
      if (const auto cut = cut_packets(part); !cut) return cut.error();
    }
    const auto counters = count_packets();
    if (!counters) return counters.error();
    const auto table = [&](const char* name) { return (fs::path(session_.path) / name).string(); };
    if (const auto cut = cut_table(table("trigger.csv"), parse_trigger); !cut) return cut.error();
    if (const auto cut = cut_table(table("turntable.csv"), parse_turntable); !cut) return cut.error();
    if (const auto images = mend_images(); !images) return images.error();
    if (const auto written = write_record(*counters); !written) return written.error();
    return done_;
  }

 private:
  std::string short_name(const std::string& path) const {
    return fs::path(path).lexically_relative(session_.path).string();
  }

  Expected<void> cut_packets(const std::string& path) {
    Expected<CaptureFile> file = CaptureFile::open(path);
    if (!file) {
      std::error_code error;
      if (fs::file_size(path, error) > 0 || error) return file.error();
      return remove_file(path, "was empty");
    }
    CapturedFrame frame;
    for (std::uint64_t i = 0; file->next(frame); ++i) {
      if (i % cancel_period == 0 && context_.cancelled()) return cancelled();
    }
    if (file->damage().empty()) return {};
    // Cut to nothing it would be no capture file, and the recording torn for good.
    if (file->whole_bytes() == 0) return remove_file(path, "held nothing whole");
    std::error_code error;
    const std::uint64_t bytes = fs::file_size(path, error);
    if (!error) fs::resize_file(path, file->whole_bytes(), error);
    if (error) return cannot_write(path, error.value());
    done_.push_back(short_name(path) + ": " + count_of(bytes - file->whole_bytes(), "byte") +
                    " after the last whole packet cut off");
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
    const auto parts = session_packet_parts(session_packets_path(session_.path));
    std::error_code error;
    if (!fs::exists(parts.front(), error)) return SessionCounters{};
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
    std::error_code error;
    if (!fs::exists(path, error)) return {};
    const Expected<std::string> text = read_text_file(path, most_table_bytes);
    if (!text) return text.error();
    const std::string lines = text->substr(0, text->find_last_of('\n') + 1);  // 0 where there is no line
    std::size_t kept = lines.size();
    const auto records = parse(lines, path, &kept);
    const auto zeros = std::count(text->begin() + static_cast<std::ptrdiff_t>(kept), text->end(), '\0');
    const std::size_t torn = text->size() - kept;
    if (torn - static_cast<std::size_t>(zeros) > (kept == 0 ? most_header_bytes : most_torn_bytes)) {
      Error damage = records ? input_error("the last line has no end", path) : records.error();
      damage.what +=
          ", and with the " + count_of(torn, "byte") + " from there on more would go than a power cut spoils";
      damage.mend = "mend the line by hand, or take away what follows, and repair the session again";
      return damage;
    }
    if (torn == 0 && kept > 0) return {};
    if (kept == 0) return remove_file(path, "held no whole line");
    if (const auto replaced = replace_file(path, text->substr(0, kept)); !replaced) return replaced;
    done_.push_back(short_name(path) + ": " + count_of(torn, "byte") + " of unfinished lines cut off");
    return {};
  }

  Expected<void> mend_images() {
    for (const Sensor& sensor : session_.rig.sensors) {
      const fs::path folder = fs::path(session_.path) / "images" / sensor.name;
      const std::string table = (folder / "frames.csv").string();
      std::error_code error;
      if (sensor.is_lidar() || !fs::exists(table, error)) continue;
      if (const auto cut = cut_table(table, parse_frames); !cut) return cut;
      if (!fs::exists(table, error)) continue;
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
      if (!is_whole_image(folder / frame.file)) continue;
      kept.push_back(frame);
      listed.insert(frame.file);
      note(frame.stamp_ns);
    }
    const std::string camera = folder.filename().string();
    if (kept.size() < frames.size()) {
      if (const auto written = write_frames((folder / "frames.csv").string(), kept); !written) return written;
      done_.push_back(camera + ": " + count_of(frames.size() - kept.size(), "image") +
                      " that had not reached the disk taken out of frames.csv");
    }
    std::uint64_t unlisted = 0;
    std::error_code error;
    for (fs::directory_iterator file(folder, error), end; !error && file != end; file.increment(error))
      unlisted += file->path().extension() == ".png" && !listed.contains(file->path().filename().string()) ? 1 : 0;
    if (unlisted > 0)
      done_.push_back(camera + ": " + count_of(unlisted, "image") + " without a line in frames.csv left aside");
    return {};
  }

  // Other formats are not written by us.
  static bool is_whole_image(const fs::path& path) {
    static constexpr std::array<char, 12> png_end{0, 0, 0, 0, 'I', 'E', 'N', 'D', '\xAE', '\x42', '\x60', '\x82'};
    std::ifstream file(path, std::ios::binary);
    if (!file) return false;
    if (path.extension() != ".png") return true;
    std::array<char, 12> end{};
    file.seekg(-static_cast<std::streamoff>(end.size()), std::ios::end);
    file.read(end.data(), end.size());
    return file.gcount() == static_cast<std::streamsize>(end.size()) && end == png_end;
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
    record.events.push_back(text + ", and finished by inspect --repair");
    done_.push_back("session.json: its end is " + utc_text(*record.end_ns) + " UTC, the packets are counted anew");
    return write_session_record(session_.path, record);
  }

  void note(std::int64_t stamp_ns) {
    first_ns_ = std::min(first_ns_.value_or(stamp_ns), stamp_ns);
    last_ns_ = std::max(last_ns_.value_or(stamp_ns), stamp_ns);
  }
  Error cancelled() const { return {ErrorKind::cancelled, "stopped", session_.path, {}}; }

  SessionFolder session_;
  const RunContext& context_;
  std::vector<std::string> done_;
  std::optional<std::int64_t> first_ns_;
  std::optional<std::int64_t> last_ns_;
};

}  // namespace

Expected<std::vector<std::string>> repair_session(const std::string& path, const RunContext& context) {
  Expected<SessionFolder> session = open_session(path);
  if (!session) return session.error();
  if (session->packets.empty())
    return input_error("has no packets to be finished", path, "patches are whole as they are");
  if (session->record && session->record->end_ns) return std::vector<std::string>{};
  return Repair(*std::move(session), context).run();
}

}  // namespace rigcal
