#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/json.h"

namespace rigcal {

/// Checks a JSON value against a schema of docs/schema. Knows the words these schemas use: type, const, enum, required,
/// properties, additionalProperties, items, minItems, maxItems, if, then, else, $ref to #/$defs/... Other words are not
/// looked at.
class SchemaCheck {
 public:
  /// `name` is that of the file, for example "report.json".
  explicit SchemaCheck(const std::string& name);

  /// What is wrong, with the place; empty when the value fits.
  [[nodiscard]] std::vector<std::string> violations(const nlohmann::json& value) const;

 private:
  nlohmann::json root_;
};

/// Whether a value fits the schema of this name; says what does not.
[[nodiscard]] testing::AssertionResult fits_schema(const std::string& name, const nlohmann::json& value);

}  // namespace rigcal
