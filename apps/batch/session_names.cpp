#include "apps/batch/session_names.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>

namespace rigcal::batch {
namespace {

namespace fs = std::filesystem;

// The parts of the path, the last first, without the root.
std::vector<std::string> parts_of(const std::string& input) {
  std::error_code error;
  fs::path path = fs::absolute(input, error).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  std::vector<std::string> parts;
  for (; path.has_relative_path(); path = path.parent_path()) parts.push_back(path.filename().string());
  return parts;
}

std::string joined(const std::vector<std::string>& parts, std::size_t count) {
  std::string name;
  for (std::size_t k = std::min(count, parts.size()); k > 0; --k) name += parts[k - 1] + (k > 1 ? "_" : "");
  // What begins with a dot is the batch's own.
  if (!name.empty() && name[0] == '.') name[0] = '_';
  return name;
}

}  // namespace

Expected<std::vector<std::string>> read_list(const std::string& path) {
  std::ifstream file;
  if (path != "-") {
    file.open(path);
    if (!file)
      return input_error(std::string("cannot read the list: ") + std::strerror(errno), path,
                         "check its name and permissions; - is the standard input");
  }
  std::istream& in = path == "-" ? std::cin : file;
  std::vector<std::string> paths;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty() && line[0] != '#') paths.push_back(line);
  }
  if (in.bad()) return input_error("cannot read the list to its end", path);
  return paths;
}

Expected<std::vector<Session>> name_sessions(const std::vector<std::string>& inputs) {
  if (inputs.empty()) {
    return input_error("no recording is given", {}, "name some, or a --list with a path on each line");
  }
  std::vector<std::vector<std::string>> parts;
  std::map<std::vector<std::string>, std::string> known;
  for (const std::string& input : inputs) {
    parts.push_back(parts_of(input));
    if (parts.back().empty()) return input_error("is no recording", input);
    if (const auto [at, fresh] = known.emplace(parts.back(), input); !fresh)
      return input_error("the recording is given twice", input, "name each once");
  }
  std::vector<std::size_t> counts(inputs.size(), 1);
  while (true) {
    std::map<std::string, std::vector<std::size_t>> named;
    for (std::size_t i = 0; i < inputs.size(); ++i) named[joined(parts[i], counts[i])].push_back(i);
    bool clash = false;
    for (const auto& [name, which] : named) {
      if (which.size() == 1) continue;
      clash = true;
      bool longer = false;
      for (const std::size_t i : which) {
        longer |= counts[i] < parts[i].size();
        ++counts[i];
      }
      if (!longer)
        return input_error("would be called \"" + name + "\" like " + inputs[which[0]], inputs[which[1]],
                           "rename one of them, or make two batches");
    }
    if (!clash) break;
  }
  std::vector<Session> sessions;
  for (std::size_t i = 0; i < inputs.size(); ++i) sessions.push_back({joined(parts[i], counts[i]), inputs[i]});
  return sessions;
}

}  // namespace rigcal::batch
