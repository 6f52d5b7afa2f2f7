// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/knowledge/tables.h"
#include "analysis/knowledge/value_ranges.h"
#include "analysis/text/message_templates.h"
#include "core/result.h"

// What a language model answers about one object, in the schema `livegs.analysis/1`, read without trusting a
// byte of it. This is the one place where grams, megapascals and millimetres become SI.

namespace livegs {

inline constexpr size_t kMaxAnswerBytes = 256 << 10;
inline constexpr int kMaxAnswerDepth = 16;
inline constexpr size_t kMaxAnswerParts = 32;
inline constexpr size_t kMaxAnswerSources = 8;

struct AnswerPart {
  std::string name;
  const MaterialRow* material = nullptr;  // of the table
  double share = 0;                       // of the mass; the parts' shares add up to 1
  std::optional<double> thickness_m;
};

struct Answer {
  std::string name, description, evidence;  // printable, cut to a length; only ever shown
  std::optional<double> name_confidence;
  std::optional<bool> replica;
  std::vector<std::string> kb_ids;                     // rows of the tables it went by; those that there are
  v1::Physics::Fill fill = v1::Physics::FILL_UNKNOWN;  // FILL_UNKNOWN: an assembly
  v1::Physics::Behavior behavior = v1::Physics::RIGID;
  std::vector<AnswerPart> parts;  // largest share first; at least one
  Span3 mass_kg;
  std::optional<Span3> youngs_modulus_pa;
  std::optional<Span3> structure_coefficient;
  std::optional<double> plasticity;
  bool fragile = false;
  std::optional<double> friction, restitution;
  std::optional<double> longest_side_m;
  double confidence = 0.5;
  bool blind = false;                // given without having seen the pictures
  std::vector<std::string> changes;  // what was read otherwise than it stands there, a line each
};

// The object in the text, also among prose or in a fence, checked: UTF-8, size, depth, types, enumerators,
// finite, low <= best <= high, within kMaxRangeRatio, within the ranges above. The error is one line of
// prompts/complaints.json that names the field and tells the model how to mend it. Pure; any bytes; any
// thread.
Result<Answer> read_answer(std::string_view text,
                           const MessageTemplates& words = MessageTemplates::built_in());

// Text of a model, fit to be shown: control characters and broken UTF-8 gone, at most `characters` long.
std::string shown_text(std::string_view text, size_t characters);

}  // namespace livegs
