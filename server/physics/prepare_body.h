// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/elastic_body.h"
#include "physics/world.h"

// Data that depend only on the form of a body, computed before it is added: in parallel, and once for bodies
// that are added again, as when a scene is reset. Bodies without it compute it when they are added, with the
// same result.

namespace livegs {

// Any thread. Nothing is computed for a description that World::add_rigid or World::add_elastic refuses.
void prepare_body(RigidBodyDescription& description);
void prepare_body(ElasticBodyDescription& description);

}  // namespace livegs
