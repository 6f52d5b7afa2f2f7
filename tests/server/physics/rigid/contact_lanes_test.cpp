// SPDX-License-Identifier: Apache-2.0
// Sweeps over four contacts at a time, compared with one contact after the other.
#include "physics/rigid/contact/contact_lanes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/rigid_body.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

constexpr double kStep_s = 1.0 / 960.0;

// Bodies in a cloud with contacts between random pairs and with the world, as a heap has.
struct Heap {
  std::vector<std::unique_ptr<RigidBody>> bodies;
  RigidIsland island;

  Heap(int body_count, int contact_count, uint64_t seed) {
    std::mt19937_64 engine(seed);
    const auto draw = [&] { return static_cast<double>(engine() >> 11) * 0x1.0p-52 - 1.0; };  // -1 … 1
    const auto vector = [&] {
      const double x = draw(), y = draw(), z = draw();
      return Vector3d(x, y, z);
    };
    for (int i = 0; i < body_count; ++i) {
      auto body = std::make_unique<RigidBody>();
      body->mass_kg = 1.0 + 0.5 * draw();
      const Vector3d moments = Vector3d(2, 3, 4) + vector();
      body->set_unit_inertia(Eigen::Matrix3d((1e-3 * moments).asDiagonal()));
      body->world_from_body.position_m = 0.3 * vector();
      body->world_from_body.orientation = Eigen::AngleAxisd(3.0 * draw(), vector().normalized());
      body->velocity_m_s = vector();
      body->angular_momentum = 2e-3 * vector();
      body->update_turning();
      if (i % 7 == 6) body->sleep(1);
      bodies.push_back(std::move(body));
    }
    for (const auto& body : bodies) {
      if (!body->asleep) island.bodies.push_back(body.get());
    }
    struct Pair {
      RigidBody *owner, *other;
    };
    std::vector<Pair> pairs;
    for (int i = 0; i < contact_count; ++i) {
      const size_t a = engine() % bodies.size(), b = engine() % (bodies.size() + 1);
      RigidBody* other = b < bodies.size() && b != a ? bodies[b].get() : nullptr;
      if (bodies[a]->asleep && (!other || other->asleep)) continue;
      pairs.push_back({bodies[a].get(), other});
    }
    for (const auto& body : bodies) {
      body->manifolds.reserve(pairs.size());
      for (const Pair& pair : pairs) {
        if (pair.owner != body.get()) continue;
        ContactManifold manifold;
        manifold.other = pair.other;
        manifold.restitution_speed_m_s = 0.5;
        manifold.push_speed_m_s = 1.0;
        manifold.point_count = 1 + static_cast<int>(engine() % kMaxManifoldPoints);
        manifold.normal = vector().normalized();
        manifold.turns = engine() % 2;
        manifold.arm_body_m = 0.05 * vector();
        manifold.arm_a_m = body->world_from_body.orientation * manifold.arm_body_m;
        manifold.friction_impulse_n_s = 1e-3 * vector().cross(manifold.normal);
        manifold.twist_impulse = 1e-5 * draw();
        for (int p = 0; p < manifold.point_count; ++p) {
          ContactPoint& point = manifold.points[static_cast<size_t>(p)];
          point.normal = (manifold.normal + 0.1 * vector()).normalized();
          point.arm_body_m = 0.05 * vector();
          point.arm_a_m = body->world_from_body.orientation * point.arm_body_m;
          point.turns = manifold.turns;
          point.separation_m = 1e-4 * draw();
          point.impulse_n_s = 1e-3 * (1.0 + draw());
          point.friction = 0.5 + 0.4 * draw();
          point.friction_impulse_n_s = 2e-4 * vector().cross(manifold.normal);
        }
        body->manifolds.push_back(manifold);
      }
      for (ContactManifold& manifold : body->manifolds) island.contacts.push_back({body.get(), &manifold});
    }
  }
};

double speed_along(const RigidBody& a, const RigidBody* b, const ContactRow& row) {
  double speed = row.direction.dot(a.velocity_m_s) + row.lever_a.dot(a.angular_velocity_rad_s);
  if (b) speed -= row.direction.dot(b->velocity_m_s) + row.lever_b.dot(b->angular_velocity_rad_s);
  return speed;
}

void push(RigidBody& a, RigidBody* b, const ContactRow& row, double impulse) {
  const auto give = [&](RigidBody& body, double size, const Vector3d& lever) {
    if (body.asleep) return;
    body.velocity_m_s += size * body.inverse_mass * row.direction;
    body.apply_angular_impulse(size * lever);
  };
  give(a, impulse, row.lever_a);
  if (b) give(*b, -impulse, row.lever_b);
}

// One contact after the other: the definition that ContactLanes must match.
void warm_start(RigidBody& a, ContactManifold& manifold, const ManifoldRows& rows) {
  RigidBody* b = manifold.other;
  for (int p = 0; p < manifold.point_count; ++p)
    push(a, b, rows.points[static_cast<size_t>(p)], manifold.points[static_cast<size_t>(p)].impulse_n_s);
  push(a, b, rows.tangent, rows.tangent.direction.dot(manifold.friction_impulse_n_s));
  push(a, b, rows.bitangent, rows.bitangent.direction.dot(manifold.friction_impulse_n_s));
  a.apply_angular_impulse(manifold.twist_impulse * manifold.normal);
  if (b) b->apply_angular_impulse(-manifold.twist_impulse * manifold.normal);
}

