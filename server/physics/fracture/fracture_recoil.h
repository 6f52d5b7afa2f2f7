// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "physics/rigid/rigid_body.h"

// Elastic recoil of fragments: at fracture both sides of a strained crack spring back. A free surface
// released from the stress s, the strength of the material, recoils at s / (rho c) (Kolsky 1953, Stress waves
// in solids), so the impulse on a face is proportional to its area. Its magnitude follows from the energy.

namespace livegs {

// Fraction of the impact's energy loss that becomes kinetic energy of fragments. Chosen, not measured. 0:
// fragments stay in place; larger: they fly farther.
inline constexpr double kRecoilEnergyFraction = 0.1;

// A face that broke, in world coordinates, between two bodies given by their indices in the list.
struct OpenedFace {
  size_t first = 0, second = 0;
  double area_m2 = 0.0;
  Eigen::Vector3d centroid_m;
  Eigen::Vector3d normal;  // unit, from first to second
};

// Energy lost, in joules, when an impact of `impulse_n_s` (body axes) has transferred the fraction `borne` (0
// … 1) of its impulse. The impulse and the closing velocity are parallel, at `arm_m` from the centre of mass.
double impact_energy_loss_j(const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
                            const Eigen::Vector3d& arm_m, double borne, double restitution);

// Adds this kinetic energy to the motion of the bodies relative to their common rigid motion. Momentum is
// conserved: both sides of a face receive opposite impulses at the same point. Precondition: the bodies are
// awake and move as one rigid body.
void recoil(std::span<RigidBody* const> bodies, std::span<const OpenedFace> faces, double energy_j);

}  // namespace livegs
