// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "scenes/elastic_bodies.h"
#include "scenes/rigid_fixtures.h"

// Elastic bodies in a world, for tests of their contact with rigid bodies and with each other.

namespace livegs::soft_fixtures {

using namespace rigid_fixtures;
using Eigen::Vector3d;

// A block centred on the origin. `size_m` holds full edge lengths.
inline ElasticBodyDescription soft_block(uint32_t id, const Vector3d& size_m, double mass_kg,
                                         double youngs_modulus_pa, double spacing_m,
                                         double poisson_ratio = 0.3, double cell_width_m = 0.0) {
  ElasticBodyDescription description =
      test::describe(test::particle_grid(size_m, spacing_m), youngs_modulus_pa, poisson_ratio, cell_width_m);
  description.object_id = id;
  description.material.mass_kg = mass_kg;
  description.material.loss_factor = 0.3;
  description.material.friction = 0.6;
  description.material.restitution = 0.0;
  return description;
}

inline World world_with(ElasticBodyFactory solver, double rate_hz,
                        const Vector3d& gravity = {0, -kGravity, 0}, int substeps = 4) {
  WorldSettings settings;
  settings.substeps = substeps;
  settings.rate_hz = rate_hz;
  settings.gravity_m_s2 = gravity;
  settings.make_elastic = solver;
  return World(settings);
}

// Height of the lowest particle, m.
inline double lowest_m(const World& world, uint32_t id) {
  double low = 1e300;
  for (const ParticleState& p : world.elastic_body(id)->particles()) low = std::min(low, p.position_m.y());
  return low;
}

// Change of linear and angular momentum, each relative to its value at the start.
struct Drift {
  double linear, angular;
};
inline Drift momentum_drift(const BodyEnergy& before, const BodyEnergy& after) {
  return {(after.linear_momentum - before.linear_momentum).norm() / before.linear_momentum.norm(),
          (after.angular_momentum - before.angular_momentum).norm() / before.angular_momentum.norm()};
}
// The largest drift over the next `ticks` ticks.
inline Drift largest_drift(World& world, int ticks) {
  const BodyEnergy before = world.energy();
  Drift largest{0, 0};
  for (int i = 0; i < ticks; ++i) {
    world.step();
    const Drift drift = momentum_drift(before, world.energy());
    largest = {std::max(largest.linear, drift.linear), std::max(largest.angular, drift.angular)};
  }
  return largest;
}

}  // namespace livegs::soft_fixtures
