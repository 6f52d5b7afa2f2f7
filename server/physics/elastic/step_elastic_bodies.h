// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "physics/elastic_body.h"

namespace livegs {

struct SteppedBody {
  ElasticBody* body;
  SubstepContext context;
  // The contacts that the body lists; only the capacity is kept between calls.
  std::vector<ContactConstraint>* rows = nullptr;
  int steps = 0;  // requested by the body
};

// One substep of elastic bodies that may touch each other, including all their neighbours, in the given
// order. All bodies take the largest number of steps that any of them needs. In each step elasticity of all
// bodies precedes contact of all bodies, so that every contact sees both bodies at the same time. Bodies step
// and their contacts are listed and swept on several threads; the result does not depend on their number.
void step_elastic_bodies(std::span<SteppedBody> bodies);

}  // namespace livegs
