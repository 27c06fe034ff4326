#include "apps/batch/session_record.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/common/json_text.h"
#include "core/base/sha256.h"
#include "core/base/version.h"
#include "core/io/files_below.h"
#include "core/io/output_file.h"
#include "core/report/input_digest.h"
#include "core/report/result_folder.h"

namespace rigcal::batch {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int input_code = 3;
constexpr int usage_code = 2;
constexpr int good_code = 0;
constexpr int weak_code = 1;

ByteView bytes_of(const std::string& text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

// A line for the file's state: what cannot be asked is told apart from what can.
std::string file_line(const fs::path& path, const std::string& name, std::uint64_t& bytes) {
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) return name + " -\n";
  bytes += static_cast<std::uint64_t>(found.st_size);
  // Giving a permission changes neither size nor time.
  const bool readable = ::faccessat(AT_FDCWD, path.c_str(), R_OK, AT_EACCESS) == 0;
  return name + " " + std::to_string(found.st_size) + " " + std::to_string(found.st_mtim.tv_sec) + " " +
         std::to_string(found.st_mtim.tv_nsec) + (readable ? "\n" : " unreadable\n");
}

std::optional<Json> read_json(const fs::path& path) {
  std::ifstream in(path);
  if (!in) return std::nullopt;
  Json json = Json::parse(in, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  return json;
}

// As `text` is read again out of what `json_text` has written: there, bytes that are no UTF-8 are replaced.
std::string as_recorded(const std::string& text) { return Json::parse(json_text(Json(text))).get<std::string>(); }

Json settings_json(const Settings& settings) {
  Json json = Json::object();
  for (const auto& [name, value] : settings) json[name] = value;
  return json;
}

// The options whose values differ, as "--require, --stages".
std::string changed_options(const Settings& wanted, const Json& found) {
  std::string names;
  for (const auto& [name, value] : wanted) {
    if (found.value(name, std::string()) != as_recorded(value)) names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

bool has_result(const SessionWork& work) { return fs::exists(fs::path(work.result) / "extrinsics.yaml"); }

// Empty where this version with these options made the result, whatever it made it of.
std::string made_otherwise(const SessionWork& work, const Json& report) {
  const std::string version_found = report.value(Json::json_pointer("/versions/rigcal"), std::string());
  if (version_found != version()) return "the result is of rigcal " + version_found;
  const std::string options = changed_options(work.settings, report.value("settings", Json::object()));
  return options.empty() ? options : "the result was made with another " + options;
}

// Of a result without a record: empty where it is what would be made now, else what is different.
std::string other_result(const SessionWork& work, const Json& report, const std::stop_token& stop) {
  if (const std::string otherwise = made_otherwise(work, report); !otherwise.empty()) return otherwise;
  std::vector<std::string> before;
  for (const Json& input : report.value("inputs", Json::array()))
    before.push_back(input.value("sha256", std::string()));
  std::vector<std::string> now;
  for (const InputDigest& input : digest_inputs(work.inputs, stop)) now.push_back(input.sha256);
  return before.empty() || before != now ? "the input has changed" : std::string();
}

}  // namespace

InputState input_state(const std::vector<std::string>& paths) {
  InputState state;
  Sha256 sum;
  for (const std::string& path : paths) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      sum.add(bytes_of(file_line(path, "file", state.bytes)));
      continue;
    }
    const Expected<std::vector<std::string>> names = files_below(path);
    if (!names) return {};
    for (const std::string& name : *names) sum.add(bytes_of(file_line(fs::path(path) / name, name, state.bytes)));
    sum.add(bytes_of(std::to_string(names->size()) + " files\n"));
  }
  state.digest = sum.finish();
  return state;
}

bool came_of_input(int code, const std::string& result) {
  return code == usage_code || (code == input_code && check_result_target(result));
}

std::optional<int> code_of_result(const std::string& folder) {
  const std::optional<Json> report = read_json(fs::path(folder) / "report.json");
  if (!report || !report->contains("status") || !report->at("status").is_string()) return std::nullopt;
  return report->at("status") == "good" ? good_code : weak_code;
}

std::optional<AttemptRecord> read_record(const std::string& path) {
  const std::optional<Json> json = read_json(path);
  if (!json || json->value("rigcal", 0) != format_version) return std::nullopt;
  try {
    AttemptRecord record;
    record.input = json->at("input");
    for (const auto& [name, value] : json->at("settings").items()) record.settings.emplace_back(name, value);
    record.version = json->at("version");
    record.input_state = json->at("input_state");
    record.code = json->at("code");
    record.error = json->at("error");
    record.of_input = json->value("of_input", false);
    record.wall_s = json->at("wall_s");
    record.cpu_s = json->at("cpu_s");
    record.peak_memory_mb = json->at("peak_memory_mb");
    record.host = json->at("host");
    return record;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // Not as this version writes it.
  }
}

Expected<void> write_record(const AttemptRecord& record, const std::string& path) {
  const Json json{{"rigcal", format_version},
                  {"input", record.input},
                  {"settings", settings_json(record.settings)},
                  {"version", record.version},
                  {"input_state", record.input_state},
                  {"code", record.code},
                  {"error", record.error},
                  {"of_input", record.of_input},
                  {"wall_s", record.wall_s},
                  {"cpu_s", record.cpu_s},
                  {"peak_memory_mb", record.peak_memory_mb},
                  {"host", record.host}};
  return replace_file(path, json_text(json));
}

namespace {

// The record is of what would be made now; the result in its place need not be that of the record.
Judgement judge_unchanged(const SessionWork& work, const AttemptRecord& record) {
  try {
    const std::optional<Json> report = read_json(fs::path(work.result) / "report.json");
    const std::string otherwise = report ? made_otherwise(work, *report) : "the result has no report";
    if (!otherwise.empty()) return {false, otherwise, {}};
    return {true, "nothing has changed since", record};
  } catch (const nlohmann::json::exception&) {
    return {false, "the result's report is none of this version", {}};
  }
}

Judgement judge_what_is_there(const SessionWork& work, const std::optional<AttemptRecord>& record,
                              const InputState& state, bool retry, const std::stop_token& stop) {
  // One that somebody ended says code 1, too, and an older result may be there.
  const bool ended_well = record && record->error.empty() && (record->code == good_code || record->code == weak_code);
  // Somebody may have calibrated into its place since.
  const bool solved = ended_well && has_result(work) && code_of_result(work.result) == record->code;
  const bool failed = record && !ended_well;
  if (state.digest.empty()) return {false, "the input cannot be looked at as a whole", {}};
  if (solved || failed) {
    const std::string options = changed_options(work.settings, settings_json(record->settings));
    const bool same_input = record->input_state == state.digest;
    const bool unchanged = same_input && options.empty() && record->version == version();
    if (solved && unchanged) return judge_unchanged(work, *record);
    if (failed && unchanged && !retry && record->of_input)
      return {true, "failed before, and nothing has changed since", record};
    if (failed) return {false, unchanged ? "failed before" : "failed before, and something has changed since", {}};
    if (record->version != version()) return {false, "the result is of rigcal " + record->version, {}};
    if (!options.empty()) return {false, "the result was made with another " + options, {}};
    // Files may have been copied or touched: then their bytes tell.
  }
  if (!has_result(work)) return {false, "there is no result yet", {}};
  const std::optional<Json> report = read_json(fs::path(work.result) / "report.json");
  if (!report) return {false, "the result has no report", {}};
  try {
    const std::string other = other_result(work, *report, stop);
    if (!other.empty()) return {false, other, {}};
    AttemptRecord found;
    found.input = whole_path(work.input);
    found.settings = work.settings;
    found.version = version();
    if (solved) found = *record;
    found.input_state = state.digest;
    if (!solved) {
      found.code = code_of_result(work.result).value_or(weak_code);
      found.wall_s = report->value("wall_s", 0.0);
      found.peak_memory_mb = report->value("peak_memory_mb", 0.0);
    }
    return {true, "the same bytes and options made it", found};
  } catch (const nlohmann::json::exception&) {
    return {false, "the result's report is none of this version", {}};
  }
}

// The recording that the result is of, or the failure that is on record; nothing where that is not known.
std::optional<std::string> input_of_what_is_there(const SessionWork& work, const std::optional<AttemptRecord>& record) {
  if (record) return record->input;
  const std::optional<Json> report = read_json(fs::path(work.result) / "report.json");
  if (!report) return std::nullopt;
  const Json& settings = report->contains("settings") ? report->at("settings") : *report;
  const auto input = settings.is_object() ? settings.find("INPUT") : settings.end();
  if (input == settings.end() || !input->is_string()) return std::nullopt;
  return input->get<std::string>();
}

// A path that was told from some other folder may lead nowhere from here, and says nothing then.
bool is_another(const std::string& there, const std::string& input) {
  std::error_code error;
  if (fs::path(there).is_relative() && !fs::exists(there, error)) return false;
  return whole_path(there) != as_recorded(whole_path(input));
}

}  // namespace

std::string whole_path(const std::string& input) {
  std::error_code error;
  fs::path path = fs::weakly_canonical(fs::absolute(input, error), error);
  if (!path.has_filename()) path = path.parent_path();
  return error ? input : path.string();
}

Expected<Judgement> judge_session(const SessionWork& work, const InputState& state, bool retry,
                                  const std::stop_token& stop) {
  const std::optional<AttemptRecord> record = read_record(work.record);
  Judgement judgement = judge_what_is_there(work, record, state, retry, stop);
  if (judgement.keep) return judgement;
  const std::optional<std::string> there = input_of_what_is_there(work, record);
  if (!there || !is_another(*there, work.input)) return judgement;
  return input_error(
      "its result would replace that of " + *there + ", which is called \"" + work.name + "\" there, too", work.input,
      "give both to one batch, which tells their names apart, or choose another --out; where the "
      "recording was moved, remove " +
          work.result + " and " + work.record);
}

}  // namespace rigcal::batch
