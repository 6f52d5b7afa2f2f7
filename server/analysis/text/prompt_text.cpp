// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/text/prompt_text.h"

namespace livegs {
namespace {

// Length in bytes of the UTF-8 character at `at`: 1 to 4, or 0 if it is invalid or truncated.
std::size_t character_size(std::string_view text, std::size_t at) {
  const auto lead = static_cast<unsigned char>(text[at]);
  const std::size_t size = lead < 0x80                   ? 1
                           : lead >= 0xC2 && lead < 0xE0 ? 2
                           : lead >= 0xE0 && lead < 0xF0 ? 3
                           : lead >= 0xF0 && lead < 0xF5 ? 4
                                                         : 0;
  if (at + size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((static_cast<unsigned char>(text[at + i]) & 0xC0) != 0x80) return 0;
  }
  return size;
}

// True for C0, DEL and C1 controls, and for bidirectional controls and zero-width characters.
bool is_control(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first < 0x20 || first == 0x7F;
  if (character.size() == 2) return first == 0xC2 && static_cast<unsigned char>(character[1]) < 0xA0;
  if (character.size() != 3) return false;
  const unsigned code = (first & 0x0Fu) << 12 | (static_cast<unsigned char>(character[1]) & 0x3Fu) << 6 |
                        (static_cast<unsigned char>(character[2]) & 0x3Fu);
  return (code >= 0x200B && code <= 0x200F) || (code >= 0x2028 && code <= 0x202E) ||
         (code >= 0x2060 && code <= 0x206F) || code == 0xFEFF;
}

// Sanitises text for use between double quotes. `own` keeps braces and angle brackets.
std::string on_one_line(std::string_view text, std::size_t longest, bool own) {
  std::string line;
  std::size_t count = 0;
  for (std::size_t at = 0; at < text.size() && count < longest;) {
    const std::size_t size = character_size(text, at);
    if (size == 0) {
      ++at;
      continue;
    }
    const std::string_view character = text.substr(at, size);
    at += size;
    if (is_control(character)) {
      if (!line.ends_with(' ')) line += ' ';
    } else if (character == "\"" || character == "`") {
      line += '\'';
    } else if (!own && (character == "<" || character == "{")) {
      line += '(';
    } else if (!own && (character == ">" || character == "}")) {
      line += ')';
    } else {
      line += character;
    }
    ++count;
  }
  return line;
}

}  // namespace

std::string quoted_text(std::string_view text, std::size_t longest) {
  return '"' + line_text(text, longest) + '"';
}

std::string line_text(std::string_view text, std::size_t longest) {
  return on_one_line(text, longest, false);
}

std::string quoted_line(std::string_view line, std::size_t longest) {
  return '"' + on_one_line(line, longest, true) + '"';
}

std::string plain_text(std::string_view text, std::size_t longest) {
  std::string plain;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t size = character_size(text, at);
    const std::string_view character = text.substr(at, size ? size : 1);
    at += character.size();
    if (size == 0 || (is_control(character) && character != "\n")) continue;
    if (plain.size() + size > longest) break;
    if (character == "-" && plain.ends_with("---")) continue;
    plain += character;
  }
  return plain;
}

std::string fill_line(std::string_view line,
                      const std::function<std::string(std::string_view slot)>& value_of) {
  std::string filled;
  for (;;) {
    const std::size_t open = line.find("{{");
    const std::size_t close = open == std::string_view::npos ? open : line.find("}}", open);
    if (close == std::string_view::npos) return filled.append(line);
    filled += line.substr(0, open);
    filled += value_of(line.substr(open + 2, close - open - 2));
    line.remove_prefix(close + 2);
  }
}

std::string fill_slots(std::string_view text, const std::map<std::string, std::string>& slots) {
  std::string filled;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    bool keep = true;
    const std::string line = fill_line(text.substr(0, end), [&](std::string_view slot) {
      const auto found = slots.find(std::string(slot));
      keep = keep && found != slots.end() && !found->second.empty();
      return keep ? found->second : std::string();
    });
    if (keep) filled += line;
    text.remove_prefix(end);
  }
  return filled;
}

}  // namespace livegs
