#include <fmt/format.h>

#include "apps/experiment/experiment_json.h"
#include "apps/experiment/start_experiment.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const StartRow& row) {
  return {{"case", row.kind.name},
          {"rigs", row.rigs},
          {"right", row.right},
          {"flagged", row.flagged},
          {"wrong", row.wrong},
          {"lidars", row.lidars},
          {"lidars_right", row.lidars_right},
          {"right_but_flagged", row.right_but_flagged},
          {"median_mm", row.median_mm},
          {"worst_mm", row.worst_mm},
          {"median_deg", row.median_deg},
          {"worst_deg", row.worst_deg},
          {"start_median_s", row.start_median_s},
          {"start_worst_s", row.start_worst_s},
          {"misses", row.misses}};
}

}  // namespace

std::string start_experiment_text(const std::vector<StartRow>& rows) {
  std::string text =
      "Random rigs in three scenes; right: every LiDAR within 5 mm and 0.05 degrees; flagged: what is not right is "
      "weak or failed\n";
  for (const StartRow& row : rows) {
    text += fmt::format(
        "{:<10} {} rigs: {} right, {} flagged, {} wrong; {} of {} LiDARs right ({} of them flagged), median {:.2f} mm "
        "{:.4f} deg, worst {:.2f} mm {:.4f} deg; start {:.2f} s median, {:.2f} s worst\n",
        row.kind.name, row.rigs, row.right, row.flagged, row.wrong, row.lidars_right, row.lidars, row.right_but_flagged,
        row.median_mm, row.median_deg, row.worst_mm, row.worst_deg, row.start_median_s, row.start_worst_s);
    for (const std::string& miss : row.misses) text += "  " + miss + "\n";
  }
  return text;
}

std::string start_experiment_json(const std::vector<StartRow>& rows) {
  Json json = experiment_head("start");
  json["rows"] = Json::array();
  for (const StartRow& row : rows) json["rows"].push_back(json_of(row));
  return json_text(json);
}

}  // namespace rigcal
