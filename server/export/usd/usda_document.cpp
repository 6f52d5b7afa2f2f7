// SPDX-License-Identifier: GPL-3.0-or-later
// The text syntax of OpenUSD (pxr/usd/sdf/usdaFileFormat), as far as a single layer without composition needs
// it.
#include "export/usd/usda_document.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include "core/text/shown_text.h"

namespace livegs {
namespace {

constexpr int kMaxDepth = 64;  // of prims, and of lists

class UsdaParser {
 public:
  UsdaParser(std::string_view text, std::string_view name) : text_(text), name_(name) {}

  Result<UsdaDocument> parse() {
    if (!text_.starts_with("#usda 1.0"))
      return invalid_data(
          name_ + ": is not a .usda file: its first line is not #usda 1.0; export the stage as .usda");
    UsdaDocument document;
    if (take('(')) {
      if (!metadata(document.metadata)) return error();
    }
    while (skip_space()) {
      if (!prim("", document.roots, 0)) return error();
    }
    return document;
  }

 private:
  Error error() const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    const std::string message = name_ + ": line " + std::to_string(line) + ": " + problem_;
    return unsupported_ ? unsupported(message) : with_remedy(invalid_data(message), "export the file again");
  }
  bool fail(std::string problem, bool is_unsupported = false) {
    if (problem_.empty()) {
      problem_ = std::move(problem);
      unsupported_ = is_unsupported;
    }
    return false;
  }

