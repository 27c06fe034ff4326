#include "apps/batch/batch_run.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <thread>
#include <tuple>

#include "apps/batch/batch_table.h"
#include "apps/batch/child_program.h"
#include "apps/batch/memory_budget.h"
#include "apps/batch/session_claim.h"
#include "core/base/seconds.h"
#include "core/base/version.h"
#include "core/io/output_file.h"

namespace rigcal::batch {
namespace {

namespace fs = std::filesystem;

constexpr const char* own_folder = ".batch";
constexpr auto poll_period = std::chrono::milliseconds(50);
constexpr auto others_period = std::chrono::seconds(1);  // Between two looks at what other workers have.
constexpr auto table_period = std::chrono::seconds(2);
constexpr double memory_share = 0.9;
constexpr double least_share = 0.05;  // Of all bytes: less is no measure of how long the rest will take.

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string();
}

// A new result is another file, whatever its text.
using FileIdentity = std::tuple<dev_t, ino_t, time_t, long>;
FileIdentity identity_of(const fs::path& path) {
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) return {};
  return {found.st_dev, found.st_ino, found.st_mtim.tv_sec, found.st_mtim.tv_nsec};
}

// The last error in what a calibration said.
std::string last_error(const std::string& log) {
  constexpr std::string_view prefix = "rigcal: error: ";
  std::ifstream in(log);
  std::string error;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(prefix, 0) == 0) error = line.substr(prefix.size());
  }
  return error;
}

std::string failure_text(const ChildEnd& end, const std::string& log) {
  if (end.signal != 0) {
    return std::string("the calibration was ended by a signal (") + ::strsignal(end.signal) + ")" +
           (end.signal == SIGKILL ? "; where memory is short, give fewer --jobs or less --memory" : "");
  }
  const std::string error = last_error(log);
  return error.empty() ? "ended with exit code " + std::to_string(end.code) + " and no word" : error;
}

// What a killed calibration left of a result: hidden folders ".NAME.part123-0". Only for who holds the claim.
void remove_parts(const fs::path& out, const std::string& name) {
  const std::string start = "." + name + ".part";
  std::error_code error;
  for (fs::directory_iterator at(out, error), end; !error && at != end; at.increment(error)) {
    const std::string found = at->path().filename().string();
    if (found.rfind(start, 0) == 0 && found.find_first_not_of("0123456789-", start.size()) == std::string::npos)
      fs::remove_all(at->path(), error);
  }
}

Expected<void> make_folder(const fs::path& out) {
  std::error_code error;
  if (fs::exists(out, error) && !fs::is_directory(out, error))
    return input_error("a file stands where the folder of the batch should go", out.string(), "choose another --out");
  if (!fs::exists(out / own_folder, error) && fs::is_directory(out, error) && !fs::is_empty(out, error))
    return input_error("is not empty and no folder of a batch", out.string(), "choose another --out");
  fs::create_directories(out / own_folder, error);
  if (error) return cannot_write(out.string(), error.value());
  return {};
}

// A session that is being calibrated.
struct Running {
  std::size_t row;
  SessionClaim claim;
  ChildProgram child;
  std::string input_state;
  FileIdentity before;
  SteadyClock::time_point begun;
};

class Batch {
 public:
  Batch(const std::vector<Session>& sessions, const BatchOptions& options, const BatchWatcher& watcher,
        const std::stop_token& stop)
      : options_(options), watcher_(watcher), stop_(stop), host_(host_name()), memory_(budget(options)) {
    for (const Session& session : sessions) {
      outcome_.rows.push_back({});
      outcome_.rows.back().session = session;
      outcome_.rows.back().result = (fs::path(options.out) / session.name).string();
      waiting_.push_back(waiting_.size());
    }
    states_.resize(sessions.size());
    outcome_.jobs = std::clamp(options.jobs > 0 ? options.jobs : options.threads, 1, static_cast<int>(sessions.size()));
    outcome_.threads_each = std::max(1, options.threads / outcome_.jobs);
  }

