// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/answer_object.h"

#include <vector>

#include "analysis/answer.h"
#include "analysis/json_text.h"

namespace livegs {
namespace {

using nlohmann::json;

// RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::string_view text) {
  for (size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    if (first < 0x80) {
      ++i;
      continue;
    }
    const size_t more = first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : 1;
    if (first < 0xc2 || first > 0xf4 || text.size() - i <= more) return false;
    uint32_t code = first & (0x3fu >> more);
    for (size_t k = 1; k <= more; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      if ((next & 0xc0) != 0x80) return false;
      code = code << 6 | (next & 0x3fu);
    }
    if ((more == 2 && code < 0x800) || (more == 3 && code < 0x10000)) return false;
    if (code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff)) return false;
    i += more + 1;
  }
  return true;
}

}  // namespace

Result<json> answer_object(std::string_view text) {
  if (text.size() > kMaxAnswerBytes) {
    return Error{ErrorCode::TooLarge, "the answer has " + std::to_string(text.size()) + " bytes; at most " +
                                          std::to_string(kMaxAnswerBytes) +
                                          " are read: give the JSON object alone"};
  }
  if (!is_utf8(text)) return invalid_data("the answer is not UTF-8: give the JSON object alone, in UTF-8");
  std::optional<json> found;
  bool too_deep = false;
  // Each search for a closing brace may run to the end, so their number is bounded.
  int searches = 0;
  for (size_t at = text.find('{'); at != std::string_view::npos && searches < 64; ++searches) {
    const auto [end, depth] = json_extent(text, at, kMaxAnswerDepth);
    size_t next = at + 1;
    if (depth > kMaxAnswerDepth) {
      too_deep = true;
    } else if (end != std::string_view::npos) {
      json object = json::parse(text.substr(at, end - at), nullptr, false);
      if (object.is_object()) {
        next = end;
        if (object.contains("mass_g")) {
          if (found && *found != object) {
            return invalid_data(
                "the answer holds more than one object with a mass_g: give exactly one JSON object");
          }
          found = std::move(object);
        }
      }
    }
    at = text.find('{', next);
  }
  if (found) return std::move(*found);
  if (too_deep) return invalid_data("the answer is nested too deep: give one flat JSON object of the schema");
  return invalid_data(
      "the answer holds no complete JSON object with a mass_g: give exactly one JSON object of the schema");
}

}  // namespace livegs
