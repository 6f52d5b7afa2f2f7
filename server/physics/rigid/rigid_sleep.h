// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "physics/rigid/rigid_body.h"
#include "physics/rigid/rigid_broad_phase.h"

// Sleep of rigid bodies. Elastic bodies: physics/elastic/elastic_sleep_timer.h.

namespace livegs {

// Sleep test at the end of a tick. Touching bodies fall asleep together when all have been still for long
// enough; their remaining velocity is set to zero.
void update_sleep(std::span<RigidBody* const> bodies, double tick_s, RigidBroadPhase& broad_phase);

// Bodies that fell asleep together, or are joined, wake together. Returns whether any body woke.
bool wake_groups(std::span<RigidBody* const> bodies);

}  // namespace livegs
