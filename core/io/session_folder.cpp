#include "core/io/session_folder.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "core/io/output_file.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int session_format_version = 1;
constexpr const char* packets_name = "lidar.pcapng";
/// Ten pairs a second, 60 bytes each: a day is 52 MB.
constexpr std::size_t max_record_bytes = std::size_t{256} << 20;

std::string below(const std::string& folder, const char* name) { return (fs::path(folder) / name).string(); }

/// `folder/name` where that exists, otherwise empty.
std::string existing(const std::string& folder, const char* name) {
  std::error_code error;
  const std::string path = below(folder, name);
  return fs::exists(path, error) ? path : std::string();
}

/// Why nothing can be said of what is in the folder, like errno: no permission mostly. 0 where it can.
int looking_failed(const std::string& folder) {
  std::error_code error;
  static_cast<void>(fs::exists(below(folder, "rig.yaml"), error));
  return error.value();
}

/// The number in the name of an earlier part, lidar.000001.pcapng; from the millionth on it has more digits.
std::optional<std::uint64_t> part_number(std::string_view name) {
  constexpr std::string_view head = "lidar.";
  constexpr std::string_view tail = ".pcapng";
  constexpr std::size_t least_digits = 6;
  if (name.size() < head.size() + least_digits + tail.size() || !name.starts_with(head) || !name.ends_with(tail))
    return std::nullopt;
  std::uint64_t number = 0;
  const char* const end = name.data() + name.size() - tail.size();
  const auto read = std::from_chars(name.data() + head.size(), end, number);
  return read.ec == std::errc() && read.ptr == end ? std::optional(number) : std::nullopt;
}

json to_json(const SessionRecord& record) {
  json pairs = json::array();
  for (const ClockPair& pair : record.clock_pairs) pairs.push_back({pair.realtime_ns, pair.monotonic_ns});
  json text = {{"format", session_format_version},
               {"software", record.software},
               {"start_ns", record.start_ns},
               {"end_ns", nullptr},
               {"clock_pairs_realtime_monotonic_ns", pairs},
               {"counters", record.counters},
               {"gaps", record.gaps}};
  if (!record.events.empty()) text["events"] = record.events;
  if (record.end_ns) text["end_ns"] = *record.end_ns;
  return text;
}

Error wrong_key(const std::string& path, const std::string& key, const std::string& wanted) {
  return input_error("'" + key + "' is missing or not " + wanted, path,
                     "restore the file, or remove it to read the rest");
}

Expected<std::int64_t> read_version(const json& text, const std::string& path) {
  if (!text.is_object() || !text.contains("format") || !text["format"].is_number_integer()) {
    return wrong_key(path, "format", "a whole number");
  }
  const auto version = text["format"].get<std::int64_t>();
  if (version < 1) return wrong_key(path, "format", "a version");
  if (version > session_format_version) {
    return input_error("has the session format " + std::to_string(version) + ", but this release reads format " +
                           std::to_string(session_format_version),
                       path, "use rigcal " + std::to_string(version) + ".0 or newer");
  }
  return version;
}

Expected<std::vector<ClockPair>> read_pairs(const json& text, const std::string& path) {
  const char* key = "clock_pairs_realtime_monotonic_ns";
  std::vector<ClockPair> pairs;
  if (!text.contains(key)) return pairs;
  if (!text[key].is_array()) return wrong_key(path, key, "a list");
  for (const json& pair : text[key]) {
    if (!pair.is_array() || pair.size() != 2 || !pair[0].is_number_integer() || !pair[1].is_number_integer()) {
      return wrong_key(path, key, "a list of pairs of whole numbers");
    }
    pairs.push_back({pair[0].get<std::int64_t>(), pair[1].get<std::int64_t>()});
  }
  return pairs;
}

Expected<std::map<std::string, std::map<std::string, std::uint64_t>>> read_counters(const json& text,
                                                                                    const std::string& path) {
  std::map<std::string, std::map<std::string, std::uint64_t>> counters;
  if (!text.contains("counters")) return counters;
  if (!text["counters"].is_object()) return wrong_key(path, "counters", "a map of devices");
  for (const auto& [device, values] : text["counters"].items()) {
    if (!values.is_object()) return wrong_key(path, "counters." + device, "a map of counters");
    for (const auto& [name, value] : values.items()) {
      if (!value.is_number_unsigned()) return wrong_key(path, "counters." + device + "." + name, "a count");
      counters[device][name] = value.get<std::uint64_t>();
    }
  }
  return counters;
}

std::vector<std::string> read_sentences(const json& text, const char* key) {
  std::vector<std::string> sentences;
  if (!text.contains(key) || !text[key].is_array()) return sentences;
  for (const json& sentence : text[key]) {
    if (sentence.is_string()) sentences.push_back(sentence.get<std::string>());
  }
  return sentences;
}

