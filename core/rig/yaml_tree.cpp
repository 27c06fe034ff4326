#include "core/rig/yaml_tree.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "core/base/edit_distance.h"

namespace rigcal {
namespace {

/// What a document breaks that YAML allows and we do not.
struct Refusal {
  int line;
  std::string what;
  std::string mend;
};

int line_of(const YAML::Mark& mark) { return std::max(mark.line + 1, 1); }

/// Builds the tree from the parser's events; throws Refusal through the parser.
class TreeBuilder final : public YAML::EventHandler {
 public:
  explicit TreeBuilder(const YamlLimits& limits) : limits_(limits) {}

  [[nodiscard]] YamlNode take_root() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    check(mark, "", anchor);
    YamlNode node;
    node.line = line_of(mark);
    add(std::move(node));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw Refusal{line_of(mark), "has an alias ('*')", "write the value out"};
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    check(mark, tag, anchor);
    YamlNode node;
    node.kind = YamlNode::Kind::scalar;
    node.text = value;
    node.quoted = tag == "!";
    node.line = line_of(mark);
    add(std::move(node));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, YamlNode::Kind::sequence);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, YamlNode::Kind::map);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Level {
    YamlNode node;
    std::set<std::string> names;
    bool key_read = false;
  };

  void check(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    if (anchor != 0) throw Refusal{line_of(mark), "has an anchor ('&')", "write the value out where it is used"};
    if (!tag.empty() && tag != "?" && tag != "!") {
      throw Refusal{line_of(mark), "has a tag ('!')", "write plain values"};
    }
    if (++nodes_ > limits_.max_nodes) {
      throw Refusal{line_of(mark), "has more than " + std::to_string(limits_.max_nodes) + " values",
                    "check that it is the right file"};
    }
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, YamlNode::Kind kind) {
    check(mark, tag, anchor);
    const bool wants_key =
        !levels_.empty() && levels_.back().node.kind == YamlNode::Kind::map && !levels_.back().key_read;
    if (wants_key) throw Refusal{line_of(mark), "has a list or map for a key", "keys are plain words"};
    if (static_cast<int>(levels_.size()) >= limits_.max_depth) {
      throw Refusal{line_of(mark), "is nested deeper than " + std::to_string(limits_.max_depth) + " levels",
                    "check the brackets"};
    }
    Level level;
    level.node.kind = kind;
    level.node.line = line_of(mark);
    levels_.push_back(std::move(level));
  }

  void close() {
    YamlNode node = std::move(levels_.back().node);
    levels_.pop_back();
    add(std::move(node));
  }

  void add(YamlNode node) {
    if (levels_.empty()) {
      root_ = std::move(node);
      return;
    }
    Level& level = levels_.back();
    if (level.node.kind == YamlNode::Kind::map && !level.key_read) {
      if (node.kind != YamlNode::Kind::scalar) throw Refusal{node.line, "has an empty key", "name the value"};
      if (!level.names.insert(node.text).second) {
        throw Refusal{node.line, "has the key '" + node.text + "' twice", "remove one of them"};
      }
      level.node.keys.push_back({std::move(node.text), node.line});
      level.key_read = true;
      return;
    }
    // Where nothing follows a key, the parser's mark is that of what comes next.
    if (level.key_read && node.kind == YamlNode::Kind::null) node.line = level.node.keys.back().line;
    level.node.items.push_back(std::move(node));
    level.key_read = false;
  }

  const YamlLimits& limits_;
  YamlNode root_;
  std::vector<Level> levels_;
  std::size_t nodes_ = 0;
};

std::string at_line(const std::string& file, int line) { return file + ":" + std::to_string(line); }

}  // namespace

const YamlNode* YamlNode::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].name == key) return &items[i];
  }
  return nullptr;
}

Expected<YamlNode> parse_yaml(const std::string& text, const std::string& file, const YamlLimits& limits) {
  if (text.size() > limits.max_bytes) {
    return input_error("is longer than the " + std::to_string(limits.max_bytes / 1024) + " KiB such a file may have",
                       file, "check that it is the right file");
  }
  if (text.find('\0') != std::string::npos) {
    return input_error("is no text file", file, "check that it is the right file");
  }
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    TreeBuilder builder(limits);
    if (!parser.HandleNextDocument(builder))
      return input_error("is empty", file, "check that it is the right file, and was written whole");
    YamlNode root = builder.take_root();
    TreeBuilder rest(limits);
    if (parser.HandleNextDocument(rest)) {
      return input_error("has a second document ('---')", at_line(file, std::max(rest.take_root().line, 1)),
                         "keep one document in a file");
    }
    return root;
  } catch (const Refusal& refusal) {
    return input_error(refusal.what, at_line(file, refusal.line), refusal.mend);
  } catch (const YAML::Exception& error) {
    return input_error("is no valid YAML (" + error.msg + ")", at_line(file, line_of(error.mark)),
                       "check indentation, quotes and brackets near this line");
  }
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t best_distance = word.size() / 2 + 1;
  if (word.size() > 64) return best;
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

void YamlErrors::add(int line, std::string what, std::string mend) {
  if (!first_) first_ = input_error(std::move(what), at_line(file_, line), std::move(mend));
}

}  // namespace rigcal
