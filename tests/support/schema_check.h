#pragma once

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace rigcal {

/// Checks a JSON value against a schema of docs/schema. Knows the words these schemas use: type, const, enum, required,
/// properties, additionalProperties, items, minItems, maxItems, $ref to #/$defs/... Other words are not looked at.
class SchemaCheck {
 public:
  using Json = nlohmann::json;

  /// `name` is that of the file, for example "report.json".
  explicit SchemaCheck(const std::string& name) {
    std::ifstream in(std::string(RIGCAL_SOURCE_DIR) + "/docs/schema/" + name);
    root_ = Json::parse(in);
  }

  /// What is wrong, with the place; empty when the value fits.
  [[nodiscard]] std::vector<std::string> violations(const Json& value) const {
    std::vector<std::string> wrong;
    check(root_, value, "", wrong);
    return wrong;
  }

 private:
  static bool has_type(const Json& value, const std::string& type) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "number") return value.is_number();
    if (type == "integer") return value.is_number_integer();
    if (type == "boolean") return value.is_boolean();
    return type == "null" && value.is_null();
  }

  void check(const Json& schema, const Json& value, const std::string& at, std::vector<std::string>& wrong) const {
    if (schema.contains("$ref")) {
      const auto name = schema["$ref"].get<std::string>().substr(std::string("#/$defs/").size());
      check(root_["$defs"].at(name), value, at, wrong);
      return;
    }
    if (schema.contains("type")) {
      const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
      bool fits = false;
      for (const Json& type : types) fits = fits || has_type(value, type.get<std::string>());
      if (!fits) wrong.push_back(at + ": is no " + types.dump());
    }
    if (schema.contains("const") && value != schema["const"])
      wrong.push_back(at + ": is not " + schema["const"].dump());
    if (schema.contains("enum") &&
        std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
      wrong.push_back(at + ": is not one of " + schema["enum"].dump());
    if (value.is_object()) check_object(schema, value, at, wrong);
    if (value.is_array()) check_array(schema, value, at, wrong);
  }

  void check_object(const Json& schema, const Json& value, const std::string& at,
                    std::vector<std::string>& wrong) const {
    for (const Json& key : schema.value("required", Json::array())) {
      if (!value.contains(key)) wrong.push_back(at + "/" + key.get<std::string>() + ": is missing");
    }
    const Json properties = schema.value("properties", Json::object());
    for (const auto& [key, item] : value.items()) {
      if (properties.contains(key)) {
        check(properties[key], item, at + "/" + key, wrong);
      } else if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object()) {
        check(schema["additionalProperties"], item, at + "/" + key, wrong);
      } else if (schema.value("additionalProperties", Json(true)) == Json(false)) {
        wrong.push_back(at + "/" + key + ": is not in the schema");
      }
    }
  }

  void check_array(const Json& schema, const Json& value, const std::string& at,
                   std::vector<std::string>& wrong) const {
    if (value.size() < schema.value("minItems", std::size_t{0}) ||
        value.size() > schema.value("maxItems", value.size())) {
      wrong.push_back(at + ": has " + std::to_string(value.size()) + " items");
    }
    if (!schema.contains("items")) return;
    for (std::size_t i = 0; i < value.size(); ++i)
      check(schema["items"], value[i], at + "/" + std::to_string(i), wrong);
  }

  Json root_;
};

}  // namespace rigcal
