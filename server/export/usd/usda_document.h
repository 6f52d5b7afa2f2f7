// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.h"

namespace livegs {

// A value of a .usda without its structure: the numbers and the texts (strings, tokens, paths) of a scalar, a
// tuple or a list, in order. Dictionaries are empty.
struct UsdaValue {
  std::vector<double> numbers;
  std::vector<std::string> texts;
};

struct UsdaPrim {
  std::string type, name, path;
  std::map<std::string, UsdaValue> metadata, properties;
  std::map<std::string, std::vector<std::pair<double, UsdaValue>>> samples;  // by property; ascending times
  std::vector<UsdaPrim> children;

  const UsdaValue* value(const std::string& property) const {
    const auto found = properties.find(property);
    return found == properties.end() ? nullptr : &found->second;
  }
  std::string text(const std::string& property) const {  // empty: none
    const UsdaValue* found = value(property);
    return found && !found->texts.empty() ? found->texts[0] : std::string();
  }
  bool has_schema(std::string_view name) const;  // in apiSchemas
};

// One layer of text, OpenUSD crate 1.0 syntax ("#usda 1.0"). Composition is not evaluated: references,
// payloads, sublayers, inherits and variants are errors. Accepts any bytes; memory is at most about eight
// times the text.
struct UsdaDocument {
  std::map<std::string, UsdaValue> metadata;
  std::vector<UsdaPrim> roots;
};
// Errors name the line.
Result<UsdaDocument> parse_usda(std::string_view text, std::string_view name);

}  // namespace livegs
