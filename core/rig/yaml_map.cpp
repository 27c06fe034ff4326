#include <algorithm>
#include <charconv>
#include <limits>

#include "core/base/parse_number.h"
#include "core/rig/yaml_tree.h"

namespace rigcal {
namespace {

/// How a value looks in an error message: short and on one line.
std::string shown(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::null:
      return "nothing";
    case YamlNode::Kind::sequence:
      return "a list";
    case YamlNode::Kind::map:
      return "a map";
    case YamlNode::Kind::scalar:
      break;
  }
  std::string text = "'";
  for (const char c : node.text.substr(0, 40)) text += (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) ? '?' : c;
  if (node.text.size() > 40) text += "...";
  return text + "'";
}

std::string shown_number(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  return {buffer, end};
}

std::string range_text(double low, double high) { return shown_number(low) + " to " + shown_number(high); }

constexpr const char* mend_of_range = "give a value within it, and check the unit";
constexpr const char* mend_of_list = "write the numbers in brackets, with commas between them";

template <class T>
std::optional<T> parse_scalar(const YamlNode& node) {
  if (node.kind != YamlNode::Kind::scalar || node.quoted) return std::nullopt;
  std::string_view text = node.text;
  if (text.starts_with('+')) text.remove_prefix(1);
  return parse_number<T>(text);
}

std::optional<double> checked_number(const YamlNode& node, const std::string& name, double low, double high,
                                     YamlErrors& errors) {
  const std::optional<double> value = parse_scalar<double>(node);
  if (!value) {
    errors.add(node.line, name + " is " + shown(node) + ", not a number",
               "write digits alone, without a unit or quotes");
    return std::nullopt;
  }
  if (*value < low || *value > high) {
    errors.add(node.line, name + " is " + shown(node) + ", out of the range " + range_text(low, high), mend_of_range);
    return std::nullopt;
  }
  return value;
}

std::optional<std::int64_t> checked_integer(const YamlNode& node, const std::string& name, std::int64_t low,
                                            std::int64_t high, YamlErrors& errors) {
  const std::optional<std::int64_t> value = parse_scalar<std::int64_t>(node);
  if (!value) {
    errors.add(node.line, name + " is " + shown(node) + ", not a whole number", "write digits alone, without quotes");
    return std::nullopt;
  }
  if (*value < low || *value > high) {
    errors.add(
        node.line,
        name + " is " + shown(node) + ", out of the range " + std::to_string(low) + " to " + std::to_string(high),
        mend_of_range);
    return std::nullopt;
  }
  return value;
}

}  // namespace

YamlMap::YamlMap(const YamlNode& node, std::string name, YamlErrors& errors,
                 std::initializer_list<std::string_view> known)
    : node_(&node), name_(std::move(name)), errors_(&errors) {
  const std::string called = name_.empty() ? "the file" : name_;
  if (node.kind != YamlNode::Kind::map) {
    errors.add(std::max(node.line, 1), called + " is " + shown(node) + ", not a map of keys and values",
               name_.empty() ? "check that it is the right file" : "give it keys below it, or leave it out");
    return;
  }
  if (known.size() == 0) return;
  for (const YamlKey& key : node.keys) {
    if (std::find(known.begin(), known.end(), key.name) != known.end()) continue;
    const std::vector<std::string> words(known.begin(), known.end());
    const std::string nearest = nearest_word(key.name, words);
    std::string mend = "did you mean '";
    mend.append(nearest).append("'?");
    if (nearest.empty()) {
      mend = "known here are";
      for (const std::string& word : words) mend.append(" ").append(word);
    }
    YamlNode shown_key;
    shown_key.kind = YamlNode::Kind::scalar;
    shown_key.text = key.name;
    errors.add(key.line, "unknown key " + shown(shown_key) + (name_.empty() ? "" : " in " + name_), mend);
  }
}

int YamlMap::line(std::string_view key) const {
  for (const YamlKey& candidate : node_->keys) {
    if (candidate.name == key) return candidate.line;
  }
  return node_->line;
}

bool YamlMap::require(std::string_view key, std::string mend) const {
  if (has(key)) return true;
  errors_->add(std::max(node_->line, 1),
               (name_.empty() ? "the key '" : name_ + ": the key '") + std::string(key) + "' is missing",
               std::move(mend));
  return false;
}

void YamlMap::fail(std::string_view key, const std::string& what, std::string mend) const {
  errors_->add(line(key), (name_.empty() ? "" : name_ + ".") + std::string(key) + " " + what, std::move(mend));
}

namespace {

std::string full_name(const YamlMap& map, std::string_view key) {
  return map.name().empty() ? std::string(key) : map.name() + "." + std::string(key);
}

}  // namespace