void sweep(RigidBody& a, ContactManifold& manifold, ManifoldRows& rows, ContactPhase phase) {
  const ContactSoftness soft = contact_softness(kStep_s);
  solve_friction(a, manifold, rows);
  for (int p = 0; p < manifold.point_count; ++p) {
    ContactPoint& point = manifold.points[static_cast<size_t>(p)];
    const ContactRow& row = rows.points[static_cast<size_t>(p)];
    const double opening = speed_along(a, manifold.other, row);
    const Vector3d& w = a.angular_velocity_rad_s;
    const double separation =
        point.separation_m +
        (point.turns ? 0.5 * kStep_s * kStep_s * point.normal.dot(w.cross(w.cross(point.arm_a_m))) : 0.0);
    const double impact_m_s =
        impact_speed_m_s(manifold, closing_acceleration_m_s2(a, manifold, point), kStep_s);
    if (phase == ContactPhase::Relax && opening <= -manifold.restitution_speed_m_s && -opening >= impact_m_s)
      continue;
    double bias = 0.0, mass = row.mass_kg, softness = 0.0;
    if (separation > 0.0) {
      bias = separation / kStep_s;
    } else if (phase == ContactPhase::Push) {
      bias = std::max(soft.bias_rate * separation, -manifold.push_speed_m_s);
      mass *= soft.mass_scale;
      softness = soft.impulse_scale;
    }
    const double impulse =
        std::max(0.0, point.impulse_n_s - mass * (opening + bias) - softness * point.impulse_n_s);
    push(a, manifold.other, row, impulse - point.impulse_n_s);
    point.impulse_n_s = impulse;
  }
}

TEST(ContactLanes, GiveTheResultOfOneContactAfterTheOther) {
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Heap lanes(3 + static_cast<int>(seed), 4 * static_cast<int>(seed), seed);
    Heap single(3 + static_cast<int>(seed), 4 * static_cast<int>(seed), seed);
    ContactLanes contacts(lanes.island, kStep_s);
    contacts.load_poses();
    contacts.load_motion();
    contacts.prepare();
    contacts.warm_start();
    contacts.sweep(ContactPhase::Push);
    for (int i = 0; i < 2; ++i) contacts.sweep(ContactPhase::Relax);
    contacts.store_motion();
    contacts.store_points();
    contacts.store_friction();

    std::vector<ManifoldRows> rows;
    for (const RigidIsland::Contact& contact : single.island.contacts)
      rows.push_back(prepare_rows(*contact.owner, *contact.manifold));
    const auto each = [&](const auto& visit) {
      for (size_t i = 0; i < rows.size(); ++i)
        visit(*single.island.contacts[i].owner, *single.island.contacts[i].manifold, rows[i]);
    };
    each(warm_start);
    for (const ContactPhase phase : {ContactPhase::Push, ContactPhase::Relax, ContactPhase::Relax}) {
      each([&](RigidBody& a, ContactManifold& manifold, ManifoldRows& row) {
        sweep(a, manifold, row, phase);
      });
    }
    each([](RigidBody&, ContactManifold& manifold, const ManifoldRows& row) {
      store_friction(manifold, row);
    });

    // Sums are rounded in another order; velocities are about 1 m/s, impulses about 1e-2 N s.
    for (size_t i = 0; i < lanes.bodies.size(); ++i) {
      const RigidBody &a = *lanes.bodies[i], &b = *single.bodies[i];
      EXPECT_LT((a.velocity_m_s - b.velocity_m_s).norm(), 1e-12);
      EXPECT_LT((a.angular_velocity_rad_s - b.angular_velocity_rad_s).norm(), 1e-10);
      EXPECT_LT((a.angular_momentum - b.angular_momentum).norm(), 1e-14);
    }
    for (size_t i = 0; i < lanes.island.contacts.size(); ++i) {
      const ContactManifold &a = *lanes.island.contacts[i].manifold, &b = *single.island.contacts[i].manifold;
      for (size_t p = 0; p < static_cast<size_t>(a.point_count); ++p)
        EXPECT_NEAR(a.points[p].impulse_n_s, b.points[p].impulse_n_s, 1e-13);
      for (size_t p = 0; p < static_cast<size_t>(a.point_count); ++p) {
        EXPECT_LT((a.points[p].friction_impulse_n_s - b.points[p].friction_impulse_n_s).norm(), 1e-13);
      }
      EXPECT_LT((a.friction_impulse_n_s - b.friction_impulse_n_s).norm(), 1e-13);
      EXPECT_NEAR(a.twist_impulse, b.twist_impulse, 1e-14);
    }
  }
}

TEST(ContactLanes, FindImpactsThatTheSolverOfImpactsFinds) {
  int with = 0, without = 0;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    Heap heap(3, 1 + static_cast<int>(seed % 3), seed);
    for (auto& body : heap.bodies) {
      body->velocity_m_s *= 0.6;
      body->angular_momentum *= 0.1;
      body->update_turning();
    }
    ContactLanes contacts(heap.island, kStep_s);
    contacts.load_poses();
    contacts.load_motion();
    contacts.prepare();
    bool expected = false;
    for (const RigidIsland::Contact& contact : heap.island.contacts) {
      prepare_rows(*contact.owner, *contact.manifold);  // for the arms
      expected |= begin_impact(*contact.owner, *contact.manifold, kStep_s, 0.0) > 0.0;
    }
    EXPECT_EQ(contacts.any_impact(), expected);
    ++(expected ? with : without);
  }
  EXPECT_GT(with, 20);
  EXPECT_GT(without, 20);
}

}  // namespace
}  // namespace livegs
