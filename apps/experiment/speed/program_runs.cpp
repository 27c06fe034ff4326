#include "apps/experiment/speed/program_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "apps/batch/child_program.h"
#include "apps/evaluation/evaluation.h"
#include "apps/evaluation/known_rig.h"
#include "core/base/seconds.h"

namespace rigcal::speed {
namespace {

namespace fs = std::filesystem;

constexpr double dump_dwell_s = 2.2;  // with the turns between the stops 4e7 shots in all
constexpr double least_scale_of_images = 0.1;
constexpr std::chrono::milliseconds look_every{2};

// Where a run fails, its last line says why.
std::string last_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::string last;
  while (std::getline(file, line)) last = line;
  return last;
}

// Runs rigcal with these arguments. Errors: it cannot be started; it ends with an exit code above 1 (1: a sensor is
// weak, which times need not mind).
Expected<ProgramRun> run_program(std::vector<std::string> arguments, const fs::path& scratch, int threads,
                                 const RunContext& context) {
  const std::string command = arguments.front();
  arguments.insert(arguments.begin(), {"--threads", std::to_string(threads), "--quiet"});
  const std::string log = (scratch / "log").string();
  const auto begin = SteadyClock::now();
  const Expected<batch::ChildProgram> child = batch::ChildProgram::start(arguments, log, -1);
  if (!child) return child.error();
  std::optional<batch::ChildEnd> end;
  bool told = false;
  while (!(end = child->ended())) {
    if (context.cancelled() && !told) child->stop();
    told = context.cancelled();
    std::this_thread::sleep_for(look_every);
  }
  if (told) return cancelled_error();
  if (end->code < 0 || end->code > 1) return system_error("rigcal " + command + " failed: " + last_line(log));
  ProgramRun out;
  out.wall_s = seconds_since(begin);
  out.cpu_s = end->cpu_s;
  out.peak_mb = end->peak_memory_mb * 1024.0 * 1024.0 / 1e6;
  return out;
}

double size_mb(const fs::path& folder, const std::string& suffix) {
  double bytes = 0.0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && entry.path().extension() == suffix) bytes += static_cast<double>(entry.file_size());
  }
  return bytes / 1e6;
}

Expected<void> read_report(const fs::path& result, const fs::path& session, ProgramRun& run) {
  std::ifstream file(result / "report.json");
  const auto report = nlohmann::json::parse(file, nullptr, false);
  if (report.is_discarded() || !report.contains("stages"))
    return input_error("is no report", (result / "report.json").string());
  for (const auto& stage : report["stages"]) {
    run.stages.emplace_back(stage.at("name").get<std::string>(), stage.at("wall_s").get<double>());
    if (stage.at("name") == "reading")
      run.points = static_cast<std::uint64_t>(stage.at("counts").at("points").get<double>());
  }
  const Expected<KnownRig> found = load_result(result.string());
  if (!found) return found.error();
  const Expected<KnownRig> truth = load_truth((session / "ground_truth.yaml").string());
  if (!truth) return truth.error();
  for (const KnownRig::Entry& sensor : found->sensors) {
    for (const KnownRig::Entry& known : truth->sensors) {
      if (known.name != sensor.name || !known.T_base_sensor || !sensor.T_base_sensor) continue;
      ++run.found;
      run.worst_m = std::max(run.worst_m, (sensor.T_base_sensor->t - known.T_base_sensor->t).norm());
    }
  }
  return {};
}

// At least one.
ProgramRun middle_of(std::vector<ProgramRun> runs) {
  const double first_wall_s = runs.front().wall_s;
  std::sort(runs.begin(), runs.end(), [](const ProgramRun& a, const ProgramRun& b) { return a.wall_s < b.wall_s; });
  ProgramRun middle = std::move(runs[(runs.size() - 1) / 2]);
  middle.first_wall_s = first_wall_s;
  middle.runs = static_cast<int>(runs.size());
  return middle;
}

// A folder that is gone again when the experiment is over.
class ScratchFolder {
 public:
  static Expected<ScratchFolder> make(fs::path path) {
    if (!path.has_filename()) path = path.parent_path();  // of "folder/" that is the folder itself
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (!fs::create_directory(path, error)) {
      return system_error("cannot be made" + (error ? ": " + error.message() : ", it is there already"), path.string(),
                          "name another folder by --scratch DIR");
    }
    return ScratchFolder(path);
  }
  ScratchFolder(ScratchFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  ~ScratchFolder() {
    std::error_code error;
    if (!path_.empty()) fs::remove_all(path_, error);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  explicit ScratchFolder(fs::path path) : path_(std::move(path)) {}
  fs::path path_;
};

}  // namespace

double ProgramRun::until_lidars_s() const {
  double sum = 0.0;
  for (const auto& [stage, s] : stages) {
    sum += s;
    if (stage == "verdict") break;
  }
  return sum;
}

double ProgramRun::cameras_s() const {
  // Between the verdict of the LiDARs and the map.
  double sum = 0.0;
  bool begun = false;
  for (const auto& [stage, s] : stages) {
    if (stage == "map") break;
    if (begun) sum += s;
    begun |= stage == "verdict";
  }
  return sum;
}

Expected<std::vector<ProgramRun>> time_programs(const ProgramOptions& options, const RunContext& context) {
  Expected<ScratchFolder> scratch = ScratchFolder::make(options.scratch);
  if (!scratch) return scratch.error();
  if (context.cancelled()) return cancelled_error();
  const fs::path session = scratch->path() / "session";
  const fs::path patches = scratch->path() / "patches";
  const fs::path result = scratch->path() / "result";
  // Images are as large at every scale.
  const bool with_images = options.scale >= least_scale_of_images;
  const std::string dwell = fmt::format("{:.2f}", std::max(0.6, options.scale * dump_dwell_s));
  const auto run = [&](const std::vector<std::string>& arguments) {
    return run_program(arguments, scratch->path(), options.threads, context);
  };
  context.reporter.progress("programs", 0.0);
  const auto simulated =
      run({"simulate", "courtyard", "--rig", options.rig, "--out", session.string(), "--stops", "20", "--dwell", dwell,
           "--images-per-stop", with_images ? "1" : "0", "--seed", std::to_string(options.seed)});
  if (!simulated) return simulated.error();
  context.reporter.progress("programs", 0.4);
  const auto exported = run({"export", session.string(), "--format", "patches", "--out", patches.string()});
  if (!exported) return exported.error();
  struct Job {
    const char* name;
    fs::path input;
    const char* suffix;  // of the files that hold its points
    const char* stages;
  };
  std::vector<Job> jobs{{"patches", patches, ".pcd", "joint"}, {"dump", session, ".pcapng", "joint"}};
  if (with_images) jobs.push_back({"dump and images", session, ".pcapng", "cameras"});
  std::vector<ProgramRun> out;
  for (const Job& job : jobs) {
    context.reporter.progress("programs", 0.5 + 0.1 * static_cast<double>(out.size()));
    std::vector<ProgramRun> all;
    while (static_cast<int>(all.size()) < options.runs) {
      Expected<ProgramRun> done = run({"calibrate", job.input.string(), "--rig", (session / "rig.yaml").string(),
                                       "--stages", job.stages, "--out", result.string()});
      if (!done) return done.error();
      if (const auto read = read_report(result, session, *done); !read) return read.error();
      all.push_back(std::move(*done));
    }
    out.push_back(middle_of(std::move(all)));
    out.back().name = job.name;
    out.back().input_mb = size_mb(job.input, job.suffix);
  }
  return out;
}

}  // namespace rigcal::speed