std::optional<std::string> YamlMap::text(std::string_view key) const {
  const YamlNode* node = get(key);
  if (node == nullptr) return std::nullopt;
  if (node->kind != YamlNode::Kind::scalar) {
    fail(key, "is " + shown(*node) + ", not text", "write a word, or words in quotes, or leave the key out");
    return std::nullopt;
  }
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  if (node->text.empty() || node->text.size() > 1024 || std::any_of(node->text.begin(), node->text.end(), is_control)) {
    fail(key, "is empty, longer than 1024 bytes or has control characters",
         "write a short text in one line, or leave the key out");
    return std::nullopt;
  }
  return node->text;
}

std::optional<bool> YamlMap::flag(std::string_view key) const {
  const YamlNode* node = get(key);
  if (node == nullptr) return std::nullopt;
  if (node->kind == YamlNode::Kind::scalar && !node->quoted) {
    if (node->text == "true") return true;
    if (node->text == "false") return false;
  }
  fail(key, "is " + shown(*node) + ", not true or false", "write one of these words, without quotes");
  return std::nullopt;
}

std::optional<double> YamlMap::number(std::string_view key, double low, double high) const {
  const YamlNode* node = get(key);
  if (node == nullptr) return std::nullopt;
  return checked_number(*node, full_name(*this, key), low, high, *errors_);
}

std::optional<std::int64_t> YamlMap::integer(std::string_view key, std::int64_t low, std::int64_t high) const {
  const YamlNode* node = get(key);
  if (node == nullptr) return std::nullopt;
  return checked_integer(*node, full_name(*this, key), low, high, *errors_);
}

std::optional<std::vector<double>> YamlMap::numbers(std::string_view key, std::size_t least, std::size_t most,
                                                    double low, double high) const {
  const YamlNode* node = get(key);
  if (node == nullptr) return std::nullopt;
  if (node->kind != YamlNode::Kind::sequence || node->items.size() < least || node->items.size() > most) {
    const std::string wanted = std::to_string(least) + (most > least ? " to " + std::to_string(most) : "");
    const std::string found =
        node->kind == YamlNode::Kind::sequence ? "a list of " + std::to_string(node->items.size()) : shown(*node);
    fail(key, "is " + found + ", not a list of " + wanted + " numbers", mend_of_list);
    return std::nullopt;
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    const std::string name = full_name(*this, key) + "[" + std::to_string(i) + "]";
    const std::optional<double> value = checked_number(node->items[i], name, low, high, *errors_);
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

std::optional<std::vector<int>> YamlMap::integers(std::string_view key, std::size_t count, int low, int high) const {
  const YamlNode* node = get(key);
  if (node == nullptr) return std::nullopt;
  if (node->kind != YamlNode::Kind::sequence || node->items.size() != count) {
    fail(key, "is not a list of " + std::to_string(count) + " whole numbers", mend_of_list);
    return std::nullopt;
  }
  std::vector<int> values;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = full_name(*this, key) + "[" + std::to_string(i) + "]";
    const std::optional<std::int64_t> value = checked_integer(node->items[i], name, low, high, *errors_);
    if (!value) return std::nullopt;
    values.push_back(static_cast<int>(*value));
  }
  return values;
}

std::optional<std::size_t> YamlMap::choice(std::string_view key, const std::vector<std::string_view>& words) const {
  const YamlNode* node = get(key);
  if (node == nullptr) return std::nullopt;
  const auto word = std::find(words.begin(), words.end(), std::string_view(node->text));
  if (node->kind == YamlNode::Kind::scalar && word != words.end()) {
    return static_cast<std::size_t>(word - words.begin());
  }
  std::string mend = "use one of";
  for (const std::string_view candidate : words) mend.append(" ").append(candidate);
  fail(key, "is " + shown(*node), mend);
  return std::nullopt;
}

std::optional<YamlMap> YamlMap::map(std::string_view key, std::initializer_list<std::string_view> known) const {
  const YamlNode* node = get(key);
  if (node == nullptr) return std::nullopt;
  YamlMap below(*node, full_name(*this, key), *errors_, known);
  if (node->kind != YamlNode::Kind::map) return std::nullopt;
  return below;
}

void check_format_version(const YamlMap& top) {
  if (!top.require("rigcal", "begin the file with 'rigcal: 1'")) return;
  const std::optional<std::int64_t> version = top.integer("rigcal", 1, std::numeric_limits<int>::max());
  if (version && *version > 1) {
    top.fail("rigcal", "is " + std::to_string(*version) + ", but this release reads version 1",
             "use rigcal " + std::to_string(*version) + ".0 or newer");
  }
}

}  // namespace rigcal
