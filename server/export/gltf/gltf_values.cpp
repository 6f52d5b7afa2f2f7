// SPDX-License-Identifier: GPL-3.0-or-later
#include "export/gltf/gltf_values.h"

#include <algorithm>

#include "export/model/message_text.h"

namespace livegs::gltf {
namespace {

// Deeper values are refused: their text is made by a function that calls itself.
bool nests_within(const Json& json, int depth) {
  if (!json.is_structured()) return true;
  return depth > 0 &&
         std::all_of(json.begin(), json.end(), [&](const Json& one) { return nests_within(one, depth - 1); });
}

}  // namespace

const Json& part_of(const Json& object, const char* key) {
  static const Json kNone;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() ? *found : kNone;
}

const Json& extension_of(const Json& object, const char* name) {
  return part_of(part_of(object, "extensions"), name);
}

bool flag_of(const Json& object, const char* key) {
  const Json& value = part_of(object, key);
  return value.is_boolean() && value.get<bool>();
}

std::string text_of(const Json& object, const char* key) {
  const Json& value = part_of(object, key);
  return value.is_string() ? value.get<std::string>() : std::string();
}

std::string name_of_node(size_t index) { return "nodes[" + std::to_string(index) + "]"; }

bool read_message(const Json& json, google::protobuf::Message& message) {
  return nests_within(json, 16) &&
         read_message_text(json.dump(-1, ' ', false, Json::error_handler_t::replace), message);
}

Result<std::vector<uint32_t>> Values::whole_numbers(const Json& accessor) const {
  const auto list = document_.numbers(accessor, 1);
  if (!list) return list.error();
  if (auto within = spend(list->count); !within) return within.error();
  std::vector<uint32_t> values(list->count);
  for (size_t i = 0; i < values.size(); ++i) {
    const double value = list->at(i, 0);
    if (!(value >= 0 && value <= 4294967295.0 && value == std::floor(value)))
      return problem("an accessor of whole numbers has other values");
    values[i] = static_cast<uint32_t>(value);
  }
  return values;
}

Result<const Json*> Values::entry_of(const Json& list, const Json& index, const std::string& where,
                                     const char* key) const {
  const double at = index.is_number() ? index.get<double>() : -1;
  if (!list.is_array() || !(at >= 0) || !(at < static_cast<double>(list.size())) || at != std::floor(at))
    return bad(where, std::string("has no valid ") + key);
  return &list[static_cast<size_t>(at)];
}

}  // namespace livegs::gltf