  Expected<BatchOutcome> run() {
    Expected<void> done = work();
    for (const Running& one : running_) one.child.stop();
    while (!running_.empty()) {  // After an error.
      std::this_thread::sleep_for(poll_period);
      if (const auto reaped = reap(); !reaped && done) done = reaped;
    }
    if (!done) return done.error();
    outcome_.stopped = stop_.stop_requested();
    if (const auto written = write_table(true); !written) return written.error();
    return std::move(outcome_);
  }

 private:
  static std::uint64_t budget(const BatchOptions& options) {
    if (options.memory > 0) return options.memory;
    // Where it is not known, one at a time.
    return static_cast<std::uint64_t>(memory_share * static_cast<double>(available_memory().value_or(0)));
  }

  Expected<void> work() {
    if (const auto sorted = keep_what_is_done(); !sorted) return sorted;
    bool told_to_stop = false;
    while (!waiting_.empty() || !running_.empty()) {
      if (stop_.stop_requested()) {
        waiting_.clear();
        if (!told_to_stop) {
          for (const Running& one : running_) one.child.stop();
        }
        told_to_stop = true;
      } else if (const auto started = start_what_fits(); !started) {
        return started;
      }
      if (const auto reaped = reap(); !reaped) return reaped;
      if (const auto written = write_table(false); !written) return written;
      tell();
      std::this_thread::sleep_for(poll_period);
    }
    return {};
  }

  // Before the first calibration, so that it is known how much there is to do.
  Expected<void> keep_what_is_done() {
    std::deque<std::size_t> left;
    for (const std::size_t row : waiting_) {
      if (stop_.stop_requested()) break;
      Expected<std::optional<SessionClaim>> claim = SessionClaim::take(own_file(row, ".claim"));
      if (!claim) return claim.error();
      if (!*claim) {
        left.push_back(row);
        continue;
      }
      const Expected<bool> kept = judge(row);
      if (!kept) return kept.error();
      if (!*kept) left.push_back(row);
      tell();
    }
    waiting_ = std::move(left);
    return {};
  }

  // Goes once through what waits; what others have is looked at again a second later.
  Expected<void> start_what_fits() {
    if (SteadyClock::now() < look_again_) return {};
    std::deque<std::size_t> taken_by_others;
    while (!waiting_.empty() && !stop_.stop_requested() && has_room()) {
      const std::size_t row = waiting_.front();
      waiting_.pop_front();
      Expected<std::optional<SessionClaim>> claim = SessionClaim::take(own_file(row, ".claim"));
      if (!claim) return claim.error();
      if (!*claim) {
        taken_by_others.push_back(row);
        was_taken_[row] = true;
      } else if (const auto done = judge_and_start(row, std::move(**claim)); !done) {
        return done;
      }
    }
    if (waiting_.empty() && !taken_by_others.empty()) look_again_ = SteadyClock::now() + others_period;
    waiting_.insert(waiting_.end(), taken_by_others.begin(), taken_by_others.end());
    return {};
  }

  [[nodiscard]] bool has_room() const {
    const int running = static_cast<int>(running_.size());
    return running < outcome_.jobs && memory_.fits(running);
  }

  // Under its claim: true where the session need not be calibrated.
  Expected<bool> judge(std::size_t index) {
    SessionRow& row = outcome_.rows[index];
    SessionWork work{row.session.name,  row.session.input, {row.session.input},
                     options_.settings, row.result,        own_file(index, ".json")};
    work.inputs.insert(work.inputs.end(), options_.inputs.begin(), options_.inputs.end());
    states_[index] = input_state(work.inputs);
    const Expected<Judgement> judgement =
        judge_session(work, states_[index], options_.retry && !was_taken_[index], stop_);
    if (!judgement) return judgement.error();
    row.why = judgement->why;
    if (!judgement->keep) return false;
    row.kept = true;
    row.record = *judgement->record;
    if (was_taken_[index]) row.why = "another worker has just done it";
    complete_row(row);
    ++kept_;
    table_is_old_ = true;
    if (const auto written = write_record(row.record, work.record); !written) return written.error();
    return true;
  }

