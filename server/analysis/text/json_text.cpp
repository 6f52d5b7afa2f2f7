// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/text/json_text.h"

#include <algorithm>

namespace livegs {
namespace {

constexpr std::size_t kMaxAttempts = 200;  // maximum number of opening braces tried in one text
constexpr std::size_t kMaxProseLength = std::size_t{256} << 10;

bool too_deep(std::string_view text) {
  for (std::size_t at = 0; at != std::string_view::npos;) {
    const JsonExtent extent = json_extent(text, at, kMaxJsonDepth);
    if (extent.depth > kMaxJsonDepth) return true;
    at = extent.end;
  }
  return false;
}

std::size_t count_wanted(const Json& object, std::span<const std::string> wanted) {
  return static_cast<std::size_t>(std::count_if(
      wanted.begin(), wanted.end(), [&](const std::string& key) { return object.contains(key); }));
}

}  // namespace

JsonExtent json_extent(std::string_view text, std::size_t begin, int max_depth) {
  JsonExtent extent;
  int open = 0;
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
      extent.depth = std::max(extent.depth, ++open);
      if (open > max_depth) return extent;
    } else if (c == '}' || c == ']') {
      if (--open <= 0) {
        extent.end = i + 1;
        return extent;
      }
    }
  }
  return extent;
}

Result<Json> parse_json(std::string_view text) {
  if (too_deep(text)) return invalid_data("JSON nested deeper than 64 levels");
  Json value = Json::parse(text, nullptr, false);
  if (value.is_discarded()) return invalid_data("not JSON");
  return value;
}

Result<Json> parse_commented_json(std::string_view text) {
  int deepest = 0;
  const auto measure = [&](int depth, Json::parse_event_t, Json&) {
    deepest = std::max(deepest, depth);
    return depth <= kMaxJsonDepth;
  };
  try {
    Json value = Json::parse(text, measure, true, true);
    if (deepest > kMaxJsonDepth)
      return invalid_data("is nested deeper than " + std::to_string(kMaxJsonDepth) + " levels");
    return value;
  } catch (const Json::parse_error& error) {
    std::string what = error.what();
    if (const std::size_t colon = what.find("] "); colon != std::string::npos) what = what.substr(colon + 2);
    std::replace_if(
        what.begin(), what.end(), [](unsigned char c) { return c < 0x20; }, ' ');
    return invalid_data("is not JSON: " + what);
  }
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
  text = text.substr(0, kMaxProseLength);
  std::optional<Json> best;
  std::size_t best_count = 0, attempts = 0;
  const auto consider = [&](const Json& object) {
    const std::size_t count = count_wanted(object, wanted);
    if (!best || count >= best_count) {
      best = object;
      best_count = count;
    }
  };
  for (std::size_t at = text.find('{'); at != std::string_view::npos && attempts < kMaxAttempts; ++attempts) {
    const std::size_t end = json_extent(text, at, kMaxJsonDepth).end;
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

}  // namespace livegs
