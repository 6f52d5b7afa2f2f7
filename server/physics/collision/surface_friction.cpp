// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/surface_friction.h"

#include <algorithm>

namespace livegs {

double SurfaceFriction::at(const Eigen::Vector3d& rest_point_m, double body_radius_m) const {
  if (!boxes) return own;
  const double slack_m = 0.01 * body_radius_m;  // a contact point that far outside a box still belongs to it
  const auto found = std::find_if(boxes->rbegin(), boxes->rend(), [&](const FrictionBox& one) {
    return one.box.squaredExteriorDistance(rest_point_m) <= slack_m * slack_m;
  });
  return found == boxes->rend() ? own : std::min(found->factor * own, kMaxFriction);
}

}  // namespace livegs
