#include <fmt/format.h>

#include "apps/experiment/targetless/experiment.h"
#include "apps/experiment/targetless/published.h"
#include "core/geometry/se3.h"

namespace rigcal::targetless {
namespace {

std::string iterations_text(const IterationsExperiment& experiment) {
  std::string text = fmt::format(
      "Error against iteration (Fig. 10), {} trials; guesses off by {:.2f} +- {:.2f} degrees and {:.4f} +- {:.4f} m\n"
      "(paper: 100 trials, {:.2f} +- {:.2f} degrees and {:.4f} +- {:.4f} m; all of its own converge within {} "
      "iterations, ICP slows down after {})\n",
      experiment.trials, to_deg(experiment.guess_rotation_rad.mean), to_deg(experiment.guess_rotation_rad.spread),
      experiment.guess_translation_m.mean, experiment.guess_translation_m.spread, published::fig10_rotation_deg,
      published::fig10_rotation_spread_deg, published::fig10_translation_m, published::fig10_translation_spread_m,
      published::fig10_iterations, published::fig10_icp_iterations);
  for (const MethodIterations& method : experiment.methods) {
    const std::string right = method.most_to_be_right
                                  ? fmt::format("right for good after {} iterations at most", *method.most_to_be_right)
                                  : "never right for good";
    text += fmt::format(
        "{}: {}; {:.3f} s an iteration, {:.2f} s a trial\n"
        "  iteration   rotation deg (spread)   translation mm (spread)   right\n",
        method.method, right, method.iteration_s, method.seconds);
    for (std::size_t k = 0; k < method.after.size(); ++k) {
      const IterationFigures& f = method.after[k];
      text +=
          fmt::format("  {:>9}   {:9.4f} ({:9.4f})   {:11.2f} ({:9.2f})   {:>5}\n", k, to_deg(f.rotation_rad.mean),
                      to_deg(f.rotation_rad.spread), 1e3 * f.translation_m.mean, 1e3 * f.translation_m.spread, f.right);
    }
  }
  return text + "\n";
}

std::string basin_text(const std::vector<BasinCell>& cells) {
  std::string text =
      "Basin (Fig. 11): how many trials end with every LiDAR within 2 cm and 0.2 degrees, and their median errors\n"
      "  guess off by        method   right         deg       mm   paper's own method\n";
  for (const BasinCell& cell : cells) {
    text += fmt::format("  {:2.0f} deg {:3.1f} m   {:>12}   {:>3} of {:<3}  {:8.4f} {:8.2f}   {}\n", cell.rotation_deg,
                        cell.translation_m, cell.method, cell.right, cell.trials, to_deg(cell.median_rotation_rad),
                        1e3 * cell.median_translation_m,
                        cell.method == "rigcal" ? published::basin_words(cell.rotation_deg, cell.translation_m) : "");
  }
  return text + "\n";
}

std::string chain_text(const std::vector<ChainRow>& rows) {
  std::string text =
      "Chain (Fig. 9): the outer units of a MID-100 from its middle one, mean (spread)\n"
      "  rig       scene       method    rotation deg          translation mm         found\n";
  for (const ChainRow& row : rows) {
    text += fmt::format("  {:<8}  {:<10}  {:<7}  {:8.4f} ({:7.4f})   {:9.2f} ({:8.2f})   {:>2} of {}\n", row.rig,
                        row.scene, row.method, to_deg(row.rotation_rad.mean), to_deg(row.rotation_rad.spread),
                        1e3 * row.translation_m.mean, 1e3 * row.translation_m.spread, row.found, row.pairs);
  }
  return text + "\n";
}

std::string seconds_text(double seconds) { return seconds > 0.0 ? fmt::format("{:8.4f}", seconds) : "       -"; }

std::string time_text(const TimeExperiment& time) {
  std::string text = fmt::format(
      "Seconds of one iteration (Table I), {} points in {} patches; once before: cells {:.3f} s, normals and trees "
      "{:.3f} "
      "s\n  stage      method               match    solve    total   of last     matched   paper: match    solve\n",
      time.points, time.patches, time.ours_prepare_s, time.icp_prepare_s);
  for (const StageSeconds& row : time.stages) {
    const auto of_stage = [&](const auto& other) { return other.stage == row.stage; };
    double icp_s = 0.0;
    for (const StageSeconds& other : time.stages) {
      if (of_stage(other) && other.method == "ICP, all points") icp_s = other.match_s + other.solve_s;
    }
    const double total_s = row.match_s + row.solve_s;
    text += fmt::format("  {:<9}  {:<15}  {:8.4f} {:8.4f} {:8.4f} {:9.4f}  {:>10}", row.stage, row.method, row.match_s,
                        row.solve_s, total_s, icp_s > 0.0 ? total_s / icp_s : 0.0, row.matched);
    for (const published::StageSeconds& paper : published::table_1) {
      if (of_stage(paper) && paper.method == row.method)
        text += "        " + seconds_text(paper.match_s) + " " + seconds_text(paper.solve_s);
    }
    text += "\n";
  }
  return text + "\n";
}

std::string camera_time_text(const std::vector<CameraSeconds>& rows) {
  std::string text =
      "Seconds for a camera (Table II): features of the map once, then one iteration with all images (information: one "
      "evaluation)\n"
      "  method           planes    edges    match    solve   voxels   edge points   paper: planes, edges, match, "
      "solve, "
      "voxels\n";
  for (const CameraSeconds& row : rows) {
    text += fmt::format("  {:<12}   {} {} {} {}  {:>7}   {:>11}", row.method, seconds_text(row.planes_s),
                        seconds_text(row.edges_s), seconds_text(row.match_s), seconds_text(row.solve_s), row.voxels,
                        row.edge_points);
    for (const published::CameraSeconds& paper : published::table_2) {
      if (paper.method != row.method) continue;
      text += fmt::format("        {} {} {} {} {:>6}", seconds_text(paper.planes_s), seconds_text(paper.edges_s),
                          seconds_text(paper.match_s), seconds_text(paper.solve_s), paper.voxels);
    }
    text += "\n";
  }
  return text + "\n";
}

std::string cameras_text(const CameraExperiment& experiment) {
  std::string text = fmt::format(
      "Cameras (Figs. 13 and 14), {} trials; guesses off by {:.2f} +- {:.2f} degrees and {:.4f} +- {:.4f} m (paper: 50 "
      "trials, {:.2f} +- {:.2f} and {:.4f} +- {:.4f}; it claims {} degrees and {} mm)\n"
      "  pair              LiDAR          overlap  method        rotation deg, median, mean (spread)   translation mm, "
      "median, mean (spread)   found      seconds\n",
      experiment.trials, to_deg(experiment.guess_rotation_rad.mean), to_deg(experiment.guess_rotation_rad.spread),
      experiment.guess_translation_m.mean, experiment.guess_translation_m.spread, published::fig13.rotation_deg,
      published::fig13.rotation_spread_deg, published::fig13.translation_m, published::fig13.translation_spread_m,
      published::camera_rotation_deg, 1e3 * published::camera_translation_m);
  for (const CameraRow& row : experiment.rows) {
    text += fmt::format(
        "  {:<16}  {:<13}  {:<7}  {:<12}  {:8.4f} {:8.4f} ({:8.4f})          {:8.2f} {:8.2f} ({:8.2f})         {:>3} "
        "of "
        "{:<3}  {:6.2f}\n",
        row.pair, row.lidar, row.overlaps ? "yes" : "no", row.method, to_deg(row.median_rotation_rad),
        to_deg(row.rotation_rad.mean), to_deg(row.rotation_rad.spread), 1e3 * row.median_translation_m,
        1e3 * row.translation_m.mean, 1e3 * row.translation_m.spread, row.found, row.trials, row.seconds);
  }
  return text + "\n";
}

}  // namespace

std::string experiment_text(const Experiment& experiment) {
  std::string text;
  if (experiment.iterations) text += iterations_text(*experiment.iterations);
  if (!experiment.basin.empty()) text += basin_text(experiment.basin);
  if (!experiment.chain.empty()) text += chain_text(experiment.chain);
  if (experiment.time) text += time_text(*experiment.time);
  if (!experiment.camera_time.empty()) text += camera_time_text(experiment.camera_time);
  if (experiment.cameras) text += cameras_text(*experiment.cameras);
  return text;
}

}  // namespace rigcal::targetless
