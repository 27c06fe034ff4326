#include "apps/experiment/board_experiment_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/experiment/experiment_json.h"
#include "apps/experiment/svg_file.h"
#include "core/base/text.h"
#include "core/geometry/se3.h"
#include "core/report/svg_plot.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

/// What a picture shows of a way.
struct Figure {
  const char* file;
  const char* label;
  double BoardWay::*value;
  double unit;
  double BoardClaim::*claim;  // none: null
};
const std::array<Figure, 3>& figures() {
  static const std::array<Figure, 3> all{
      {{"rotation", "rotation, deg", &BoardWay::rotation_rad, 180.0 / pi, &BoardClaim::rotation_rad},
       {"translation", "translation, mm", &BoardWay::translation_m, 1e3, &BoardClaim::translation_m},
       {"projection", "projection, pixels", &BoardWay::projection_px, 1.0, nullptr}}};
  return all;
}

std::string file_name(const std::string& pair, const Figure& figure) {
  std::string name = small_letters(pair + "_" + figure.file + ".svg");
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

bool has_figure(const BoardClaim& claim, const Figure& figure) {
  return figure.claim != nullptr || claim.pair != "LiDAR-LiDAR";
}

std::string row_text(const BoardRow& row) {
  std::string text;
  for (const BoardWay& way : row.ways) {
    text +=
        fmt::format("{:<14} {:>2} {:>5}  {:<17} {:>7.4f} ({:>7.4f})  {:>6.2f} ({:>6.2f})  {:>6.3f}  {:>5} of {}\n",
                    row.pair, row.k, row.poses, way.way, to_deg(way.rotation_rad), to_deg(way.worst_rotation_rad),
                    1e3 * way.translation_m, 1e3 * way.worst_translation_m, way.projection_px, way.answers, row.draws);
  }
  return text;
}

std::string rows_text(const std::vector<BoardRow>& rows) {
  if (rows.empty()) return {};
  std::string text =
      "Poses drawn from 27, noise of k times the paper's variance: median (95 of 100 are better) of the errors\n"
      "pair            k poses  way                rotation, deg      translation, mm  pixels  answers\n";
  for (const BoardRow& row : rows) text += row_text(row);
  text += "The paper claims at k = 1: ";
  for (const BoardClaim& claim : published_claims()) {
    text += fmt::format("{}{} {:.1f} deg, {:.0f} mm", &claim == &published_claims().front() ? "" : "; ", claim.pair,
                        to_deg(claim.rotation_rad), 1e3 * claim.translation_m);
  }
  return text + "\n\n";
}

double share(int part, int all) { return all > 0 ? static_cast<double>(part) / all : 0.0; }

std::vector<DetectionRow> with_sums(const std::vector<DetectionRow>& rows) {
  std::vector<DetectionRow> out = rows;
  for (const DetectionRow& row : rows) {
    auto sum = std::find_if(out.begin() + static_cast<std::ptrdiff_t>(rows.size()), out.end(),
                            [&](const DetectionRow& r) { return r.sensor == row.sensor; });
    if (sum == out.end()) {
      out.push_back({"all", row.sensor, 0, 0, 0, 0});
      sum = out.end() - 1;
    }
    sum->boards += row.boards;
    sum->right += row.right;
    sum->wrong += row.wrong;
    sum->wrong_used += row.wrong_used;
  }
  return out;
}

std::string detection_text(const std::vector<DetectionRow>& rows) {
  if (rows.empty()) return {};
  std::string text =
      "Boards found, at a common area of 0.95 or more\n"
      "scene      sensor             boards  right  wrong  recall  precision  wrong ones used\n";
  for (const DetectionRow& row : with_sums(rows)) {
    text += fmt::format("{:<10} {:<18} {:>6} {:>6} {:>6}  {:.3f}   {:.3f}      {}\n", row.scene, row.sensor, row.boards,
                        row.right, row.wrong, share(row.right, row.boards), share(row.right, row.right + row.wrong),
                        row.wrong_used);
  }
  return text + "\n";
}

std::string livox_text(const std::vector<LivoxRow>& rows) {
  if (rows.empty()) return {};
  std::string text = "Livox sensors to a camera by boards at 2.6 to 4.5 m: median (worst)\n";
  for (const LivoxRow& row : rows) {
    text += fmt::format(
        "{:<7} {:.4f} ({:.4f}) deg, {:.2f} ({:.2f}) mm, {} of {} rigs; {} of {} boards found, planes {:.1f} to {:.1f} "
        "mm "
        "thick, sides off by {:.1f} ({:.1f}) mm; dark squares: sign right in {} of {}\n",
        row.model, to_deg(row.rotation_rad), to_deg(row.worst_rotation_rad), 1e3 * row.translation_m,
        1e3 * row.worst_translation_m, row.answers, row.rigs, row.found, row.shown, 1e3 * row.plane_low_m,
        1e3 * row.plane_high_m, 1e3 * row.size_m, 1e3 * row.worst_size_m, row.signs_right, row.signs);
  }
  return text;
}

Json rows_json(const std::vector<BoardRow>& rows) {
  Json out = Json::array();
  for (const BoardRow& row : rows) {
    Json ways = Json::array();
    for (const BoardWay& way : row.ways) {
      ways.push_back({{"way", way.way},
                      {"answers", way.answers},
                      {"rotation_rad", way.rotation_rad},
                      {"translation_m", way.translation_m},
                      {"worst_rotation_rad", way.worst_rotation_rad},
                      {"worst_translation_m", way.worst_translation_m},
                      {"projection_px", way.projection_px}});
    }
    out.push_back(
        {{"pair", row.pair}, {"k", row.k}, {"poses", row.poses}, {"draws", row.draws}, {"ways", std::move(ways)}});
  }
  return out;
}

std::string picture(const std::vector<BoardRow>& rows, const BoardClaim& claim, const Figure& figure) {
  struct Series {
    std::string name;
    int k;
    std::size_t way;
    bool dashed;
  };
  std::vector<Series> wanted{{"rigcal, k = 1", 1, 0, false},
                             {"as published, k = 1", 1, 1, false},
                             {"", 1, 2, false},
                             {"rigcal, k = 0", 0, 0, true},
                             {"rigcal, k = 2", 2, 0, true}};
  double most = figure.claim != nullptr ? figure.unit * claim.*figure.claim : 0.0;
  std::vector<std::vector<PlotPoint>> lines(wanted.size());
  for (const BoardRow& row : rows) {
    if (row.pair != claim.pair) continue;
    for (std::size_t s = 0; s < wanted.size(); ++s) {
      if (row.k != wanted[s].k || wanted[s].way >= row.ways.size()) continue;
      const BoardWay& way = row.ways[wanted[s].way];
      if (way.answers == 0) continue;
      if (wanted[s].name.empty()) wanted[s].name = way.way + ", k = 1";
      lines[s].push_back({static_cast<double>(row.poses), figure.unit * way.*figure.value});
      // The height is for what is asked; the first few poses of other ways may leave it.
      if (s == 0 || row.poses >= 10) most = std::max(most, lines[s].back().y);
    }
  }
  SvgPlot plot(900, 460, {"poses", 3.0, 20.0}, {figure.label, 0.0, most > 0.0 ? 1.25 * most : 1.0},
               claim.pair + ": " + figure.label + " against poses");
  for (std::size_t s = 0; s < wanted.size(); ++s) {
    if (lines[s].empty()) continue;
    plot.line(lines[s], static_cast<int>(s), wanted[s].dashed);
    plot.dots(lines[s], static_cast<int>(s));
    plot.legend(wanted[s].name, static_cast<int>(s));
  }
  if (figure.claim != nullptr) {
    const double value = figure.unit * claim.*figure.claim;
    const int series = static_cast<int>(wanted.size());
    plot.line({{3.0, value}, {20.0, value}}, series, true);
    plot.legend("paper's claim, k = 1", series);
  }
  return svg_file(plot.svg());
}

}  // namespace