Expected<SessionRecord> read_record(const std::string& path) {
  const Expected<std::string> content = read_text_file(path, max_record_bytes);
  if (!content) return content.error();
  const json text = json::parse(*content, nullptr, false);
  if (text.is_discarded()) {
    return input_error("is no valid JSON", path, "restore the file, or remove it to read the rest");
  }
  const Expected<std::int64_t> version = read_version(text, path);
  if (!version) return version.error();
  SessionRecord record;
  if (text.contains("software") && text["software"].is_string()) record.software = text["software"].get<std::string>();
  if (!text.contains("start_ns") || !text["start_ns"].is_number_integer()) {
    return wrong_key(path, "start_ns", "a whole number");
  }
  record.start_ns = text["start_ns"].get<std::int64_t>();
  if (text.contains("end_ns") && !text["end_ns"].is_null()) {
    if (!text["end_ns"].is_number_integer()) return wrong_key(path, "end_ns", "a whole number or null");
    record.end_ns = text["end_ns"].get<std::int64_t>();
    if (*record.end_ns < record.start_ns) {
      return input_error("'end_ns' lies before 'start_ns'", path, "restore the file, or remove it to read the rest");
    }
  }
  Expected<std::vector<ClockPair>> pairs = read_pairs(text, path);
  if (!pairs) return pairs.error();
  record.clock_pairs = std::move(*pairs);
  auto counters = read_counters(text, path);
  if (!counters) return counters.error();
  record.counters = std::move(*counters);
  record.gaps = read_sentences(text, "gaps");
  record.events = read_sentences(text, "events");
  return record;
}

}  // namespace

std::string session_packets_path(const std::string& path) { return below(path, packets_name); }

std::string session_packets_part_path(const std::string& packets_path, int number) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "lidar.%06d.pcapng", number);
  return (fs::path(packets_path).parent_path() / name.data()).string();
}

std::vector<std::string> session_packet_parts(const std::string& packets_path) {
  if (fs::path(packets_path).filename() != packets_name) return {packets_path};
  fs::path folder = fs::path(packets_path).parent_path();
  if (folder.empty()) folder = ".";
  std::error_code error;
  std::vector<std::pair<std::uint64_t, std::string>> numbered;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (const auto number = part_number(entry->path().filename().string()))
      numbered.emplace_back(*number, entry->path().string());
  }
  std::sort(numbered.begin(), numbered.end());
  std::vector<std::string> parts;
  for (auto& [number, path] : numbered) parts.push_back(std::move(path));
  // A power cut may come between one part and the next.
  if (parts.empty() || fs::exists(packets_path, error)) parts.push_back(packets_path);
  return parts;
}

bool is_session_folder(const std::string& path) {
  if (looking_failed(path) != 0) return true;
  if (!existing(path, "session.json").empty() || !existing(path, packets_name).empty()) return true;
  // A patch folder may bring its rig file along.
  return !existing(path, "rig.yaml").empty() && !existing(path, "patches").empty();
}

Expected<SessionFolder> open_session(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    if (!fs::exists(path, error)) return cannot_read(path, error ? error.value() : ENOENT);
    return input_error("is no session folder", path, "name the folder that holds rig.yaml");
  }
  if (const int code = looking_failed(path); code != 0) return cannot_read(path, code);
  if (!is_session_folder(path)) {
    return input_error("is no session folder: it has no rig.yaml, or neither lidar.pcapng nor patches", path,
                       "name the folder of a session");
  }
  if (existing(path, "rig.yaml").empty()) {
    return input_error("has no rig.yaml, the rig that it is a recording of", path, "put it back into this folder");
  }
  SessionFolder session;
  session.path = path;
  Expected<Rig> rig = load_rig(below(path, "rig.yaml"));
  if (!rig) return rig.error();
  session.rig = std::move(*rig);
  if (const std::string file = existing(path, "session.json"); !file.empty()) {
    Expected<SessionRecord> record = read_record(file);
    if (!record) return record.error();
    session.record = std::move(*record);
  }
  session.packets = existing(path, packets_name);
  if (session.packets.empty() && session_packet_parts(session_packets_path(path)).front() != session_packets_path(path))
    session.packets = session_packets_path(path);
  session.patches = existing(path, "patches");
  session.trajectory = existing(path, "trajectory.tum");
  session.images = existing(path, "images");
  session.ground_truth = existing(path, "ground_truth.yaml");
  if (session.packets.empty() && session.patches.empty()) {
    return input_error("has neither lidar.pcapng nor patches", path, "check that the whole session was copied");
  }
  return session;
}

bool is_unfinished_session(const std::string& path) {
  const std::string file = existing(path, "session.json");
  if (file.empty()) return false;
  const Expected<SessionRecord> record = read_record(file);
  return record && !record->end_ns;
}

Expected<void> create_session(const std::string& path, const Rig& rig, const SessionRecord& record) {
  std::error_code error;
  if (!fs::create_directory(path, error)) {
    // Without an error code the folder was there already.
    if (!error || error.value() == EEXIST) {
      return input_error("exists already, and a session is never overwritten", path, "choose another name");
    }
    return cannot_write(path, error.value());
  }
  Expected<void> done = replace_file(below(path, "rig.yaml"), write_rig(rig));
  if (done) done = write_session_record(path, record);
  return done;
}

Expected<void> write_session_record(const std::string& path, const SessionRecord& record) {
  // Names of devices are text from outside: bytes that are no UTF-8 are replaced, not thrown at us.
  return replace_file(below(path, "session.json"),
                      to_json(record).dump(1, ' ', false, json::error_handler_t::replace) + "\n");
}

}  // namespace rigcal
