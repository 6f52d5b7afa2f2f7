// SPDX-License-Identifier: Apache-2.0
// Reads JSON along the descriptor of a message, so that each error has a field and a position; protobuf's own
// parser then sets the fields.
#include "json/json_message.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/text/nearest_word.h"
#include "core/text/shown_text.h"

namespace livegs {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::OneofDescriptor;

// Longest part of a user's text in a message, in characters.
constexpr size_t kMaxShown = 40;

std::string quoted_input(std::string_view text) { return quoted_name(text, kMaxShown); }

// "a, b or c".
std::string choice_of(const std::vector<std::string>& words) {
  std::string text;
  for (size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& words) {
  const std::string_view near = nearest_word(word, words);
  return near.empty() ? "" : "; did you mean " + quoted_input(near) + "?";
}

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text), without_comments_(text) {}

  Result<std::string> read(const Descriptor& type) {
    if (text_.starts_with("\xEF\xBB\xBF")) skip_bytes(3);  // a byte order mark
    if (read_all(type)) return without_comments_;
    return invalid_data(error_);
  }

 private:
  bool read_all(const Descriptor& type) {
    if (!skip()) return false;
    if (at_ == text_.size()) return fail("is not JSON: the file is empty");
    if (text_[at_] != '{') return fail("must be one JSON object, { … }");
    if (!read_object(type) || !skip()) return false;
    return at_ == text_.size() || fail("is not JSON: more text after the end of the object");
  }

  // Reads the object at the position.
  bool read_object(const Descriptor& type) {
    const size_t begin = at_++;
    names_.emplace_back();
    std::set<const FieldDescriptor*> given;
    std::map<const OneofDescriptor*, std::string> chosen;
    if (!skip()) return false;
    bool more = !take('}');
    while (more) {
      const size_t key_at = at_;
      std::string key;
      if (at_ == text_.size()) return fail_end(begin);
      if (text_[at_] != '"') return fail("is not JSON: a field begins with its name in quotes");
      if (!read_string(key)) return false;
      const FieldDescriptor* field = field_of(type, key);
      if (!field) return fail_unknown(key_at, type, key);
      if (!given.insert(field).second)
        return fail_at(key_at, quoted_input(key) + " is given twice; remove one");
      if (const OneofDescriptor* oneof = field->real_containing_oneof()) {
        if (const auto [other, first] = chosen.emplace(oneof, key); !first)
          return fail_at(key_at, quoted_input(other->second) + " and " + quoted_input(key) +
                                     " exclude each other; remove one");
      }
      if (!skip()) return false;
      if (!take(':')) return fail_missing("a colon after " + quoted_input(key), begin);
      path_.push_back((path_.empty() ? "" : ".") + key);
      if (!skip() || !read_field(*field, begin)) return false;
      path_.pop_back();
      if (!read_separator('}', begin, more)) return false;
    }
    names_.pop_back();
    return true;
  }

  // Reads a comma or the closing bracket of what began there.
  bool read_separator(char closing, size_t begin, bool& more) {
    if (!skip()) return false;
    more = false;
    if (take(closing)) return true;
    if (!take(',')) return fail_missing(std::string("a comma or ") + closing, begin);
    const size_t comma = at_ - 1;
    if (!skip()) return false;
    if (at_ < text_.size() && text_[at_] == closing)
      return fail_at(comma, std::string("is not JSON: a comma before ") + closing + "; remove it");
    more = true;
    return true;
  }

  bool read_field(const FieldDescriptor& field, size_t begin) {
    if (at_ == text_.size()) return fail_end(begin);
    if (take_word("null")) return true;  // as if it were not given
    if (field.is_map()) return read_map(field);
    if (!field.is_repeated()) return read_value(field, begin);
    if (text_[at_] != '[') return fail("must be a list, [ … ]" + found());
    const size_t list = at_++;
    if (!skip()) return false;
    bool more = !take(']');
    for (size_t i = 0; more; ++i) {
      if (at_ == text_.size()) return fail_end(list);
      path_.push_back("[" + std::to_string(i) + "]");
      if (!read_value(field, list)) return false;
      path_.pop_back();
      if (!read_separator(']', list, more)) return false;
    }
    return true;
  }

  bool read_map(const FieldDescriptor& field) {
    if (text_[at_] != '{') return fail("must be an object, { … }" + found());
    const FieldDescriptor& value = *field.message_type()->map_value();
    const size_t begin = at_++;
    std::set<std::string> given;
    if (!skip()) return false;
    bool more = !take('}');
    while (more) {
      const size_t key_at = at_;
      std::string key;
      if (at_ == text_.size()) return fail_end(begin);
      if (text_[at_] != '"') return fail("is not JSON: an entry begins with its name in quotes");
      if (!read_string(key)) return false;
      if (!given.insert(key).second)
        return fail_at(key_at, quoted_input(key) + " is given twice; remove one");
      if (!skip()) return false;
      if (!take(':')) return fail_missing("a colon after " + quoted_input(key), begin);
      path_.push_back("[" + quoted_input(key) + "]");
      if (!skip() || !read_value(value, begin)) return false;
      path_.pop_back();
      if (!read_separator('}', begin, more)) return false;
    }
    return true;
  }

