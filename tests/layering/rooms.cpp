#include "tests/layering/rooms.h"

#include <algorithm>
#include <sstream>

namespace rigcal::layering {
namespace {

constexpr int longest_file = 600;

bool starts_with(const std::string& text, const std::string& start) { return text.rfind(start, 0) == 0; }

// The room of a file is the longest name in the table that its folder begins with; empty: none.
std::string room_of(const Table& table, const std::string& path) {
  std::string found;
  for (const auto& [room, _] : table) {
    if (starts_with(path, room + "/") && room.size() > found.size()) found = room;
  }
  return found;
}

// The folders whose files have to be in a room; tests may include everything.
bool is_guarded(const std::string& path) {
  return starts_with(path, "core/") || starts_with(path, "drivers/") || starts_with(path, "simdata/") ||
         starts_with(path, "apps/");
}

bool is_header(const std::string& path) { return path.size() > 2 && path.compare(path.size() - 2, 2, ".h") == 0; }

// Standard headers have neither a folder nor an ending.
bool is_standard(const std::string& header) { return header.find_first_of("/.") == std::string::npos; }

struct Include {
  std::string header;
  bool quoted = false;
};

// The header named by an #include line, or an empty one.
Include parse_include(const std::string& line) {
  std::size_t at = line.find_first_not_of(" \t");
  if (at == std::string::npos || line[at] != '#') return {};
  at = line.find_first_not_of(" \t", at + 1);
  if (at == std::string::npos || line.compare(at, 7, "include") != 0) return {};
  const std::size_t open = line.find_first_of("\"<", at);
  if (open == std::string::npos) return {};
  const std::size_t close = line.find(line[open] == '"' ? '"' : '>', open + 1);
  if (close == std::string::npos) return {};
  return {line.substr(open + 1, close - open - 1), line[open] == '"'};
}

std::string check_include(const Table& table, const std::string& path, const std::string& room,
                          const Include& include) {
  if (!include.quoted) {
    const bool eigen = starts_with(include.header, "Eigen/");
    if (room == "core/base" && !is_standard(include.header) && is_header(path)) {
      return "core/base offers headers with the standard library only, but includes <" + include.header + ">";
    }
    if (is_header(path) && !starts_with(room, "apps/") && !eigen && !is_standard(include.header)) {
      return "<" + include.header +
             "> stands in a public header; third-party and system headers belong into .cpp files";
    }
    return {};
  }
  const std::string target = room_of(table, include.header);
  if (target.empty()) return "\"" + include.header + "\" names no room; write the path from the root of the tree";
  if (may_include(table, room).count(target) == 0) return room + " may not include " + target;
  return {};
}

}  // namespace

const Table& rooms() {
  static const Table table = [] {
    Table rows{
        {"core/base", {}},
        {"core/geometry", {"core/base"}},
        {"core/records", {"core/geometry"}},
        {"core/rig", {"core/records"}},
        {"core/clocks", {"core/records"}},
        {"core/frames", {"core/clocks"}},
        {"core/io", {"core/rig"}},
        {"core/stops", {"core/clocks"}},
        {"core/turntable", {"core/base"}},
        {"core/voxel", {"core/records"}},
        {"core/edges", {"core/voxel", "core/rig"}},
        {"core/camera", {"core/edges"}},
        {"core/planes", {"core/voxel"}},
        {"core/start", {"core/planes"}},
        {"core/corner", {"core/start"}},
        {"core/board", {"core/corner", "core/edges"}},
        {"core/quality", {"core/planes", "core/camera"}},
        {"core/report", {"core/quality", "core/io"}},
        {"drivers/net", {"core/records"}},
        {"drivers/trigger", {"drivers/net"}},
        {"drivers/turntable", {"drivers/net"}},
        {"drivers/gige_codec", {"core/records"}},
        {"drivers/camera", {"core/frames"}},
        {"drivers/camera/aravis", {"drivers/camera", "drivers/net", "core/io"}},
        {"drivers/camera/images", {"drivers/camera", "core/io"}},
        {"drivers/camera/v4l2", {"drivers/camera"}},
        {"drivers/livox_codec", {"core/records"}},
        {"drivers/livox/protocol", {"drivers/livox_codec"}},
        {"drivers/livox/device", {"drivers/livox/protocol", "drivers/net"}},
        {"simdata/gige", {"drivers/gige_codec", "drivers/net"}},
        {"simdata/usb3", {"simdata/gige"}},
        {"simdata/scene", {"core/rig"}},
        {"simdata/lidar", {"simdata/scene"}},
        {"simdata/targets", {"simdata/lidar"}},
        {"simdata/rig", {"simdata/lidar"}},
        {"simdata/packets", {"simdata/rig", "drivers/livox_codec"}},
        {"simdata/camera", {"simdata/rig", "core/io"}},
        {"simdata/session", {"simdata/camera", "simdata/packets"}},
        {"simdata/live", {"simdata/camera", "simdata/packets", "simdata/gige"}},
    };
    std::vector<std::string> core;
    for (const auto& [room, _] : rows) {
      if (starts_with(room, "core/")) core.push_back(room);
    }
    rows["core/pipeline"] = core;
    std::vector<std::string> all;
    for (const auto& [room, _] : rows) all.push_back(room);
    const auto of_all = [&](std::vector<std::string> rooms) {
      rooms.insert(rooms.end(), all.begin(), all.end());
      return rooms;
    };
    rows["apps/common"] = {"core/quality"};
    rows["apps/evaluation"] = {"apps/common", "core/io"};
    rows["apps/ingest"] = {"core/clocks", "core/io", "core/quality", "drivers/livox_codec"};
    rows["apps/recording"] = {"apps/ingest", "core/pipeline"};
    rows["apps/calibration"] = {"apps/recording", "core/report"};
    rows["apps/exchange"] = {"apps/recording"};
    rows["apps/inspection"] = {"apps/recording", "core/report"};
    rows["apps/cameras"] = {"core/rig", "drivers/camera/aravis", "drivers/camera/v4l2"};
    rows["apps/capture"] = {"apps/calibration",     "apps/cameras",    "apps/common",      "core/turntable",
                            "drivers/livox/device", "drivers/trigger", "drivers/turntable"};
    rows["apps/web"] = {"apps/capture"};
    rows["apps/replay"] = {"apps/common", "apps/recording", "simdata/live"};
    rows["apps/batch"] = {"apps/common", "core/report"};
    rows["apps/experiment"] = of_all({"apps/batch", "apps/evaluation", "apps/ingest"});
    rows["apps/commands"] = of_all({"apps/experiment", "apps/exchange", "apps/inspection", "apps/replay", "apps/web"});
    rows["apps"] = {"apps/commands"};
    return rows;
  }();
  return table;
}

std::set<std::string> may_include(const Table& table, const std::string& room) {
  std::set<std::string> reached{room};
  std::vector<std::string> open{room};
  while (!open.empty()) {
    const auto row = table.find(open.back());
    open.pop_back();
    if (row == table.end()) continue;
    for (const std::string& next : row->second) {
      if (reached.insert(next).second) open.push_back(next);
    }
  }
  return reached;
}

std::vector<std::string> rooms_in_a_circle(const Table& table) {
  std::vector<std::string> found;
  for (const auto& [room, row] : table) {
    const bool circle = std::any_of(row.begin(), row.end(),
                                    [&](const std::string& next) { return may_include(table, next).count(room); });
    if (circle) found.push_back(room);
  }
  return found;
}

std::vector<std::string> check_file(const Table& table, const std::string& path, const std::string& text) {
  std::vector<std::string> wrong;
  const std::string room = room_of(table, path);
  const bool guarded = is_guarded(path);
  if (guarded && room.empty()) wrong.push_back(path + ": its folder is no room; add it to tests/layering/rooms.cpp");
  std::istringstream lines(text);
  std::string line;
  int number = 0;
  while (std::getline(lines, line)) {
    ++number;
    const Include include = parse_include(line);
    if (!guarded || room.empty() || include.header.empty()) continue;
    const std::string complaint = check_include(table, path, room, include);
    if (!complaint.empty()) wrong.push_back(path + ":" + std::to_string(number) + ": " + complaint);
  }
  if (number > longest_file) {
    wrong.push_back(path + ": " + std::to_string(number) + " lines; more than " + std::to_string(longest_file) +
                    " hide a second job: split the file");
  }
  return wrong;
}

}  // namespace rigcal::layering
