#include <fmt/format.h>

#include "apps/targetless/experiment.h"
#include "apps/targetless/published.h"
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
    text += fmt::format(
        "{}: right for good after {} iterations at most; {:.3f} s an iteration, {:.2f} s a trial\n"
        "  iteration   rotation deg (spread)   translation mm (spread)   right\n",
        method.method, method.most_to_be_right, method.iteration_s, method.seconds);
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

}  // namespace

std::string experiment_text(const Experiment& experiment) {
  std::string text;
  if (experiment.iterations) text += iterations_text(*experiment.iterations);
  if (!experiment.basin.empty()) text += basin_text(experiment.basin);
  return text;
}

}  // namespace rigcal::targetless