  // Reads one value of a field, which begins at the position.
  bool read_value(const FieldDescriptor& field, size_t begin) {
    if (at_ == text_.size()) return fail_end(begin);
    const char first = text_[at_];
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_MESSAGE:
        if (first != '{') return fail("must be an object, { … }" + found());
        return read_object(*field.message_type());
      case FieldDescriptor::CPPTYPE_STRING: {
        if (first != '"') return fail("must be a text in quotes" + found());
        std::string value;
        if (!read_string(value)) return false;
        if (field.name() == "name") names_.back() = value;
        return true;
      }
      case FieldDescriptor::CPPTYPE_BOOL:
        return take_word("true") || take_word("false") || fail("must be true or false" + found());
      case FieldDescriptor::CPPTYPE_ENUM:
        return read_enum(*field.enum_type());
      case FieldDescriptor::CPPTYPE_DOUBLE:
        return read_number(-std::numeric_limits<double>::max(), std::numeric_limits<double>::max(), false);
      case FieldDescriptor::CPPTYPE_FLOAT:
        return read_number(-std::numeric_limits<float>::max(), std::numeric_limits<float>::max(), false);
      case FieldDescriptor::CPPTYPE_INT32:
        return read_number(-0x1p31, 0x1p31 - 1, true);
      case FieldDescriptor::CPPTYPE_UINT32:
        return read_number(0, 0x1p32 - 1, true);
      case FieldDescriptor::CPPTYPE_INT64:
        return read_number(-0x1p63, 0x1p63, true);
      case FieldDescriptor::CPPTYPE_UINT64:
        return read_number(0, 0x1p64, true);
    }
    return fail("has a type that files cannot contain");
  }

  bool read_enum(const EnumDescriptor& type) {
    const size_t begin = at_;
    std::vector<std::string> names;
    for (int i = 0; i < type.value_count(); ++i) names.push_back(type.value(i)->name());
    std::string value;
    if (text_[at_] == '"') {
      if (!read_string(value)) return false;
      if (type.FindValueByName(value)) return true;
    } else {
      const std::string_view token = token_at(at_);
      const auto number = number_of(token);
      if (number && *number == std::round(*number) && std::abs(*number) < 1e9 &&
          type.FindValueByNumber(static_cast<int>(*number))) {
        at_ += token.size();
        return true;
      }
    }
    at_ = begin;
    return fail("must be " + choice_of(names) + found() + suggestion(value, names));
  }

  // Numbers may be in quotes, as protobuf writes large ones.
  bool read_number(double low, double high, bool whole) {
    const size_t begin = at_;
    std::string value;
    if (text_[at_] == '"') {
      if (!read_string(value)) return false;
    } else {
      value = token_at(at_);
      at_ += value.size();
    }
    const size_t end = std::exchange(at_, begin);
    const auto number = number_of(value);
    if (!number) return fail("must be a number" + found());
    if (!std::isfinite(*number) || *number < low || *number > high) {
      return fail("is out of range: must be from " + text_of(low) + " to " + text_of(high) + found());
    }
    if (whole && *number != std::round(*number)) return fail("must be a whole number" + found());
    at_ = end;
    return true;
  }

  static std::string text_of(double limit) {
    char text[40];
    std::snprintf(text, sizeof text, std::abs(limit) < 1e15 ? "%.0f" : "%.2g", limit);
    return text;
  }

  // A number by the grammar of JSON.
  static std::optional<double> number_of(std::string_view token) {
    size_t i = 0;
    const auto digits = [&] {
      const size_t from = i;
      while (i < token.size() && token[i] >= '0' && token[i] <= '9') ++i;
      return i - from;
    };
    if (i < token.size() && token[i] == '-') ++i;
    const size_t lead = i;
    const size_t count = digits();
    if (count == 0 || (count > 1 && token[lead] == '0')) return std::nullopt;
    if (i < token.size() && token[i] == '.' && (++i, digits() == 0)) return std::nullopt;
    if (i < token.size() && (token[i] == 'e' || token[i] == 'E')) {
      if (++i < token.size() && (token[i] == '+' || token[i] == '-')) ++i;
      if (digits() == 0) return std::nullopt;
    }
    if (i != token.size()) return std::nullopt;
    return std::strtod(std::string(token).c_str(), nullptr);
  }

  // Reads the string at the position and decodes it, except that \u stays as it is.
  bool read_string(std::string& value) {
    const size_t begin = at_++;
    while (at_ < text_.size() && text_[at_] != '"') {
      const char c = text_[at_];
      if (static_cast<unsigned char>(c) < 0x20)
        return fail_at(begin, "is not JSON: a text in quotes must end in the same line");
      if (c == '\\') {
        constexpr std::string_view kEscapes = "\"\\/bfnrtu";
        if (at_ + 1 == text_.size() || kEscapes.find(text_[at_ + 1]) == std::string_view::npos)
          return fail("is not JSON: a backslash in a text; write \\\\ or /");
        value += text_[at_++] == '\\' && text_[at_] != 'u' ? "" : "\\";
      }
      value += text_[at_++];
    }
    if (at_ == text_.size()) return fail_at(begin, "is not JSON: a text in quotes does not end");
    ++at_;
    return true;
  }

  static const FieldDescriptor* field_of(const Descriptor& type, const std::string& key) {
    if (const FieldDescriptor* field = type.FindFieldByName(key)) return field;
    for (int i = 0; i < type.field_count(); ++i) {
      if (type.field(i)->json_name() == key) return type.field(i);
    }
    return nullptr;
  }

  bool fail_unknown(size_t at, const Descriptor& type, const std::string& key) {
    std::vector<std::string> names;
    for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
    std::string remedy = suggestion(key, names);
    if (remedy.empty() && !names.empty()) {
      std::sort(names.begin(), names.end());
      remedy = "; the fields here are ";
      for (size_t i = 0; i < names.size(); ++i)
        remedy += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
    }
    return fail_at(at, "unknown field " + quoted_input(key) + remedy);
  }

  // The token at a position: letters, digits and the signs of numbers.
  std::string_view token_at(size_t at) const {
    size_t end = at;
    while (end < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[end])) != 0 ||
                                  std::string_view("+-._").find(text_[end]) != std::string_view::npos))
      ++end;
    return text_.substr(at, end - at);
  }

  // ", not 3", with the value at the position.
  std::string found() const {
    if (at_ >= text_.size()) return "";
    const char c = text_[at_];
    if (c == '{') return ", not an object";
    if (c == '[') return ", not a list";
    if (c == '"') return ", not " + quoted_input(text_.substr(at_ + 1, text_.find('"', at_ + 1) - at_ - 1));
    const std::string_view token = token_at(at_);
    return token.empty() ? std::string(", not ") + c : ", not " + std::string(token.substr(0, kMaxShown));
  }

  bool take(char wanted) {
    if (at_ == text_.size() || text_[at_] != wanted) return false;
    ++at_;
    return true;
  }
  bool take_word(std::string_view word) {
    if (token_at(at_) != word) return false;
    at_ += word.size();
    return true;
  }

  // Skips white space and comments, which are replaced by spaces.
  bool skip() {
    while (at_ < text_.size()) {
      const std::string_view rest = text_.substr(at_);
      if (std::string_view(" \t\r\n").find(rest[0]) != std::string_view::npos) {
        ++at_;
      } else if (rest.starts_with("//")) {
        skip_bytes(std::min(rest.find('\n'), rest.size()));
      } else if (rest.starts_with("/*")) {
        const size_t end = rest.find("*/", 2);
        if (end == std::string_view::npos) return fail("is not JSON: a comment does not end; add */");
        skip_bytes(end + 2);
      } else {
        break;
      }
    }
    return true;
  }
  void skip_bytes(size_t count) {
    for (; count > 0; --count, ++at_) {
      if (text_[at_] != '\n') without_comments_[at_] = ' ';
    }
  }

  bool fail_missing(const std::string& what, size_t begin) {
    return at_ == text_.size() ? fail_end(begin) : fail("is not JSON: " + what + " is missing");
  }
  bool fail_end(size_t begin) {
    return fail("is not JSON: the text ends within what begins at " + position(begin));
  }
  bool fail(const std::string& what) { return fail_at(at_, what); }
  bool fail_at(size_t at, const std::string& what) {
    std::string path, name;
    for (const std::string& part : path_) path += part;
    for (const std::string& one : names_) name = one.empty() ? name : one;
    if (!path.empty()) path += (name.empty() ? "" : " of " + quoted_input(name)) + ": ";
    error_ = position(at) + ": " + path + what;
    return false;
  }
  std::string position(size_t at) const {
    const std::string_view before = text_.substr(0, at);
    const size_t line = static_cast<size_t>(std::count(before.begin(), before.end(), '\n')) + 1;
    const size_t begin = before.rfind('\n');
    size_t column = 1;  // in characters of UTF-8
    for (const char c : before.substr(begin == std::string_view::npos ? 0 : begin + 1))
      column += (static_cast<unsigned char>(c) & 0xC0) != 0x80 ? 1 : 0;
    return "line " + std::to_string(line) + ", column " + std::to_string(column);
  }

  const std::string_view text_;
  std::string without_comments_;
  size_t at_ = 0;
  std::vector<std::string> path_;   // of the current field
  std::vector<std::string> names_;  // value of "name" in each open object; empty: none yet
  std::string error_;
};

}  // namespace

Result<void> parse_json_message(std::string_view text, google::protobuf::Message& message) {
  const auto plain = Reader(text).read(*message.GetDescriptor());
  if (!plain) return plain.error();
  message.Clear();
  const auto status = google::protobuf::util::JsonStringToMessage(*plain, &message);
  if (status.ok()) return {};
  // Bytes that are not UTF-8, for instance.
  std::string what(status.message());
  std::replace(what.begin(), what.end(), '\n', ' ');
  return invalid_data(what);
}

}  // namespace livegs