std::string board_experiment_text(const BoardExperiment& experiment) {
  return rows_text(experiment.rows) + detection_text(experiment.detection) + livox_text(experiment.livox);
}

std::string board_experiment_json(const BoardExperiment& experiment) {
  Json json = experiment_head("checkerboard");
  json["paper"] = "checkerboard";  // The older name.
  json["claims"] = Json::array();
  for (const BoardClaim& claim : published_claims()) {
    json["claims"].push_back(
        {{"pair", claim.pair}, {"rotation_rad", claim.rotation_rad}, {"translation_m", claim.translation_m}});
  }
  json["rows"] = rows_json(experiment.rows);
  json["detection"] = Json::array();
  for (const DetectionRow& row : with_sums(experiment.detection)) {
    json["detection"].push_back({{"scene", row.scene},
                                 {"sensor", row.sensor},
                                 {"boards", row.boards},
                                 {"right", row.right},
                                 {"wrong", row.wrong},
                                 {"wrong_used", row.wrong_used},
                                 {"recall", share(row.right, row.boards)},
                                 {"precision", share(row.right, row.right + row.wrong)}});
  }
  json["livox"] = Json::array();
  for (const LivoxRow& row : experiment.livox) {
    json["livox"].push_back({{"model", row.model},
                             {"rigs", row.rigs},
                             {"answers", row.answers},
                             {"rotation_rad", row.rotation_rad},
                             {"translation_m", row.translation_m},
                             {"worst_rotation_rad", row.worst_rotation_rad},
                             {"worst_translation_m", row.worst_translation_m},
                             {"shown", row.shown},
                             {"found", row.found},
                             {"size_m", row.size_m},
                             {"worst_size_m", row.worst_size_m},
                             {"plane_low_m", row.plane_low_m},
                             {"plane_high_m", row.plane_high_m},
                             {"signs", row.signs},
                             {"signs_right", row.signs_right}});
  }
  return json_text(json);
}

std::vector<std::pair<std::string, std::string>> board_experiment_pictures(const std::vector<BoardRow>& rows) {
  std::vector<std::pair<std::string, std::string>> out;
  if (rows.empty()) return out;
  for (const BoardClaim& claim : published_claims()) {
    for (const Figure& figure : figures()) {
      if (has_figure(claim, figure)) out.emplace_back(file_name(claim.pair, figure), picture(rows, claim, figure));
    }
  }
  return out;
}

std::vector<std::string> board_experiment_files() {
  std::vector<std::string> out;
  for (const BoardClaim& claim : published_claims()) {
    for (const Figure& figure : figures()) {
      if (has_figure(claim, figure)) out.push_back(file_name(claim.pair, figure));
    }
  }
  return out;
}

}  // namespace rigcal
