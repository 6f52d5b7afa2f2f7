// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/knowledge/name_match.h"
#include "analysis/knowledge/tables.h"

// Classes an object may have, each with a probability. The name comes first; if it leaves several classes (a
// mug may be stoneware or enamelled steel) or none, then size, shape and finally colour decide.

namespace livegs {

struct ObjectClass {
  const ObjectRow* row = nullptr;
  double probability = 0;
  // Stated by the name and different from the row's own; null otherwise.
  const MaterialRow* material = nullptr;
};

struct ObjectClasses {
  std::vector<ObjectClass> kinds;  // most probable first, ties in table order; probabilities sum to 1
  NameMatch match;                 // of the name; its row is null if the name is unknown
  MaterialMatch material;          // stated by the name
};

// Never empty. Pure.
ObjectClasses object_classes(const ObjectFacts& facts);

// Likelihood of the facts for a class: a density over sizes and proportions, times factors for openness,
// wall, box filling and, as a tie-break, the appearance of its materials. Comparable between rows for the
// same facts.
double kind_likelihood(const ObjectRow& row, const ObjectFacts& facts);

// Edges of the smallest box around the object, longest first; of its axis-aligned box if only that is known.
Eigen::Vector3d sorted_box_m(const MeshFacts& mesh);
// Smallest mean wall, 2 V / A, that LIVE-GS's alpha shape can represent at this size: 0.03 of the diagonal,
// its radius.
double min_drawn_wall_m(const MeshFacts& mesh);

}  // namespace livegs
