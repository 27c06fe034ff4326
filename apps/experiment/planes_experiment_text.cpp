#include "apps/experiment/planes_experiment_text.h"

#include <fmt/format.h>

#include "apps/experiment/experiment_json.h"
#include "apps/experiment/svg_file.h"
#include "core/report/svg_plot.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

std::string row_text(const CornerRow& row) {
  const auto both = [](const ErrorFigures& f) {
    return fmt::format("{:.5f} ({:.5f}) {:7.2f} ({:6.2f})", f.rotation_rad, f.rotation_stddev_rad,
                       1e3 * f.translation_m, 1e3 * f.translation_stddev_m);
  };
  return fmt::format("{:>5} {:>5} | {} | {} | {} | {}{}{}\n", row.configuration, row.angle_deg, both(row.paper),
                     both(row.published), both(row.found), both(row.informed),
                     row.published_failed > 0 ? fmt::format("  {} failed as published", row.published_failed) : "",
                     row.failed > 0 ? fmt::format("  {} failed", row.failed) : "");
}

std::string table_text(const PlanesExperiment& experiment, bool shared) {
  std::string text = fmt::format(
      "Table II, {} trials a row, noise {}: mean (spread) of rotation rad and translation mm\n"
      "conf. angle | paper, 10 trials                 | as published                     | planes                   "
      "        | told which point is on which plane\n",
      experiment.trials, shared ? "shared by both clouds" : "independent");
  for (const CornerRow& row : experiment.table) {
    if (row.shared_noise == shared) text += row_text(row);
  }
  return text + "\n";
}

std::string vehicle_text(const VehicleExperiment& vehicle) {
  std::string text = "A vehicle with three LiDARs of 16 beams in a court, medians over the places:\n";
  for (const VehicleRow& row : vehicle.rows) {
    for (const WayFigures& way : row.ways) {
      text += fmt::format("{:<6} {:<15} {:.4f} rad  {:8.1f} mm   {} of {} places\n", row.pair, way.way,
                          way.rotation_rad, 1e3 * way.translation_m, way.answers, row.places);
    }
  }
  return text;
}

Json figures_json(const ErrorFigures& f) {
  return {{"rotation_rad", f.rotation_rad},
          {"rotation_stddev_rad", f.rotation_stddev_rad},
          {"translation_m", f.translation_m},
          {"translation_stddev_m", f.translation_stddev_m}};
}

std::string mountings_text(const MountingFigures& m, const std::string& what) {
  return fmt::format(
      "{} {}: {} right, {} called good, {} weak, {} wrong ones called good, {} right ones flagged; {:.3f} s each "
      "(median), {:.3f} s the longest\n",
      m.trials, what, m.right, m.good, m.weak, m.wrong_good, m.right_flagged, m.median_s, m.worst_s);
}

Json mountings_json(const MountingFigures& m) {
  return {{"trials", m.trials},     {"right", m.right},           {"good", m.good},
          {"weak", m.weak},         {"wrong_good", m.wrong_good}, {"right_flagged", m.right_flagged},
          {"median_s", m.median_s}, {"worst_s", m.worst_s}};
}

}  // namespace

std::string planes_experiment_text(const PlanesExperiment& experiment) {
  return table_text(experiment, true) + table_text(experiment, false) +
         mountings_text(experiment.mountings, "random mountings") +
         mountings_text(experiment.right_angles, "corners of right angles in two fields of view") +
         mountings_text(experiment.right_angles_guessed, "of these with a guess 45 degrees off") + "\n" +
         vehicle_text(experiment.vehicle);
}

std::string planes_experiment_json(const PlanesExperiment& experiment) {
  Json json = experiment_head("planes");
  json["paper"] = "planes";  // The older name.
  json["trials"] = experiment.trials;
  json["table"] = Json::array();
  for (const CornerRow& row : experiment.table) {
    json["table"].push_back({{"configuration", row.configuration},
                             {"angle_deg", row.angle_deg},
                             {"noise", row.shared_noise ? "shared" : "independent"},
                             {"paper", figures_json(row.paper)},
                             {"as_published", figures_json(row.published)},
                             {"planes", figures_json(row.found)},
                             {"informed", figures_json(row.informed)},
                             {"published_failed", row.published_failed},
                             {"failed", row.failed}});
  }
  json["mountings"] = mountings_json(experiment.mountings);
  json["right_angles"] = mountings_json(experiment.right_angles);
  json["right_angles_guessed"] = mountings_json(experiment.right_angles_guessed);
  json["vehicle"] = Json::array();
  for (const VehicleRow& row : experiment.vehicle.rows) {
    for (const WayFigures& way : row.ways) {
      json["vehicle"].push_back({{"pair", row.pair},
                                 {"way", way.way},
                                 {"places", row.places},
                                 {"answers", way.answers},
                                 {"rotation_rad", way.rotation_rad},
                                 {"translation_m", way.translation_m}});
    }
  }
  return json_text(json);
}

std::string moment_svg(const VehicleMoment& moment, const SE3& T_a_b, const std::string& title) {
  constexpr double half_m = 20.0;
  const auto from_above = [](const std::vector<Vector3d>& cloud, const SE3& T) {
    std::vector<PlotPoint> points;
    for (std::size_t k = 0; k < cloud.size(); k += 3) {
      const Vector3d p = T * cloud[k];
      if (std::abs(p.x()) < half_m && std::abs(p.y()) < half_m) points.push_back({p.x(), p.y()});
    }
    return points;
  };
  SvgPlot plot(640, 640, {"x, m", -half_m, half_m}, {"y, m", -half_m, half_m}, title);
  plot.dots(from_above(moment.first, SE3{}), 0, 0.8);
  plot.dots(from_above(moment.second, T_a_b), 1, 0.8);
  plot.legend("L1", 0);
  plot.legend("L2", 1);
  return svg_file(plot.svg());
}

}  // namespace rigcal
