// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/result.h"

// JSON from outside, without exceptions: any bytes give a value or an error. Depth is bounded before anything
// is parsed, because walking a value costs stack.

namespace livegs {

using Json = nlohmann::json;
// Keeps the order of its members, in which models write: for what we send. Never for what comes in, where
// looking a member up in a list would cost the square of a hostile length.
using OrderedJson = nlohmann::ordered_json;

inline constexpr int kMaxJsonDepth = 64;

// Where the first object or array at or after `begin` ends, by its brackets alone: those in strings do not
// count, and which kind closes which is left to the parser.
struct JsonExtent {
  std::size_t end = std::string_view::npos;  // one past the closing bracket; npos: it never closes
  int depth = 0;                             // the deepest nesting up to there
};
// Gives up where more than `max_depth` brackets are open: depth is then max_depth + 1 and end npos. A closing
// bracket before any that opens ends it too.
JsonExtent json_extent(std::string_view text, std::size_t begin, int max_depth);

Result<Json> parse_json(std::string_view text);
// Of a person's file: with comments, and the error says where the mistake stands, on one line. "is not JSON:
// ...", "is nested deeper than 64 levels": to stand behind the file's name.
Result<Json> parse_commented_json(std::string_view text);

// On one line; bytes that are not UTF-8 become U+FFFD.
std::string dump_json(const Json& value);
std::string dump_json(const OrderedJson& value);

// nullptr where `object` is no object or has no such member.
const Json* member(const Json& object, const char* key);
std::string text_member(const Json& object, const char* key);  // "" where it is no string
std::optional<double> number_member(const Json& object, const char* key);

// The object that a model wrote, out of its prose, code fences or thoughts: the last one that has the most of
// `wanted` (also one level inside a wrapper). nullopt where there is no JSON object.
std::optional<Json> find_json_object(std::string_view text, std::span<const std::string> wanted);

}  // namespace livegs
