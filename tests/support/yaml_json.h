#pragma once

#include "core/rig/yaml_tree.h"
#include "tests/support/json.h"

namespace rigcal {

/// A YAML tree as JSON, for checks against schemas: an unquoted scalar becomes the number or truth value that it reads
/// as, everything else text.
inline nlohmann::json json_of(const YamlNode& node) {
  using Json = nlohmann::json;
  Json out;
  switch (node.kind) {
    case YamlNode::Kind::null:
      return out;
    case YamlNode::Kind::scalar: {
      const Json read = node.quoted ? Json() : try_json(node.text);
      return read.is_number() || read.is_boolean() ? read : Json(node.text);
    }
    case YamlNode::Kind::sequence:
      out = Json::array();
      for (const YamlNode& item : node.items) out.push_back(json_of(item));
      return out;
    case YamlNode::Kind::map:
      out = Json::object();
      for (std::size_t i = 0; i < node.items.size(); ++i) out[node.keys[i].name] = json_of(node.items[i]);
      return out;
  }
  return out;
}

}  // namespace rigcal
