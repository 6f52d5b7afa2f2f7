// SPDX-License-Identifier: GPL-3.0-or-later
#include "export/usd/usda_text.h"

#include <charconv>

namespace livegs {
namespace {

template <class Number>
void append_number(std::string& text, Number value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
}

// Length of the UTF-8 sequence at the start; 0 if it is invalid.
size_t utf8_length(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  const size_t length = first < 0x80       ? 1
                        : first >> 5 == 6  ? 2
                        : first >> 4 == 14 ? 3
                        : first >> 3 == 30 ? 4
                                           : 0;
  if (length == 0 || length > text.size()) return 0;
  unsigned code = length == 1 ? first : first & (0x7fu >> length);
  for (size_t i = 1; i < length; ++i) {
    if (byte(i) >> 6 != 2) return 0;
    code = code << 6 | (byte(i) & 0x3f);
  }
  static constexpr unsigned kLowest[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  return code < kLowest[length] || surrogate || code > 0x10ffff ? 0 : length;
}

}  // namespace

void UsdaText::line(std::string_view text) {
  text_.append(4 * depth_, ' ');
  text_ += text;
  text_ += '\n';
}

void UsdaText::open(std::string_view head) {
  line(head);
  line("{");
  ++depth_;
}

void UsdaText::close() {
  --depth_;
  line("}");
}

void UsdaText::append_floats(std::string& text, std::span<const float> values, size_t components) {
  text += '[';
  for (size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text += ", ";
    if (components > 1 && i % components == 0) text += '(';
    append_number(text, values[i]);
    if (components > 1 && i % components == components - 1) text += ')';
  }
  text += ']';
}

void UsdaText::floats(std::string_view name, std::span<const float> values, size_t components) {
  text_.append(4 * depth_, ' ');
  text_ += name;
  text_ += " = ";
  append_floats(text_, values, components);
  text_ += '\n';
}

void UsdaText::integers(std::string_view name, std::span<const int64_t> values, size_t components) {
  text_.append(4 * depth_, ' ');
  text_ += name;
  text_ += " = [";
  for (size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text_ += ", ";
    if (components > 1 && i % components == 0) text_ += '(';
    append_number(text_, values[i]);
    if (components > 1 && i % components == components - 1) text_ += ')';
  }
  text_ += "]\n";
}

std::string usda_number(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

std::string usda_number(float value) {
  std::string text;
  append_number(text, value);
  return text;
}

std::string usda_tuple(const Eigen::Vector3d& v) {
  return "(" + usda_number(v.x()) + ", " + usda_number(v.y()) + ", " + usda_number(v.z()) + ")";
}

std::string usda_tuple(const Eigen::Quaterniond& q) {
  return "(" + usda_number(q.w()) + ", " + usda_number(q.x()) + ", " + usda_number(q.y()) + ", " +
         usda_number(q.z()) + ")";
}

std::string usda_string(std::string_view text) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string quoted = "\"";
  while (!text.empty()) {
    const char c = text[0];
    const auto byte = static_cast<unsigned char>(c);
    size_t length = 1;
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
    } else if (const size_t sequence = utf8_length(text); sequence > 0) {
      quoted += text.substr(0, sequence);
      length = sequence;
    } else {
      quoted += "\xef\xbf\xbd";
    }
    text.remove_prefix(length);
  }
  return quoted + '"';
}

std::string usda_identifier(std::string_view text) {
  std::string name;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    name += plain ? c : '_';
  }
  if (name.empty() || (name[0] >= '0' && name[0] <= '9')) name.insert(0, 1, '_');
  return name;
}

}  // namespace livegs
