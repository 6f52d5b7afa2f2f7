// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "physics/elastic_body.h"

namespace livegs {

struct SteppedBody {
  ElasticBody* body;
  SubstepContext context;
  int steps = 0;  // it asked for
};

// One substep of elastic bodies that may touch each other, all neighbours of any of them included, in the
// order given. They take as many steps as the one among them that needs most, side by side: elasticity, then
// contact of all at once, so that neither pushes a body that has gone on already or has yet to start. One
// thread.
void step_elastic_bodies(std::span<SteppedBody> bodies);

}  // namespace livegs
