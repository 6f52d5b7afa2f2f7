// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "analysis/text/json_text.h"
#include "store/secret.h"

namespace livegs {

// Transcript for users: JSON lines, redacted before they are stored.
class Transcript {
 public:
  explicit Transcript(const Secret& key) : key_(&key) {}

  void request(std::string_view phase, std::string_view body);  // a JSON text
  void reply(int status, std::string_view body);
  void tool(std::string_view name, std::string_view arguments, std::string_view result);
  void note(std::string_view text);

  const std::string& lines() const { return lines_; }
  std::string redact(std::string_view text) const { return key_->redact(text); }

 private:
  void add(OrderedJson line);
  const Secret* key_;
  std::string lines_;
};

}  // namespace livegs
