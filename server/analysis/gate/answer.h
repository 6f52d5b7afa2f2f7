// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/division/picture_votes.h"
#include "analysis/knowledge/tables.h"
#include "analysis/knowledge/value_ranges.h"
#include "analysis/text/message_templates.h"
#include "core/result.h"

// A language model's answer about one object, in the schema `livegs.analysis/1`, parsed as untrusted input.
// Grams, megapascals and millimetres are converted to SI only here.

namespace livegs {

inline constexpr size_t kMaxAnswerBytes = 256 << 10;
inline constexpr int kMaxAnswerDepth = 16;
inline constexpr size_t kMaxListedParts = 256;  // as the model lists them
inline constexpr size_t kMaxAnswerParts = 32;   // that are kept
inline constexpr size_t kMaxAnswerBoxes = 8;    // of one part, on all pictures
inline constexpr size_t kAnswerPictures = 2;    // pictures of one question
inline constexpr size_t kMaxAnswerSources = 8;
inline constexpr size_t kMaxAlternatives = 6;

struct AnswerPart {
  std::string name;
  const MaterialRow* material = nullptr;  // row of the table
  double share = 0;                       // fraction of the mass; the parts' shares sum to 1
  std::optional<double> thickness_m;
  std::string inside;             // name of the part that encloses it; empty: none
  std::vector<PictureBox> boxes;  // where it is on the pictures; empty: not given
  // Votes of the kernels of the object for this part (picture_votes.h), by all answers; empty: none.
  std::vector<float> votes;
};

// One of several things that the object may be, such as a toy or the real thing.
struct MassAlternative {
  std::string name;
  double probability = 0;  // those of an answer sum to 1
  Span3 mass_kg;
};

struct Answer {
  std::string name, description, evidence;  // printable, truncated; for display only
  std::optional<double> name_confidence;
  std::optional<bool> replica;
  std::vector<std::string> kb_ids;                     // existing table rows that the answer cites
  v1::Physics::Fill fill = v1::Physics::FILL_UNKNOWN;  // FILL_UNKNOWN for an assembly
  v1::Physics::Behavior behavior = v1::Physics::RIGID;
  std::vector<AnswerPart> parts;              // largest share first; at least one
  Span3 mass_kg;                              // of the most probable alternative
  std::vector<MassAlternative> alternatives;  // empty if the answer is sure; else two or more
  std::optional<Span3> youngs_modulus_pa;
  std::optional<Span3> structure_coefficient;
  std::optional<double> plasticity;
  bool fragile = false;
  std::optional<double> friction, restitution;
  std::optional<double> longest_side_m;
  double confidence = 0.5;
  bool blind = false;                // given without pictures
  std::vector<std::string> changes;  // values that were interpreted or corrected, one line each
};

// Parses and checks the answer object in a text, also within prose or a fence. Checks: UTF-8, size, depth,
// types, enumerators, finite values, low <= best <= high, kMaxRangeRatio and the ranges above. The error is
// one line of prompts/complaints.json; it names the field and the correction for the model.
// Pure; accepts any bytes; any thread.
Result<Answer> read_answer(std::string_view text,
                           const MessageTemplates& words = MessageTemplates::built_in());

}  // namespace livegs
