#include <fmt/format.h>

#include <algorithm>

#include "apps/experiment/speed/experiment.h"

namespace rigcal::speed {
namespace {

std::string goals_text(const std::vector<Goal>& goals) {
  std::string text =
      "Goals                                                   measured       goal   published program\n";
  for (const Goal& goal : goals) {
    text += fmt::format("  {:<52}  {:8.3f}   {:8.2f}        {:8.2f} {:<2}  {}\n", goal.what, goal.measured, goal.goal,
                        goal.known, goal.unit, goal.measured <= goal.goal ? "met" : "missed");
  }
  return text + "\n";
}

std::string programs_text(const std::vector<ProgramRun>& programs) {
  std::string text = fmt::format("The program itself, from its start to its end, the middle one of {} runs each\n",
                                 programs.front().runs);
  for (const ProgramRun& run : programs) {
    text += fmt::format(
        "  {}: {:.2f} s (the first {:.2f} s), {:.2f} s of processors, at most {:.0f} MB; {:.1f} M points in stops, "
        "{:.0f} MB read; the "
        "worst of {} sensors found {:.2f} mm off\n   ",
        run.name, run.wall_s, run.first_wall_s, run.cpu_s, run.peak_mb, 1e-6 * static_cast<double>(run.points),
        run.input_mb, run.found, 1e3 * run.worst_m);
    for (const auto& [stage, s] : run.stages) text += fmt::format(" {} {:.2f},", stage, s);
    text.back() = '\n';
  }
  return text + "\n";
}

std::string table_text(const StageTable& table, const Bandwidth& bandwidth) {
  std::string text = fmt::format(
      "Stages of {:.1f} M points: {} LiDARs, {} stops, {} cells, {} planes, {} observations; {:.0f} MB beside the "
      "points; worst LiDAR {:.2f} mm off\n"
      "  stage                          s   processors     M points/s      GB/s   of the memory's reading\n",
      1e-6 * static_cast<double>(table.points), table.lidars, table.stops, table.cells, table.planes,
      table.observations, table.memory_mb, 1e3 * table.worst_m);
  for (const StageSpeed& stage : table.stages) {
    const std::string cpu = stage.cpu_s > 0.0 ? fmt::format("{:8.4f} s", stage.cpu_s) : std::string("         -");
    text += fmt::format("  {:<24}  {:8.4f}   {}   {:10.1f}", stage.stage, stage.seconds, cpu,
                        1e-6 * static_cast<double>(table.points) / stage.seconds);
    if (stage.bytes > 0.0) {
      const double rate = stage.bytes / stage.seconds;
      text += fmt::format("  {:8.2f}   {:8.1f} %", 1e-9 * rate, 100.0 * rate / bandwidth.read_bytes_per_s);
    }
    text += "\n";
  }
  return text + fmt::format("  points to extrinsics      {:8.4f}   {:8.4f} s   {:10.1f}\n\n", table.calibration_s(),
                            table.calibration_cpu_s, 1e-6 * static_cast<double>(table.points) / table.calibration_s());
}

std::string scans_text(const ManyScans& scans) {
  return fmt::format(
      "{} scans of one LiDAR: {:.1f} M points, {} planes, {} pairs of a plane and a pose: points to planes {:.3f} s "
      "({:.3f} s of processors), one iteration {:.4f} s ({:.4f} s)\n(the best published program: 177 scans, 13 M "
      "points, 2300 planes, 1.2e5 pairs: 2.2 s, "
      "0.3 s)\n\n",
      scans.table.stops, 1e-6 * static_cast<double>(scans.table.points), scans.table.planes, scans.table.observations,
      scans.map_s, scans.map_cpu_s, scans.iteration_s, scans.iteration_cpu_s);
}

std::string growth_text(const std::vector<GrowthRow>& rows) {
  std::string text =
      "Growth: seconds of processor, all threads together, and megabytes\n"
      "  by              size      cells        map  iteration  calibration       MB\n";
  for (const GrowthRow& row : rows) {
    const auto number = [](double s) { return s > 0.0 ? fmt::format("{:9.4f}", s) : std::string("        -"); };
    text += fmt::format("  {:<8}  {:>10.0f}  {}  {}  {}    {}  {:7.0f}\n", row.by, row.size, number(row.cells_s),
                        number(row.map_s), number(row.iteration_s), number(row.calibration_s), row.memory_mb);
  }
  return text + "\n";
}

}  // namespace

std::string experiment_text(const Experiment& experiment) {
  std::string text =
      fmt::format("{} threads; memory: {:.1f} GB/s read, {:.1f} GB/s copied (read and written)\n\n", experiment.threads,
                  1e-9 * experiment.bandwidth.read_bytes_per_s, 1e-9 * experiment.bandwidth.copy_bytes_per_s);
  const std::vector<Goal> goals = goals_of(experiment);
  if (!goals.empty()) text += goals_text(goals);
  if (!experiment.programs.empty()) text += programs_text(experiment.programs);
  for (const StageTable& table : experiment.tables) text += table_text(table, experiment.bandwidth);
  if (experiment.scans) text += scans_text(*experiment.scans);
  if (!experiment.growth.empty()) text += growth_text(experiment.growth);
  return text;
}

}  // namespace rigcal::speed
