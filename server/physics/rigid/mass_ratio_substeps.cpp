// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/mass_ratio_substeps.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

constexpr double kMaxMassRatio = 12.5;  // mass ratio that the default steps support without visible sag
// Maximum factor on solver steps. Larger: less sag at high mass ratios, more time.
constexpr int kMaxStepFactor = 4;
constexpr int kMaxManifoldSteps = 256;  // manifolds times the factor
// Minimum cosine between a supporting normal and the vertical.
constexpr double kSupportCosine = 0.5;

}  // namespace

int mass_ratio_substeps(const RigidIsland& island, const Eigen::Vector3d& gravity_m_s2) {
  const double upwards = kSupportCosine * gravity_m_s2.norm();
  double ratio = 0.0;
  for (const RigidIsland::Contact& contact : island.contacts) {
    const RigidBody &owner = *contact.owner, *other = contact.manifold->other;
    if (owner.joints || (other && other->joints)) return 1;
    if (!other || other->asleep || owner.asleep) continue;
    const double up = -contact.manifold->normal.dot(gravity_m_s2);  // the normal points towards the owner
    if (std::abs(up) <= upwards) continue;
    ratio = std::max(ratio, up > 0.0 ? owner.mass_kg / other->mass_kg : other->mass_kg / owner.mass_kg);
  }
  const int times = static_cast<int>(
      std::clamp(std::ceil(std::sqrt(ratio / kMaxMassRatio)), 1.0, static_cast<double>(kMaxStepFactor)));
  return std::clamp(kMaxManifoldSteps / static_cast<int>(std::max<size_t>(1, island.contacts.size())), 1,
                    times);
}

}  // namespace livegs
