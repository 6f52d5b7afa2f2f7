// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/estimate/log_normal.h"
#include "analysis/estimate/mass_model.h"
#include "analysis/estimate/object_classes.h"

namespace livegs {

// Mass of an object of one class, in ln kilograms, from two estimates: the usual mass of such objects at this
// size, and density times the enclosed volume or the wall volume.
struct ClassMass {
  LogNormal mass;
  double usual_kg = 0;    // the first estimate alone
  double physics_kg = 0;  // the second estimate alone
  double physics_sd = 0;  // standard deviation of its logarithm
  // Factors of the second estimate: density and wall area, or, if the wall is 0, volume.
  double density_kg_m3 = 0, wall_m = 0, extent = 0;
};
ClassMass kind_mass(const ObjectClass& kind, const ObjectFacts& facts);

// Mass over all classes the object may have. Best is the mean of the logarithm; low and high enclose 90 %.
MassEstimate mass_of_classes(const ObjectClasses& kinds, const ObjectFacts& facts);

}  // namespace livegs
