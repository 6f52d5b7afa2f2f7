// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/result.h"

// Parsing of untrusted JSON without exceptions: any bytes give a value or an error. The nesting depth is
// checked before parsing because walking a value uses stack.

namespace livegs {

using Json = nlohmann::json;
// JSON that preserves the order of its members, in which models write. For output only: lookup in input would
// cost the square of its length.
using OrderedJson = nlohmann::ordered_json;

inline constexpr int kMaxJsonDepth = 64;

// End of the first object or array at or after `begin`, found by counting brackets. Brackets in strings are
// skipped; the parser checks that the kinds match.
struct JsonExtent {
  std::size_t end = std::string_view::npos;  // one past the closing bracket; npos if unclosed
  int depth = 0;                             // deepest nesting up to there
};
// Stops if more than `max_depth` brackets are open; depth is then max_depth + 1 and end is npos. A closing
// bracket before any opening one also ends the scan.
JsonExtent json_extent(std::string_view text, std::size_t begin, int max_depth);

Result<Json> parse_json(std::string_view text);
// Parses a user's file, with comments. The error is one line with the position of the mistake, to be appended
// to the file name: "is not JSON: ..." or "is nested deeper than 64 levels".
Result<Json> parse_commented_json(std::string_view text);

// Serialises on one line; invalid UTF-8 becomes U+FFFD.
std::string dump_json(const Json& value);
std::string dump_json(const OrderedJson& value);

// Returns nullptr if `object` is not an object or has no such member.
const Json* member(const Json& object, const char* key);
std::string text_member(const Json& object, const char* key);  // "" if not a string
std::optional<double> number_member(const Json& object, const char* key);

// Extracts a model's answer object from prose, code fences or reasoning text. Selects the last object with
// the most members of `wanted`, also one level inside a wrapper. nullopt if there is no JSON object.
std::optional<Json> find_json_object(std::string_view text, std::span<const std::string> wanted);

}  // namespace livegs
