// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "physics/rigid/rigid_body.h"
#include "physics/rigid/rigid_broad_phase.h"

// Sleep of rigid bodies: speed, time and group. Elastic bodies: physics/elastic/elastic_sleep_timer.h.
// Islands of both kinds: World::State::sleep_islands and wake_islands in physics/world/world_coupling.cpp. A
// body that will be touched wakes in wake_on_contact (rigid_step.cpp).

namespace livegs {

// Sleep criterion: in contact and slower than this at three points for kLastingTime_s. The speed is for a
// size of 1 m (Jolt's value) and scales with the square root of size below, like speeds under gravity.
// Larger: bodies sleep earlier and may stop while moving visibly.
inline constexpr double kSleepSpeed_m_s = 0.03;
// The speed for the size of a shape. Contacts slower than this do not bounce (find_contacts.cpp).
double sleep_speed_m_s(const RigidShape& shape);

// Sleep test at the end of a tick. Touching bodies fall asleep together when all have been still for long
// enough; their remaining velocity is set to zero.
void update_sleep(std::span<RigidBody* const> bodies, double tick_s, RigidBroadPhase& broad_phase);

// Bodies that fell asleep together, or are joined, wake together. Returns whether any body woke.
bool wake_groups(std::span<RigidBody* const> bodies);

}  // namespace livegs
