// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/knowledge/name_match.h"
#include "analysis/knowledge/tables.h"

// What kinds of things an object may be, each with a probability: from its name, and where that leaves
// several (a mug may be of stoneware or of enamelled steel) or none, from its size, its shape and last its
// colours.

namespace livegs {

struct ObjectClass {
  const ObjectRow* row = nullptr;
  double probability = 0;
  const MaterialRow* material = nullptr;  // told outright by the name and not the row's own; null otherwise
};

struct ObjectClasses {
  std::vector<ObjectClass>
      kinds;               // most probable first, of equal ones the table's first; probabilities sum to 1
  NameMatch match;         // of the name; its row is null when the name says nothing
  MaterialMatch material;  // that the name tells
};

// Never empty. Pure.
ObjectClasses object_classes(const ObjectFacts& facts);

// How well the facts fit a kind: a density over sizes and proportions, times factors for openness, wall, how
// much of its box is filled, and, as a tie-break, how its class of materials looks. Comparable between rows
// for the same facts.
double kind_likelihood(const ObjectRow& row, const ObjectFacts& facts);

// The edges of the smallest box around the object, longest first; those along its axes where only they are
// known.
Eigen::Vector3d sorted_box_m(const MeshFacts& mesh);
// The thinnest mean wall, 2 V / A, that LIVE-GS's alpha shape draws of a thing of this size, whatever it
// really is: 0.03 of the diagonal, its radius.
double min_drawn_wall_m(const MeshFacts& mesh);

}  // namespace livegs
