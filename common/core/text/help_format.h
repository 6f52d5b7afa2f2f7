// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <memory>
#include <sstream>
#include <string>

// The form of --help of all programs. Header only; the programs link CLI11.

namespace livegs {

// Prints an option as "--size WxH  Text": with the kind of its value, its range or choices, its default and
// its text, wrapped at kWidth characters.
class HelpFormatter final : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool positional) const override {
    const std::string name = make_option_name(option, positional);
    std::string text = option->get_description();
    if (const std::string range = range_of(*option); !range.empty()) text += "; " + range;
    if (!option->get_default_str().empty()) text += " (default: " + option->get_default_str() + ")";
    std::string head = "  " + name + kind_of(*option, positional);
    std::ostringstream out;
    if (head.size() + 2 > kColumn) {
      out << head << '\n' << std::string(kColumn, ' ');
    } else {
      out << head << std::string(kColumn - head.size(), ' ');
    }
    size_t column = kColumn;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
      if (column > kColumn && column + 1 + word.size() > kWidth) {
        out << '\n' << std::string(kColumn, ' ');
        column = kColumn;
      }
      if (column > kColumn) {
        out << ' ';
        ++column;
      }
      out << word;
      column += word.size();
    }
    out << '\n';
    return out.str();
  }

 private:
  static constexpr size_t kColumn = 32, kWidth = 110;  // where texts begin and end, characters

  // Where the part of the type begins that validators add, after a colon: "{a,b}", "INT in [1 - 9]", "FILE".
  // The kind itself may contain colons, as HOST:PORT does.
  static size_t end_of_kind(const std::string& type) {
    for (const char* mark : {":{", ":INT in [", ":UINT in [", ":FLOAT in [", ":FILE", ":DIR", ":NONNEGATIVE",
                             ":POSITIVE", ":NUMBER"}) {
      if (const size_t at = type.find(mark); at != std::string::npos) return at;
    }
    return type.size();
  }
  static std::string validator_of(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const size_t end = end_of_kind(type);
    return end == type.size() ? "" : type.substr(end + 1);
  }
  // " FILE"; empty for a flag and for a positional, whose name says it.
  static std::string kind_of(const CLI::Option& option, bool positional) {
    if (option.get_type_size() == 0 || positional) return "";
    const std::string type = option.get_type_name(), kind = type.substr(0, end_of_kind(type));
    const std::string validator = validator_of(option);
    if (!validator.empty() && validator.front() == '{') {
      std::string choices = validator.substr(1, validator.find('}') - 1);
      for (char& c : choices) c = c == ',' ? '|' : c;
      return " " + choices;
    }
    if (kind == "INT" || kind == "UINT") return " N";
    if (kind == "FLOAT") return " NUMBER";
    return kind.empty() ? "" : " " + kind;
  }
  // "1 to 9".
  static std::string range_of(const CLI::Option& option) {
    const std::string validator = validator_of(option);
    const size_t begin = validator.find(" in ["), end = validator.find(']');
    if (begin == std::string::npos || end == std::string::npos) return "";
    std::string range = validator.substr(begin + 5, end - begin - 5);
    if (const size_t dash = range.find(" - "); dash != std::string::npos) range.replace(dash, 3, " to ");
    return range;
  }
};

// Sets the kinds of the values of options and the group in which --help lists them. An empty kind keeps that
// of the option.
struct OptionKind {
  const char* option;
  const char* kind;
};
inline void group_options(CLI::App& app, const std::string& group,
                          std::initializer_list<OptionKind> options) {
  for (const OptionKind& one : options) {
    CLI::Option* option = app.get_option(one.option);
    option->group(group);
    if (one.kind[0] != 0) option->type_name(one.kind);
  }
}

}  // namespace livegs
