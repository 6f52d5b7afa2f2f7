// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "core/result.h"
#include "physics/collider.h"

namespace livegs {

// The collider of a captured background. As of any capture it is what a ball cannot reach from outside, so a
// closed room is filled. Where `stuck` finds things in it (their centres, in the frame of the points), the
// room is cut level, above one of them and where there is least to cut, into an upper and a lower part that
// overlap by the ball's radius: the ball gets into each, and together they are the room with its walls,
// floor, ceiling and what stands on them. A cut that sets nothing free is not made; four are tried. `up` is a
// unit, in that frame too.
using EmbeddedObjects = std::function<std::vector<Eigen::Vector3d>(const FieldShape&)>;
Result<FieldShape> interior_collider(std::span<const Eigen::Vector3d> points_m, const Eigen::Vector3d& up,
                                     const EmbeddedObjects& stuck);

}  // namespace livegs
