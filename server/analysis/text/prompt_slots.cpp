// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/text/prompt_slots.h"

#include <algorithm>
#include <vector>

#include "analysis/text/prompt_text.h"
#include "core/text/nearest_word.h"

namespace livegs {
namespace {

constexpr std::size_t kMaxShownLength = 40;

bool is_lower_case(std::string_view slot) {
  return !slot.empty() &&
         std::all_of(slot.begin(), slot.end(), [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
}

std::string braced(std::string_view slot) { return "{{" + std::string(slot) + "}}"; }

std::string list_of(const SlotNames& known) {
  std::string list;
  for (const std::string& slot : known) list += (list.empty() ? "" : ", ") + braced(slot);
  return list;
}

std::string remedy(std::string_view slot, const SlotNames& known) {
  if (known.empty()) return "no slot of this text is filled; remove it";
  if (const std::string meant = meant_word(slot, known); !meant.empty())
    return "write " + braced(meant) + " or remove it";
  return "remove it or write one of " + list_of(known);
}

}  // namespace

SlotNames slots_of(std::string_view text) {
  SlotNames slots;
  fill_line(text, [&](std::string_view slot) {
    slots.emplace(slot);
    return std::string();
  });
  return slots;
}

Result<void> check_slots(std::string_view text, const SlotNames& known) {
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string at = "line " + std::to_string(number) + ": ";
    for (std::size_t open = 0; (open = line.find("{{", open)) != std::string_view::npos;) {
      const std::string_view rest = line.substr(open + 2);
      const std::size_t close = rest.find("}}");
      const std::string_view slot = rest.substr(0, std::min(close, rest.find('}')));
      open += 2;
      if (known.empty() && !(is_lower_case(slot) && close == slot.size())) continue;
      const std::string shown = line_text(slot, kMaxShownLength);
      if (close != slot.size())
        return invalid_data(at + "{{" + shown + " has no end; write it as {{slot}}, on one line");
      if (slot.empty()) return invalid_data(at + "{{}} does not name a slot; " + remedy(slot, known));
      if (!known.contains(slot))
        return invalid_data(at + braced(shown) + " is not a known slot; " + remedy(slot, known));
      open += slot.size() + 2;
    }
  }
  return {};
}

std::string meant_word(std::string_view word, const SlotNames& known) {
  std::string meant;
  std::size_t least = 3 + word.size() / 8;
  for (const std::string& one : known) {
    const std::size_t steps = edit_distance(word, one);
    if (steps < std::min(least, one.size())) {
      least = steps;
      meant = one;
    }
  }
  return meant;
}

}  // namespace livegs
