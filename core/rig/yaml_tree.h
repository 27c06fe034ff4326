#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"

/// YAML files from outside, read with a line number for every value, so that each error can say "file:line".
namespace rigcal {

struct YamlKey {
  std::string name;
  int line = 0;
};

/// A value of a YAML file. Keys keep the order of the file; item i of a map belongs to key i.
struct YamlNode {
  enum class Kind { null, scalar, sequence, map };
  Kind kind = Kind::null;
  std::string text;     ///< Of a scalar.
  bool quoted = false;  ///< A scalar in quotes is text, whatever it looks like.
  int line = 0;         ///< Counted from 1.
  std::vector<YamlKey> keys;
  std::vector<YamlNode> items;

  /// The value of a key, or null.
  [[nodiscard]] const YamlNode* find(std::string_view key) const;
};

struct YamlLimits {
  std::size_t max_bytes = std::size_t{1} << 20;
  std::size_t max_nodes = 100'000;
  int max_depth = 16;
};

/// Parses one YAML document. Refused, so that hostile files stay small: anchors, aliases and tags, more than the
/// limits allow, keys that are no plain text, the same key twice, a second document. `file` stands in errors.
[[nodiscard]] Expected<YamlNode> parse_yaml(const std::string& text, const std::string& file,
                                            const YamlLimits& limits = {});

/// Collects the first error of a reader, so that a file is read straight through and asked once at the end.
class YamlErrors {
 public:
  explicit YamlErrors(std::string file) : file_(std::move(file)) {}
  void add(int line, std::string what, std::string mend = {});
  [[nodiscard]] bool ok() const { return !first_.has_value(); }
  [[nodiscard]] const Error& first() const { return *first_; }

 private:
  std::string file_;
  std::optional<Error> first_;
};

/// Reads the values of one map. Every function gives nothing where the key is absent or (after adding an error) wrong.
class YamlMap {
 public:
  /// Adds an error where `node` is no map or has a key which is not among `known` (empty: any key goes).
  /// `name` is what the map is called in errors, for example "sensors.avia".
  YamlMap(const YamlNode& node, std::string name, YamlErrors& errors, std::initializer_list<std::string_view> known);

  [[nodiscard]] const YamlNode* get(std::string_view key) const { return node_->find(key); }
  [[nodiscard]] bool has(std::string_view key) const { return get(key) != nullptr; }
  [[nodiscard]] int line() const { return node_->line; }
  [[nodiscard]] int line(std::string_view key) const;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] YamlErrors& errors() const { return *errors_; }
  /// Adds an error where the key is absent.
  bool require(std::string_view key, std::string mend = {}) const;
  void fail(std::string_view key, const std::string& what, std::string mend = {}) const;

  [[nodiscard]] std::optional<std::string> text(std::string_view key) const;
  [[nodiscard]] std::optional<bool> flag(std::string_view key) const;
  /// Finite and low <= value <= high.
  [[nodiscard]] std::optional<double> number(std::string_view key, double low, double high) const;
  [[nodiscard]] std::optional<std::int64_t> integer(std::string_view key, std::int64_t low, std::int64_t high) const;
  /// A list of `least` to `most` such numbers.
  [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view key, std::size_t least, std::size_t most,
                                                           double low, double high) const;
  [[nodiscard]] std::optional<std::vector<int>> integers(std::string_view key, std::size_t count, int low,
                                                         int high) const;
  /// Index of the word in `words`.
  [[nodiscard]] std::optional<std::size_t> choice(std::string_view key,
                                                  const std::vector<std::string_view>& words) const;
  /// The map below a key.
  [[nodiscard]] std::optional<YamlMap> map(std::string_view key, std::initializer_list<std::string_view> known) const;

 private:
  const YamlNode* node_;
  std::string name_;
  YamlErrors* errors_;
};

/// Reads the version key `rigcal: 1` (all our YAML files have it) and adds an error for a missing or newer one.
void check_format_version(const YamlMap& top);

/// The word of `known` nearest to `word` by edit distance, or empty where none is near enough to be meant.
[[nodiscard]] std::string nearest_word(std::string_view word, const std::vector<std::string>& known);

}  // namespace rigcal
