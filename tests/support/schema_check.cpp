#include "tests/support/schema_check.h"

#include <algorithm>

namespace rigcal {
namespace {

using Json = nlohmann::json;

/// Walks down a value beside its schema.
class Walk {
 public:
  Walk(const Json& root, std::vector<std::string>& wrong) : root_(root), wrong_(wrong) {}

  void check(const Json& schema, const Json& value, const std::string& at) const {
    if (schema.contains("$ref")) {
      const auto name = schema["$ref"].get<std::string>().substr(std::string("#/$defs/").size());
      check(root_["$defs"].at(name), value, at);
      return;
    }
    if (schema.contains("type")) {
      const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
      bool fits = false;
      for (const Json& type : types) fits = fits || has_type(value, type.get<std::string>());
      if (!fits) wrong_.push_back(at + ": is no " + types.dump());
    }
    if (schema.contains("const") && value != schema["const"])
      wrong_.push_back(at + ": is not " + schema["const"].dump());
    if (schema.contains("enum") &&
        std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
      wrong_.push_back(at + ": is not one of " + schema["enum"].dump());
    if (value.is_object()) check_object(schema, value, at);
    if (value.is_array()) check_array(schema, value, at);
    if (schema.contains("if")) check_branch(schema, value, at);
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

  void check_branch(const Json& schema, const Json& value, const std::string& at) const {
    std::vector<std::string> unlike;
    Walk(root_, unlike).check(schema["if"], value, at);
    const char* branch = unlike.empty() ? "then" : "else";
    if (schema.contains(branch)) check(schema[branch], value, at);
  }

  void check_object(const Json& schema, const Json& value, const std::string& at) const {
    for (const Json& key : schema.value("required", Json::array())) {
      if (!value.contains(key)) wrong_.push_back(at + "/" + key.get<std::string>() + ": is missing");
    }
    const Json properties = schema.value("properties", Json::object());
    for (const auto& [key, item] : value.items()) {
      if (properties.contains(key)) {
        check(properties[key], item, at + "/" + key);
      } else if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object()) {
        check(schema["additionalProperties"], item, at + "/" + key);
      } else if (schema.value("additionalProperties", Json(true)) == Json(false)) {
        wrong_.push_back(at + "/" + key + ": is not in the schema");
      }
    }
  }

  void check_array(const Json& schema, const Json& value, const std::string& at) const {
    if (value.size() < schema.value("minItems", std::size_t{0}) ||
        value.size() > schema.value("maxItems", value.size())) {
      wrong_.push_back(at + ": has " + std::to_string(value.size()) + " items");
    }
    if (!schema.contains("items")) return;
    for (std::size_t i = 0; i < value.size(); ++i) check(schema["items"], value[i], at + "/" + std::to_string(i));
  }

  const Json& root_;
  std::vector<std::string>& wrong_;
};

}  // namespace

SchemaCheck::SchemaCheck(const std::string& name)
    : root_(json_of_file(std::filesystem::path(RIGCAL_SOURCE_DIR) / "docs/schema" / name)) {}

std::vector<std::string> SchemaCheck::violations(const Json& value) const {
  std::vector<std::string> wrong;
  Walk(root_, wrong).check(root_, value, "");
  return wrong;
}

testing::AssertionResult fits_schema(const std::string& name, const Json& value) {
  testing::AssertionResult result = testing::AssertionSuccess();
  for (const std::string& violation : SchemaCheck(name).violations(value))
    result = testing::AssertionFailure() << result.message() << name << violation << "\n";
  return result;
}

}  // namespace rigcal
