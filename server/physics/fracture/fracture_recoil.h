// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "physics/rigid/rigid_body.h"

// What drives fragments apart. An impact strains a body before it breaks it; when a face gives way, both of
// its sides spring back, away from the crack. Every face gives way at the strength of the material, and a
// free surface under the stress s springs back at s / (rho c) (Kolsky 1953, Stress waves in solids), the same
// for all: the impulse over a face goes with its area. How large it is follows from the energy: a part of
// what the impact took from the motion.

namespace livegs {

// Of the energy that an impact takes, the part that fragments fly apart with. Chosen, not measured: without
// it the sherds of a cup dropped upright from four times its break height stand as high as it did; with it,
// half as high.
inline constexpr double kRecoilEnergyFraction = 0.1;

// A face that gave way, as it is in the world: between two bodies, by their numbers in the list.
struct OpenedFace {
  size_t first = 0, second = 0;
  double area_m2 = 0.0;
  Eigen::Vector3d centroid_m;
  Eigen::Vector3d normal;  // unit, from first to second
};

// What an impact of `impulse_n_s` (axes of the body) takes from the motion until it has given `borne` (0 … 1)
// of itself, J. Both it and the approach it ended are along its direction, at `arm_m` from the centre of
// mass.
double impact_energy_loss_j(const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
                            const Eigen::Vector3d& arm_m, double borne, double restitution);

// Drives the bodies apart with this kinetic energy, relative to the rigid motion they share. Momentum is
// kept: the two sides of a face get opposite impulses at the same point. Precondition: awake, and moving as
// one rigid body.
void recoil(std::span<RigidBody* const> bodies, std::span<const OpenedFace> faces, double energy_j);

}  // namespace livegs
