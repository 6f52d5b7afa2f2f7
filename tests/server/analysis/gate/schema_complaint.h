// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>

#include "analysis/text/json_text.h"

namespace livegs {

inline bool is_of_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "number") return value.is_number();
  if (type == "integer") return value.is_number_integer();
  if (type == "boolean") return value.is_boolean();
  return type == "null" && value.is_null();
}

// First violation of a schema of the portable strict subset (type, enum, properties, required,
// additionalProperties, items, anyOf) with its path: "mass_g.low: not a number". Empty if valid.
inline std::string schema_complaint(const Json& value, const Json& schema, const std::string& place = "",
                                    int depth = 0) {
  const std::string at = place.empty() ? "the answer" : place;
  if (depth > kMaxJsonDepth) return at + ": nested too deeply";
  if (const Json* options = member(schema, "anyOf")) {
    std::string first;
    for (const Json& option : *options) {
      const std::string found = schema_complaint(value, option, place, depth + 1);
      if (found.empty()) return "";
      if (first.empty()) first = found;
    }
    return first;
  }
  if (const Json* type = member(schema, "type")) {
    const bool fits = type->is_array() ? std::any_of(type->begin(), type->end(),
                                                     [&](const Json& one) { return is_of_type(value, one); })
                                       : is_of_type(value, type->get<std::string>());
    if (!fits) return at + ": not " + (type->is_array() ? "one of " : "a ") + dump_json(*type);
  }
  if (const Json* allowed = member(schema, "enum")) {
    if (std::find(allowed->begin(), allowed->end(), value) == allowed->end()) {
      const std::string list = dump_json(*allowed);
      return at + ": not one of " + (list.size() > 200 ? "the names that are allowed" : list);
    }
  }
  const std::string prefix = place.empty() ? "" : place + ".";
  if (value.is_object()) {
    const Json* properties = member(schema, "properties");
    if (const Json* required = member(schema, "required")) {
      for (const Json& key : *required) {
        if (!value.contains(key.get<std::string>())) return prefix + key.get<std::string>() + ": missing";
      }
    }
    for (const auto& [key, inner] : value.items()) {
      const Json* described = properties ? member(*properties, key.c_str()) : nullptr;
      if (described) {
        std::string found = schema_complaint(inner, *described, prefix + key, depth + 1);
        if (!found.empty()) return found;
      } else if (schema.value("additionalProperties", true) == false) {
        return prefix + key.substr(0, 40) + ": not known";
      }
    }
  }
  if (const Json* items = member(schema, "items"); items && value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      std::string found = schema_complaint(value[i], *items, at + "[" + std::to_string(i) + "]", depth + 1);
      if (!found.empty()) return found;
    }
  }
  return "";
}

}  // namespace livegs
