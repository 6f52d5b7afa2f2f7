// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/estimate/log_normal.h"
#include "analysis/estimate/mass_model.h"
#include "analysis/estimate/object_classes.h"

namespace livegs {

// The mass of an object of one kind, ln kilograms, from two looks: what such things weigh at this size, and
// density times what the surface encloses, or times its wall.
struct ClassMass {
  LogNormal mass;
  double usual_kg = 0;    // the first look alone
  double physics_kg = 0;  // the second look alone
  // Its factors: a density and an area of wall, or, where the wall is 0, a volume.
  double density_kg_m3 = 0, wall_m = 0, extent = 0;
};
ClassMass kind_mass(const ObjectClass& kind, const ObjectFacts& facts);

// Over all kinds the object may be: best is the mean in the logarithm, low and high hold nine of ten.
MassEstimate mass_of_classes(const ObjectClasses& kinds, const ObjectFacts& facts);

}  // namespace livegs
