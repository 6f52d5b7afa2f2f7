// SPDX-License-Identifier: Apache-2.0
#include "physics/fracture/fracture_recoil.h"

#include <gtest/gtest.h>

#include <array>

namespace livegs {
namespace {

using Eigen::Vector3d;

// A box of 0.1 x 0.2 x 0.3 m centred at `at`. It is part of a body that moves with `velocity` at the origin
// and rotates with `spin`.
RigidBody part_at(const Vector3d& at, double mass_kg, const Vector3d& velocity, const Vector3d& spin) {
  RigidBody body;
  body.mass_kg = mass_kg;
  body.set_unit_inertia(Vector3d(0.13, 0.10, 0.05).asDiagonal() * (1.0 / 12.0));
  body.world_from_body.position_m = at;
  body.velocity_m_s = velocity + spin.cross(at);
  body.set_angular_velocity(spin);
  return body;
}

TEST(FractureRecoil, RecoilAddsTheGivenEnergyAndNoMomentum) {
  const Vector3d velocity(1, -4, 0.5), spin(3, 2, -5);
  std::array<RigidBody, 3> parts{part_at({0, 0, 0}, 0.2, velocity, spin),
                                 part_at({0.1, 0, 0}, 0.05, velocity, spin),
                                 part_at({0.05, 0.2, 0.02}, 0.4, velocity, spin)};
  std::array<RigidBody*, 3> bodies{&parts[0], &parts[1], &parts[2]};
  const std::vector<OpenedFace> faces{{0, 1, 2e-3, {0.05, 0.01, 0.02}, {1, 0, 0}},
                                      {1, 2, 1e-3, {0.08, 0.1, 0.0}, Vector3d(0.1, 1, 0).normalized()},
                                      {0, 2, 3e-3, {0.02, 0.1, 0.0}, {0, 1, 0}}};
  double kinetic_j[2] = {};
  Vector3d linear[2] = {Vector3d::Zero(), Vector3d::Zero()},
           angular[2] = {Vector3d::Zero(), Vector3d::Zero()};
  for (const int then : {0, 1}) {
    if (then == 1) recoil(bodies, faces, 0.7);
    for (const RigidBody& part : parts) {
      const Vector3d momentum = part.mass_kg * part.velocity_m_s;
      kinetic_j[then] += part.kinetic_j();
      linear[then] += momentum;
      angular[then] += part.world_from_body.position_m.cross(momentum) + part.angular_momentum;
    }
  }
  EXPECT_NEAR(kinetic_j[1] - kinetic_j[0], 0.7, 1e-12);
  EXPECT_LT((linear[1] - linear[0]).norm(), 1e-14);
  EXPECT_LT((angular[1] - angular[0]).norm(), 1e-14);
  EXPECT_LT(parts[0].velocity_m_s.x(), velocity.x()) << "the part does not move away from the crack";
}

TEST(FractureRecoil, NoFaceOrNoEnergyMeansNoRecoil) {
  std::array<RigidBody, 2> parts{part_at({0, 0, 0}, 0.2, {1, 0, 0}, {0, 0, 0}),
                                 part_at({0.1, 0, 0}, 0.1, {1, 0, 0}, {0, 0, 0})};
  std::array<RigidBody*, 2> bodies{&parts[0], &parts[1]};
  recoil(bodies, {}, 1.0);
  const std::vector<OpenedFace> faces{{0, 1, 2e-3, {0.05, 0, 0}, {1, 0, 0}}};
  recoil(bodies, faces, 0.0);
  for (const RigidBody& part : parts) EXPECT_EQ(part.velocity_m_s, Vector3d(1, 0, 0));
}

// A fall at v onto a hard floor gives J = m v (1 + e) and dissipates m v² (1 - e²) / 2 in total. Up to a
// fraction x of J it dissipates v x J - (x J)² / (2 m).
TEST(FractureRecoil, ImpactDissipatesTheEnergyOfTheFall) {
  const RigidBody body = part_at({0, 0, 0}, 0.3, Vector3d::Zero(), Vector3d::Zero());
  const double speed = 4.0;
  for (const double restitution : {0.0, 0.2, 1.0}) {
    const Vector3d impulse(0, 0.3 * speed * (1 + restitution), 0);
    EXPECT_NEAR(impact_energy_loss_j(body, impulse, Vector3d::Zero(), 1.0, restitution),
                0.5 * 0.3 * speed * speed * (1 - restitution * restitution), 1e-12);
    const double part = 0.25 * impulse.y();
    EXPECT_NEAR(impact_energy_loss_j(body, impulse, Vector3d::Zero(), 0.25, restitution),
                speed * part - part * part / 0.6, 1e-12);
  }
}

}  // namespace
}  // namespace livegs