  // False at the end of the text.
  bool skip_space() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ';') {
        ++at_;
      } else if (c == '#' || text_.substr(at_, 2) == "//") {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (text_.substr(at_, 2) == "/*") {
        const size_t end = text_.find("*/", at_ + 2);
        at_ = end == text_.npos ? text_.size() : end + 2;
      } else {
        return true;
      }
    }
    return false;
  }
  bool next_is(char c) { return skip_space() && text_[at_] == c; }
  bool take(char c) {
    if (!next_is(c)) return false;
    ++at_;
    return true;
  }

  static bool in_word(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == ':' || (static_cast<unsigned char>(c) & 0x80);
  }
  std::string_view word() {
    skip_space();
    const size_t begin = at_;
    while (at_ < text_.size() && in_word(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }

  static int digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
  }

  bool quoted(std::string& result) {
    skip_space();
    const char quote = at_ < text_.size() ? text_[at_] : 0;
    if (quote != '"' && quote != '\'') return fail("a text in quotes is missing");
    const size_t marks = text_.substr(at_, 3) == std::string(3, quote) ? 3 : 1;
    const std::string end(marks, quote);
    at_ += marks;
    while (at_ < text_.size() && text_.substr(at_, marks) != end) {
      char c = text_[at_++];
      if (c == '\n' && marks == 1) return fail("a text has no closing quotes");
      if (c == '\\' && at_ < text_.size()) {
        c = text_[at_++];
        if (c == 'n') {
          c = '\n';
        } else if (c == 't') {
          c = '\t';
        } else if (c == 'r') {
          c = '\r';
        } else if (c == 'x' && at_ + 1 < text_.size() && digit(text_[at_]) >= 0 &&
                   digit(text_[at_ + 1]) >= 0) {
          c = static_cast<char>(digit(text_[at_]) * 16 + digit(text_[at_ + 1]));
          at_ += 2;
        }
      }
      result += c;
    }
    if (at_ >= text_.size()) return fail("a text has no closing quotes");
    at_ += marks;
    return true;
  }

  bool number(double& value) {
    const char* first = text_.data() + at_;
    const char* const last = text_.data() + text_.size();
    if (first < last && *first == '+') ++first;
    const auto [end, problem] = std::from_chars(first, last, value);
    if (problem == std::errc::result_out_of_range) {
      value = 0;
    } else if (problem != std::errc()) {
      return fail("a value is missing");
    }
    at_ = static_cast<size_t>(end - text_.data());
    return true;
  }

  bool value(UsdaValue& result, int depth) {
    if (depth > kMaxDepth) return fail("values are nested too deeply");
    if (!skip_space()) return fail("the file ends within a value");
    const char c = text_[at_];
    if (c == '"' || c == '\'') return quoted(result.texts.emplace_back());
    if (c == '<' || c == '@') {
      const char end = c == '<' ? '>' : '@';
      const size_t close = text_.find(end, at_ + 1);
      if (close == text_.npos) return fail("a path has no end");
      result.texts.emplace_back(text_.substr(at_ + 1, close - at_ - 1));
      at_ = close + 1;
      return true;
    }
    if (c == '(' || c == '[') {
      const char end = c == '(' ? ')' : ']';
      ++at_;
      while (!take(end)) {
        if (!value(result, depth + 1)) return false;
        if (take(',')) continue;
        if (!next_is(end)) return fail("a list has no end");
      }
      return true;
    }
    if (c == '{') return dictionary(depth);
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (letter) {
      const std::string_view name = word();
      if (name == "None") return true;
      if (name == "inf" || name == "nan") {
        result.numbers.push_back(name == "inf" ? std::numeric_limits<double>::infinity()
                                               : std::numeric_limits<double>::quiet_NaN());
      } else if (name == "true" || name == "false") {
        result.numbers.push_back(name == "true");
      } else {
        result.texts.emplace_back(name);
      }
      return true;
    }
    return number(result.numbers.emplace_back());
  }

  // TYPE KEY = VALUE; not kept.
  bool dictionary(int depth) {
    if (!take('{')) return fail("a dictionary is missing");
    while (!take('}')) {
      if (!skip_space()) return fail("the file ends within a dictionary");
      UsdaValue ignored;
      const size_t before = at_;
      if (word().empty()) {
        if (!value(ignored, depth + 1)) return false;
      }
      if (take('[') && !take(']')) return fail("a type has no end");
      if (next_is('"') || next_is('\'')) {
        std::string key;
        if (!quoted(key)) return false;
      } else {
        word();
      }
      if ((take('=') || take(':')) && !value(ignored, depth + 1)) return false;
      take(',');
      if (at_ == before) return fail("a dictionary has no end");
    }
    return true;
  }

  // The inside of ( … ), up to the closing parenthesis.
  bool metadata(std::map<std::string, UsdaValue>& entries) {
    static const std::set<std::string_view> kEdits = {"prepend", "append", "add", "delete", "reorder"};
    static const std::set<std::string_view> kComposition = {"references",  "payload",   "inherits",
                                                            "specializes", "subLayers", "variantSets"};
    while (!take(')')) {
      if (!skip_space()) return fail("the file ends within ( )");
      if (next_is('"') || next_is('\'')) {  // a comment
        std::string ignored;
        if (!quoted(ignored)) return false;
        continue;
      }
      std::string_view key = word();
      const bool edits = kEdits.contains(key);
      const bool deletes = key == "delete";
      if (edits) key = word();
      if (key.empty()) return fail("a key is missing");
      if (kComposition.contains(key))
        return fail("has " + std::string(key) + ", which are not followed; flatten the stage first", true);
      const std::string name(key);
      if (!take('=')) return fail("no value follows " + quoted_name(name));
      UsdaValue read;
      if (!value(read, 0)) return false;
      if (!deletes) entries[name] = std::move(read);
      take(',');
    }
    return true;
  }

  bool prim(const std::string& parent, std::vector<UsdaPrim>& list, int depth) {
    if (depth > kMaxDepth) return fail("prims are nested too deeply");
    const std::string_view specifier = word();
    if (specifier != "def" && specifier != "over" && specifier != "class")
      return fail("def, over or class is missing");
    UsdaPrim made;
    if (!next_is('"')) made.type = word();
    if (!quoted(made.name)) return false;
    if (made.name.empty()) return fail("a prim has no name");
    made.path = parent + "/" + made.name;
    if (take('(') && !metadata(made.metadata)) return false;
    if (!take('{')) return fail("the contents of " + quoted_name(made.path) + " are missing");
    while (!take('}')) {
      if (!skip_space()) return fail("the file ends within " + quoted_name(made.path));
      const size_t before = at_;
      const std::string_view first = word();
      at_ = before;
      if (first == "def" || first == "over" || first == "class") {
        if (!prim(made.path, made.children, depth + 1)) return false;
      } else if (!property(made)) {
        return false;
      }
    }
    if (specifier != "class") list.push_back(std::move(made));
    return true;
  }

  bool property(UsdaPrim& owner) {
    static const std::set<std::string_view> kPrefixes = {"custom",  "uniform", "varying", "config",
                                                         "prepend", "append",  "add",     "delete"};
    std::string_view type = word();
    while (kPrefixes.contains(type)) type = word();
    if (type == "variantSet")
      return fail("has variants, which are not followed; flatten the stage first", true);
    if (type == "reorder") {
      word();
      UsdaValue ignored;
      return take('=') && value(ignored, 0);
    }
    if (type.empty()) return fail("a property is missing");
    if (take('[') && !take(']')) return fail("a type has no end");
    const std::string name(word());
    if (name.empty()) return fail("a property has no name");
    std::string_view field;
    if (at_ < text_.size() && text_[at_] == '.') {
      ++at_;
      field = word();
    }
    if (take('=')) {
      if (field == "timeSamples") {
        if (!time_samples(owner.samples[name])) return false;
      } else if (field == "connect") {
        UsdaValue ignored;
        if (!value(ignored, 0)) return false;
      } else if (!field.empty()) {
        return fail("a property has an unknown part");
      } else {
        UsdaValue read;
        if (!value(read, 0)) return false;
        owner.properties[name] = std::move(read);
      }
    } else if (field.empty()) {
      owner.properties.try_emplace(name);
    }
    std::map<std::string, UsdaValue> ignored;
    return !take('(') || metadata(ignored);
  }

  bool time_samples(std::vector<std::pair<double, UsdaValue>>& samples) {
    if (!take('{')) return fail("time samples are missing");
    while (!take('}')) {
      if (!skip_space()) return fail("the file ends within time samples");
      auto& [time, sample] = samples.emplace_back();
      if (!number(time)) return false;
      if (!take(':')) return fail("no value follows a time");
      if (!value(sample, 0)) return false;
      if (samples.size() > 1 && !(time > samples[samples.size() - 2].first))
        return fail("the times of samples do not increase");
      if (take(',')) continue;
      if (!next_is('}')) return fail("time samples have no end");
    }
    return true;
  }

  std::string_view text_;
  std::string name_;
  size_t at_ = 0;
  std::string problem_;
  bool unsupported_ = false;
};

}  // namespace

bool UsdaPrim::has_schema(std::string_view schema) const {
  const auto found = metadata.find("apiSchemas");
  return found != metadata.end() && std::find(found->second.texts.begin(), found->second.texts.end(),
                                              schema) != found->second.texts.end();
}

Result<UsdaDocument> parse_usda(std::string_view text, std::string_view name) {
  return UsdaParser(text, name).parse();
}

}  // namespace livegs
