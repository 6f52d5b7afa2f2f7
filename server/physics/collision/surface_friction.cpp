// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/surface_friction.h"

#include <algorithm>

namespace livegs {
namespace {

// Distance from a box at which a contact point still belongs to it, relative to the radius of the body.
constexpr double kBoxSlack = 0.01;

}  // namespace

double SurfaceFriction::at(const Eigen::Vector3d& rest_point_m, double body_radius_m) const {
  if (!boxes) return own;
  const double slack_m = kBoxSlack * body_radius_m;
  const auto found = std::find_if(boxes->rbegin(), boxes->rend(), [&](const FrictionBox& one) {
    return one.box.squaredExteriorDistance(rest_point_m) <= slack_m * slack_m;
  });
  return found == boxes->rend() ? own : std::min(found->factor * own, kMaxFriction);
}

}  // namespace livegs
