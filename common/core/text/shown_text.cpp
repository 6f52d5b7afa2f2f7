// SPDX-License-Identifier: Apache-2.0
#include "core/text/shown_text.h"

namespace livegs {

std::string shown_text(std::string_view text, size_t characters) {
  std::string shown;
  size_t count = 0;
  for (size_t i = 0; i < text.size() && count < characters;) {
    const auto c = static_cast<unsigned char>(text[i]);
    const size_t length = c < 0x80 ? 1 : c >= 0xf0 ? 4 : c >= 0xe0 ? 3 : c >= 0xc0 ? 2 : 0;
    const bool is_control =
        c < 0x20 || c == 0x7f ||
        (c == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0);
    bool whole = length > 0 && i + length <= text.size();
    for (size_t k = 1; whole && k < length; ++k)
      whole = (static_cast<unsigned char>(text[i + k]) & 0xc0) == 0x80;
    // U+200B … U+200F, U+2028 … U+202E and U+2066 … U+2069 hide text or reverse its direction.
    const bool hides = whole && length == 3 && c == 0xe2 &&
                       ((text[i + 1] == '\x80' && ((text[i + 2] >= '\x8b' && text[i + 2] <= '\x8f') ||
                                                   (text[i + 2] >= '\xa8' && text[i + 2] <= '\xae'))) ||
                        (text[i + 1] == '\x81' && text[i + 2] >= '\xa6' && text[i + 2] <= '\xa9'));
    if (!whole) {
      ++i;
      continue;
    }
    if (is_control || hides) {
      if (!shown.empty() && shown.back() != ' ') shown += ' ', ++count;
    } else {
      shown.append(text.substr(i, length));
      ++count;
    }
    i += length;
  }
  return shown;
}

std::string quoted_name(std::string_view text, size_t characters) {
  const std::string shown = shown_text(text, characters);
  const bool cut = shown.size() < shown_text(text, characters + 1).size();
  return "\"" + shown + (cut ? "…\"" : "\"");
}

}  // namespace livegs