  Expected<void> judge_and_start(std::size_t index, SessionClaim claim) {
    const Expected<bool> kept = judge(index);
    if (!kept) return kept.error();
    if (*kept || stop_.stop_requested()) return {};
    return start(index, std::move(claim));
  }

  Expected<void> start(std::size_t index, SessionClaim claim) {
    SessionRow& row = outcome_.rows[index];
    remove_parts(options_.out, row.session.name);
    // The input behind "--", because its name may begin with one.
    std::vector<std::string> arguments{"calibrate", "--quiet", "--threads", std::to_string(outcome_.threads_each),
                                       "--out",     row.result};
    arguments.insert(arguments.end(), options_.arguments.begin(), options_.arguments.end());
    arguments.insert(arguments.end(), {"--", row.session.input});
    Expected<ChildProgram> child = ChildProgram::start(arguments, own_file(index, ".log"), claim.descriptor());
    if (!child) return child.error();
    running_.push_back({index, std::move(claim), *child, states_[index].digest,
                        identity_of(fs::path(row.result) / "extrinsics.yaml"), SteadyClock::now()});
    return {};
  }

  Expected<void> reap() {
    for (std::size_t k = 0; k < running_.size();) {
      const std::optional<ChildEnd> end = running_[k].child.ended();
      if (!end) {
        ++k;
        continue;
      }
      const Running one = std::move(running_[k]);
      running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(k));
      if (const auto noted = note_end(one, *end); !noted) return noted;
    }
    return {};
  }

  Expected<void> note_end(const Running& one, const ChildEnd& end) {
    SessionRow& row = outcome_.rows[one.row];
    remove_parts(options_.out, row.session.name);
    const bool has_new_result = identity_of(fs::path(row.result) / "extrinsics.yaml") != one.before;
    int code = end.code;
    // It may have been told to end when all was written, since a result comes into its place whole.
    if (stop_.stop_requested() && has_new_result) code = code_of_result(row.result).value_or(code);
    const bool solved = (code == 0 || code == 1) && has_new_result;
    if (!solved && stop_.stop_requested()) return {};  // As it was told; nothing is known of the session.
    row.record = {};
    row.record.input = whole_path(row.session.input);
    row.record.settings = options_.settings;
    row.record.version = version();
    row.record.input_state = one.input_state;
    row.record.code = code;
    row.record.host = host_;
    if (!solved) {
      row.record.error = failure_text(end, own_file(one.row, ".log"));
      row.record.of_input = came_of_input(code, row.result);
    }
    row.record.wall_s = seconds_since(one.begun);
    row.record.cpu_s = end.cpu_s;
    row.record.peak_memory_mb = end.peak_memory_mb;
    memory_.saw_peak(end.peak_memory_mb);
    complete_row(row);
    ++done_;
    if (solved) {
      ++solved_;
      bytes_done_ += static_cast<double>(states_[one.row].bytes);
    } else {
      failed_s_ += row.record.wall_s;
    }
    table_is_old_ = true;
    if (watcher_.news) {
      std::array<char, 64> took{};
      std::snprintf(took.data(), took.size(), ", %.1f s", row.record.wall_s);
      watcher_.news(row.session.name + ": " + row.status + took.data() + (row.error.empty() ? "" : ": " + row.error));
    }
    return write_record(row.record, own_file(one.row, ".json"));
  }

  // Whoever has the table's claim writes what it knows; the last of several workers knows all.
  Expected<void> write_table(bool last) {
    if (!last && (!table_is_old_ || SteadyClock::now() < next_table_)) return {};
    for (int tries = last ? 100 : 1; tries > 0; --tries) {
      const auto claim = SessionClaim::take((fs::path(options_.out) / own_folder / ".table.claim").string());
      if (!claim) return claim.error();
      if (!*claim) {
        if (tries > 1) std::this_thread::sleep_for(poll_period);
        continue;
      }
      outcome_.wall_s = seconds_since(begun_);
      if (const auto done = replace_file((fs::path(options_.out) / "batch.csv").string(), batch_csv(outcome_)); !done)
        return done;
      table_is_old_ = false;
      next_table_ = SteadyClock::now() + table_period;
      return replace_file((fs::path(options_.out) / "batch.json").string(), batch_json(outcome_, options_.out));
    }
    if (last) return system_error("another worker does not let go of the table", options_.out, "start again");
    return {};
  }

  void tell() const {
    if (!watcher_.progress) return;
    const std::size_t all = outcome_.rows.size();
    int failed = 0;
    double bytes_left = 0.0;
    for (std::size_t k = 0; k < all; ++k) {
      failed += outcome_.rows[k].status == "failed" ? 1 : 0;
      if (outcome_.rows[k].status != "waiting") continue;
      // One that was not looked at yet is like those that are done.
      bytes_left += states_[k].bytes > 0 ? static_cast<double>(states_[k].bytes) : bytes_done_ / std::max(solved_, 1);
    }
    const int ended = done_ + kept_;
    std::string text = std::to_string(ended) + " of " + std::to_string(all) + " sessions";
    if (failed > 0) text += ", " + std::to_string(failed) + " failed";
    const double spent_s = seconds_since(begun_) - failed_s_ / outcome_.jobs;
    if (!stop_.stop_requested()) text += forecast_text(spent_s, bytes_done_, bytes_left);
    if (stop_.stop_requested()) text += ", stopping";
    watcher_.progress(text, static_cast<double>(ended) / static_cast<double>(all));
  }

  [[nodiscard]] std::string own_file(std::size_t row, const char* ending) const {
    return (fs::path(options_.out) / own_folder / (outcome_.rows[row].session.name + ending)).string();
  }

  const BatchOptions& options_;
  const BatchWatcher& watcher_;
  std::stop_token stop_;
  std::string host_;
  MemoryBudget memory_;
  BatchOutcome outcome_;
  std::deque<std::size_t> waiting_;
  std::vector<Running> running_;
  std::map<std::size_t, bool> was_taken_;  ///< Rows that another worker had when this one looked.
  std::vector<InputState> states_;         ///< Of each session, as it was looked at last.
  double bytes_done_ = 0.0;                ///< Of those calibrated here that have a result;
  double failed_s_ = 0.0;                  ///< what those took that have none says nothing of the rest.
  int solved_ = 0;
  int done_ = 0;
  int kept_ = 0;
  bool table_is_old_ = true;
  SteadyClock::time_point begun_ = SteadyClock::now();
  SteadyClock::time_point look_again_ = SteadyClock::now();
  SteadyClock::time_point next_table_ = SteadyClock::now();
};

}  // namespace

std::string forecast_text(double spent_s, double bytes_done, double bytes_left) {
  if (!(bytes_done > 0.0) || bytes_done < least_share * (bytes_done + bytes_left)) return {};
  const double left_s = std::max(0.0, spent_s) * bytes_left / bytes_done;
  return left_s < 90.0 ? ", about " + std::to_string(std::lround(left_s)) + " s left"
                       : ", about " + std::to_string(std::lround(left_s / 60.0)) + " min left";
}

Expected<BatchOutcome> run_batch(const std::vector<Session>& sessions, const BatchOptions& options,
                                 const BatchWatcher& watcher, const std::stop_token& stop) {
  if (const auto made = make_folder(options.out); !made) return made.error();
  return Batch(sessions, options, watcher, stop).run();
}

}  // namespace rigcal::batch
