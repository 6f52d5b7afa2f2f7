// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

#include "physics/rigid/rigid_body.h"

namespace livegs {

// Distance along the unit `direction` to the first front-facing surface of the body: its triangles, or the
// sphere of a ball. nullopt if the ray misses or starts inside a ball.
std::optional<double> ray_cast(const RigidBody& body, const Eigen::Vector3d& origin_m,
                               const Eigen::Vector3d& direction);

}  // namespace livegs
