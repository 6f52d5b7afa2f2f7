// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/json_text.h"

#include <algorithm>

namespace livegs {
namespace {

constexpr std::size_t kMostAttempts = 200;  // opening braces that are tried in one text
constexpr std::size_t kLongestProse = std::size_t{256} << 10;

// One past the bracket that closes the one at `begin`; npos if none does. Stops at `max_depth`.
std::size_t end_of_value(std::string_view text, std::size_t begin, int max_depth) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = begin; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') {
        ++i;
      } else if (c == '"') {
        quoted = false;
      }
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      if (++depth > max_depth) return std::string_view::npos;
    } else if (c == '}' || c == ']') {
      if (--depth <= 0) return i + 1;
    }
  }
  return std::string_view::npos;
}

bool too_deep(std::string_view text) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') {
        ++i;
      } else if (c == '"') {
        quoted = false;
      }
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxJsonDepth) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

std::size_t count_wanted(const Json& object, std::span<const std::string> wanted) {
  return static_cast<std::size_t>(std::count_if(
      wanted.begin(), wanted.end(), [&](const std::string& key) { return object.contains(key); }));
}

bool is_of_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "number") return value.is_number();
  if (type == "integer") return value.is_number_integer();
  if (type == "boolean") return value.is_boolean();
  return type == "null" && value.is_null();
}

std::string complaint(const Json& value, const Json& schema, const std::string& place, int depth) {
  const std::string at = place.empty() ? "the answer" : place;
  if (depth > kMaxJsonDepth) return at + ": nested too deeply";
  if (const Json* options = member(schema, "anyOf")) {
    std::string first;
    for (const Json& option : *options) {
      const std::string found = complaint(value, option, place, depth + 1);
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
        std::string found = complaint(inner, *described, prefix + key, depth + 1);
        if (!found.empty()) return found;
      } else if (schema.value("additionalProperties", true) == false) {
        return prefix + key.substr(0, 40) + ": not known";
      }
    }
  }
  if (const Json* items = member(schema, "items"); items && value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      std::string found = complaint(value[i], *items, at + "[" + std::to_string(i) + "]", depth + 1);
      if (!found.empty()) return found;
    }
  }
  return "";
}

}  // namespace

Result<Json> parse_json(std::string_view text) {
  if (too_deep(text)) return invalid_data("JSON nested deeper than 64 levels");
  Json value = Json::parse(text, nullptr, false);
  if (value.is_discarded()) return invalid_data("not JSON");
  return value;
}

std::string dump_json(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string dump_json(const OrderedJson& value) {
  return value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

const Json* member(const Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

std::string text_member(const Json& object, const char* key) {
  const Json* value = member(object, key);
  return value && value->is_string() ? value->get<std::string>() : "";
}

std::optional<double> number_member(const Json& object, const char* key) {
  const Json* value = member(object, key);
  if (!value || !value->is_number()) return std::nullopt;
  return value->get<double>();
}

std::optional<Json> find_json_object(std::string_view text, std::span<const std::string> wanted) {
  text = text.substr(0, kLongestProse);
  std::optional<Json> best;
  std::size_t best_count = 0, attempts = 0;
  const auto consider = [&](const Json& object) {
    const std::size_t count = count_wanted(object, wanted);
    if (!best || count >= best_count) {
      best = object;
      best_count = count;
    }
  };
  for (std::size_t at = text.find('{'); at != std::string_view::npos && attempts < kMostAttempts;
       ++attempts) {
    const std::size_t end = end_of_value(text, at, kMaxJsonDepth);
    Json value = end == std::string_view::npos ? Json(Json::value_t::discarded)
                                               : Json::parse(text.substr(at, end - at), nullptr, false);
    const bool parsed = value.is_object();
    if (parsed) {
      consider(value);
      for (const Json& inner : value) {
        if (inner.is_object() && count_wanted(inner, wanted) > best_count) consider(inner);
      }
    }
    at = text.find('{', parsed ? end : at + 1);
  }
  return best;
}

std::string schema_complaint(const Json& value, const Json& schema) {
  return complaint(value, schema, "", 0);
}

}  // namespace livegs
