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

Result<Json> parse_json(std::string_view text);

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

// What is wrong with `value` by a schema of the portable strict subset (type, enum, properties, required,
// additionalProperties, items, anyOf), naming the place: "mass_g.low: not a number". Empty when nothing is.
std::string schema_complaint(const Json& value, const Json& schema);

}  // namespace livegs
