// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/gate/answer_object.h"

#include <vector>

#include "analysis/gate/answer.h"
#include "analysis/text/json_text.h"

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

Result<json> answer_object(std::string_view text, const MessageTemplates& words) {
  if (text.size() > kMaxAnswerBytes) {
    return Error{ErrorCode::TooLarge, words.say("too_long", {{"bytes", std::to_string(text.size())},
                                                             {"most", std::to_string(kMaxAnswerBytes)}})};
  }
  if (!is_utf8(text)) return invalid_data(words.say("not_utf8"));
  std::optional<json> found;
  bool too_deep = false;
  // Bounds the number of searches for a closing brace, each of which may scan to the end.
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
            return invalid_data(words.say("many_objects"));
          }
          found = std::move(object);
        }
      }
    }
    at = text.find('{', next);
  }
  if (found) return std::move(*found);
  return invalid_data(words.say(too_deep ? "too_deep" : "no_object"));
}

}  // namespace livegs
