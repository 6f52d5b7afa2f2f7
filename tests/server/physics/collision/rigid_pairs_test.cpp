// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "core/parallel_for.h"
#include "geometry/mesh/convex_hull.h"
#include "known_gaps.h"
#include "physics/collision/contact_candidate.h"
#include "physics/collision/convex_polyhedron.h"
#include "scenes/rigid_fixtures.h"

// Contact between rigid meshes.

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

RigidBodyDescription box_at(uint32_t id, const Vector3d& size_m, double mass_kg, const Vector3d& position_m) {
  auto box = box_body(id, size_m, mass_kg);
  box.material.friction = 0.6;
  box.world_from_object.position_m = position_m;
  return box;
}

TriangleMesh random_hull(uint32_t seed, double size_m, int points = 14) {
  std::mt19937 random(seed);
  std::vector<Vector3d> cloud;
  for (int i = 0; i < points; ++i) {
    Vector3d p;
    for (int d = 0; d < 3; ++d) p[d] = static_cast<double>(random()) / 4294967296.0 - 0.5;
    cloud.push_back(0.5 * size_m * p.normalized());
  }
  return convex_hull(cloud);
}

// A bar with a notch, which is not convex.
TriangleMesh notched_mesh() {
  TriangleMesh mesh;
  const double outline[8][2] = {{-0.1, -0.03}, {0.1, -0.03}, {0.1, 0.03},   {0.03, 0.03},
                                {0.03, 0.0},   {-0.03, 0.0}, {-0.03, 0.03}, {-0.1, 0.03}};
  for (const double z : {-0.03, 0.03}) {
    for (const auto& p : outline) mesh.vertices_m.push_back({p[0], p[1], z});
  }
  const std::array<uint32_t, 3> front[6] = {{0, 1, 4}, {1, 2, 3}, {1, 3, 4}, {0, 4, 5}, {0, 5, 6}, {0, 6, 7}};
  for (const auto& t : front) {
    mesh.triangles.push_back({t[2], t[1], t[0]});
    mesh.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  }
  for (uint32_t i = 0; i < 8; ++i) {
    const uint32_t k = (i + 1) % 8;
    mesh.triangles.push_back({i, k, k + 8});
    mesh.triangles.push_back({i, k + 8, i + 8});
  }
  return mesh;
}

TEST(ConvexPolyhedron, BoxHasItsFacesEdgesAndExactDistance) {
  const auto box = convex_polyhedron(box_mesh({0.2, 0.1, 0.4}));
  ASSERT_TRUE(box);
  EXPECT_EQ(box->vertices_m.size(), 8u);
  EXPECT_EQ(box->faces.size(), 6u);
  EXPECT_EQ(box->edges.size(), 12u);
  EXPECT_NEAR(box->inner_radius_m, 0.05, 1e-15);
  EXPECT_NEAR(box->sample({0.01, 0.02, 0.03}).distance_m, -0.03, 1e-15);
  EXPECT_NEAR(box->sample({0.13, 0.09, 0}).distance_m, 0.05, 1e-15);     // 3-4-5 beyond an edge
  EXPECT_NEAR(box->sample({0.11, 0.07, 0.22}).distance_m, 0.03, 1e-15);  // 1-2-2 beyond a corner
  EXPECT_LT((box->sample({0.11, 0.07, 0.22}).normal - Vector3d(1, 2, 2) / 3).norm(), 1e-12);
  EXPECT_FALSE(convex_polyhedron(notched_mesh()));
}

TEST(ConvexPolyhedron, EulersFormulaHoldsForHulls) {
  for (uint32_t seed = 1; seed < 30; ++seed) {
    const auto hull = convex_polyhedron(random_hull(seed, 0.1));
    ASSERT_TRUE(hull) << seed;
    EXPECT_EQ(hull->vertices_m.size() + hull->faces.size(), hull->edges.size() + 2) << seed;
  }
}

ContactCandidate only(const std::vector<ContactCandidate>& found) {
  EXPECT_EQ(found.size(), 1u);
  return found.empty() ? ContactCandidate{} : found[0];
}

TEST(PolyhedronContacts, CrossedEdgesMeetInOnePoint) {
  const ConvexPolyhedron box = box_polyhedron({0.1, 0.1, 0.1});
  // Both boxes rest on an edge, one along x and one along z. The edges cross above the origin.
  const Eigen::Matrix3d about_x = Eigen::AngleAxisd(radians(45), Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Matrix3d about_z = Eigen::AngleAxisd(radians(45), Vector3d::UnitZ()).toRotationMatrix();
  const double half = 0.05 * std::sqrt(2.0), depth = 0.001;
  std::vector<ContactCandidate> found;
  polyhedron_contacts({&box, about_x, {0.01, half - depth, 0}}, {&box, about_z, {0, -half, 0.02}}, 0.001,
                      1e-5, found);
  const ContactCandidate contact = only(found);
  EXPECT_NEAR(contact.separation_m, -depth, 1e-12);
  EXPECT_LT((contact.normal - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((contact.point_m - Vector3d(0, -0.5 * depth, 0)).norm(), 1e-12);
}

TEST(PolyhedronContacts, FlatFacesMeetInTheCornersOfTheirOverlap) {
  const ConvexPolyhedron box = box_polyhedron({0.1, 0.1, 0.1});
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(radians(45), Vector3d::UnitY()).toRotationMatrix();
  std::vector<ContactCandidate> found;
  polyhedron_contacts({&box, turned, {0, 0.099, 0}}, {&box, Eigen::Matrix3d::Identity(), {0, 0, 0}}, 0.001,
                      1e-5, found);
  EXPECT_EQ(found.size(), 8u);  // an octagon
  for (const ContactCandidate& contact : found) {
    EXPECT_NEAR(contact.separation_m, -0.001, 1e-12);
    EXPECT_LT((contact.normal - Vector3d::UnitY()).norm(), 1e-12);
    EXPECT_NEAR(std::max(std::abs(contact.point_m.x()), std::abs(contact.point_m.z())), 0.05, 1e-12);
  }
}

TEST(RigidPairs, FreeCollisionsConserveMomentumAndLoseEnergy) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    for (int seed = 0; seed < 12; ++seed) {
      World world = world_at(rate, 4, Vector3d::Zero());
      auto one =
          seed % 3 == 0 ? body_of(1, notched_mesh(), 0.7) : body_of(1, random_hull(10 + seed, 0.2), 0.7);
      one.world_from_object.orientation = rotation_about(seed);
      one.angular_velocity_rad_s = {3, -4, 1.0 * seed};
      ASSERT_TRUE(world.add_rigid(one));
      auto two = seed % 2 ? body_of(2, box_mesh({0.1, 0.15, 0.2}), 0.3)
                          : body_of(2, random_hull(90 + seed, 0.15), 0.3);
      two.world_from_object.position_m = {0.5, 0.01 * seed, -0.02};
      two.world_from_object.orientation = rotation_about(seed + 5);
      two.velocity_m_s = {-4, 0, 0};
      two.angular_velocity_rad_s = {0, 5, -7};
      two.material.restitution = 0.3;
      ASSERT_TRUE(world.add_rigid(two));
      const BodyEnergy before = world.energy();
      run_seconds(world, 0.6);
      const BodyEnergy after = world.energy();
      EXPECT_GT((body_state(world, 2).velocity_m_s - two.velocity_m_s).norm(), 0.1)
          << seed << ": no collision";
      // Impulses are equal and opposite at one point, so only rounding is left.
      EXPECT_LT((after.linear_momentum - before.linear_momentum).norm(), 1e-12) << seed;
      EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 1e-11) << seed;
      EXPECT_LE(after.kinetic_j, before.kinetic_j * (1.0 + 1e-6)) << seed;
    }
  }
}

// A square bar of 0.4 m on its edge, along x. With necks at its ends, far from its middle, it is not convex.
TriangleMesh bar_on_its_edge(bool necks) {
  const double half = 0.02 * std::sqrt(2.0);
  std::vector<std::pair<double, double>> rings{{-0.2, half}};  // x and half the diagonal, m
  if (necks) {
    for (const double end : {-1.0, 1.0}) {
      const double from = end < 0 ? -0.17 : 0.13, to = from + 0.04;
      rings.insert(rings.end(), {{from, half}, {from, 0.5 * half}, {to, 0.5 * half}, {to, half}});
    }
  }
  rings.push_back({0.2, half});
  TriangleMesh mesh;
  for (const auto& [x, r] : rings) {
    for (const auto& [y, z] : {std::pair{-r, 0.0}, {0.0, r}, {r, 0.0}, {0.0, -r}})
      mesh.vertices_m.push_back({x, y, z});
  }
  const auto last = static_cast<uint32_t>(mesh.vertices_m.size() - 4);
  for (uint32_t ring = 0; ring < last; ring += 4) {
    for (uint32_t i = 0; i < 4; ++i) {
      const uint32_t a = ring + i, b = ring + (i + 1) % 4;
      mesh.triangles.push_back({a, a + 4, b + 4});
      mesh.triangles.push_back({a, b + 4, b});
    }
  }
  mesh.triangles.push_back({0, 1, 2});
  mesh.triangles.push_back({0, 2, 3});
  mesh.triangles.push_back({last, last + 2, last + 1});
  mesh.triangles.push_back({last, last + 3, last + 2});
  return mesh;
}

TEST(RigidPairs, BarOnItsEdgeRestsAcrossAnEdge) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    // Two square bars on their edges, crosswise: only the edges touch. Neither may sink into the other while
    // balanced.
    for (const bool convex : {true, false}) {
      World world = world_at(rate, 4, {0, -kGravity, 0});
      const double half = 0.02 * std::sqrt(2.0);
      world.add_collider(Collider{
          BoxShape{{0.04, 0.04, 0.4}},
          Pose{{0, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(radians(45), Vector3d::UnitZ()))}, 0.8, 0.0});
      const TriangleMesh bar = bar_on_its_edge(!convex);
      ASSERT_EQ(convex_polyhedron(bar).has_value(), convex);
      auto body = body_of(1, bar, 0.5);
      body.material.friction = 0.8;
      body.world_from_object.position_m = {0, 2.0 * half, 0.013};
      ASSERT_TRUE(world.add_rigid(body));
      run_seconds(world, 0.25);
      const double y = body_state(world, 1).world_from_body.position_m.y();
      // Balanced to 1e-3 degrees, the bar tips by less than 1 mm in this time. Without edge contact it falls
      // 0.3 m. The edge of a bar that is not convex is sampled at its points only, so it sinks between two of
      // them by half their distance.
      if (convex) {
        EXPECT_NEAR(y, 2.0 * half, 1e-3);
      } else {
        report_gap("pairs.edge_sinks", std::abs(y - 2.0 * half) / 0.4);
        EXPECT_NEAR(y, 2.0 * half, 0.5 * half);
      }
    }
  }
}

TEST(RigidPairs, NonConvexMeshesRestOnEachOther) {
  World world = world_at(60, 4);
  world.add_collider(floor_plane(0.6));
  auto lower = body_of(1, notched_mesh(), 0.8);
  lower.world_from_object.position_m = {0, 0.031, 0};
  ASSERT_TRUE(world.add_rigid(lower));
  ASSERT_TRUE(world.add_rigid(box_at(2, {0.05, 0.05, 0.05}, 0.1, {0, 0.06, 0})));  // falls into the notch
  auto upper = body_of(3, notched_mesh(), 0.8);
  upper.world_from_object.position_m = {0.005, 0.113, 0};
  upper.world_from_object.orientation = Eigen::AngleAxisd(radians(90), Vector3d::UnitY());
  ASSERT_TRUE(world.add_rigid(upper));
  run_seconds(world, 4.0);
  // The notch floor is 0.03 m above the bottom.
  EXPECT_NEAR(body_state(world, 2).world_from_body.position_m.y(), 0.03 + 0.025, 1e-3);
  // The bar rests on the box, which protrudes from the notch. The notch lowers its centre of mass by 2.65 mm.
  EXPECT_NEAR(body_state(world, 3).world_from_body.position_m.y(), 0.08 + 0.03 - 0.00265, 1e-3);
  for (uint32_t id : {1u, 2u, 3u}) EXPECT_TRUE(body_state(world, id).asleep) << id;
}

// Throws a body of 0.1 kg from 0.6 m above a free square plate of 1 m and 5 kg, rotated and spinning by its
// number. Returns whether the body passed the plate within `ticks` ticks.
bool passes_plate(double rate, double thickness_m, const Vector3d& size_m, int aim,
                  const Vector3d& velocity_m_s, double spin_rad_s, int ticks) {
  World world = world_at(rate, 4, Vector3d::Zero());
  EXPECT_TRUE(world.add_rigid(box_at(1, {1.0, 1.0, thickness_m}, 5.0, {0, 0, 0})));
  auto thing = box_at(2, size_m, 0.1, {0, 0, 0.6});
  thing.world_from_object.orientation = rotation_about(aim);
  thing.velocity_m_s = velocity_m_s;
  thing.angular_velocity_rad_s =
      spin_rad_s * Vector3d(std::sin(2.0 * aim), std::cos(3.0 * aim), std::sin(5.0 * aim));
  EXPECT_TRUE(world.add_rigid(thing));
  for (int i = 0; i < ticks; ++i) {
    world.step();
    const Vector3d seen =
        body_state(world, 1).world_from_body.inverse() * body_state(world, 2).world_from_body.position_m;
    if (std::abs(seen.x()) < 0.5 && std::abs(seen.y()) < 0.5 && seen.z() < 0.0) return true;
  }
  return false;
}

TEST(RigidPairs, FastBoxesAndRodsDoNotPassAThinPlate) {
  int passed = 0;
  for (const double rate : kRates_hz)
    for (int aim = 0; aim < 60; ++aim) {
      const Vector3d size = aim % 2 ? Vector3d(0.3, 0.02, 0.02) : Vector3d(0.08, 0.05, 0.06);
      passed +=
          passes_plate(rate, 0.01, size, aim, {0.3 * std::sin(aim), 0.3 * std::cos(aim), -1.0 - 1.6 * aim},
                       40.0, static_cast<int>(0.75 * rate));
    }
  EXPECT_EQ(passed, 0);
}

// A card or rod stopped at one corner turns about it, and its other end speeds up within the substep. Such
// pairs take sub-intervals (step_plan.cpp).
TEST(RigidPairs, FastCardsAndRodsDoNotPassAThinnerPlate) {
  int passed = 0;
  for (const double rate : kRates_hz) {
    for (const double speed : {15.0, 30.0, 45.0, 60.0}) {
      for (int aim = 0; aim < std::min(100, seed_count(10)); ++aim) {
        const Vector3d size = aim % 2 ? Vector3d(0.01, 0.3, 0.01) : Vector3d(0.1, 0.002, 0.06);
        passed +=
            passes_plate(rate, 0.005, size, aim,
                         {0.06 * speed * std::sin(aim), 0.06 * speed * std::cos(aim), -speed}, 60.0, 20);
      }
    }
  }
  EXPECT_EQ(passed, 0);
}

// State of boxes in free space: linear momentum, angular momentum about the origin, kinetic energy.
struct Moving {
  Vector3d momentum = Vector3d::Zero(), angular = Vector3d::Zero();
  double energy_j = 0.0;
};
Moving moving(const World& world, const std::vector<Vector3d>& sizes_m) {
  Moving sum;
  const auto& bodies = world.bodies();
  for (size_t i = 0; i < bodies.size(); ++i) {
    const BodyState& body = bodies[i];
    const Vector3d s = sizes_m[i].cwiseProduct(sizes_m[i]);
    const Vector3d moments = body.mass_kg / 12.0 * Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
    const Eigen::Matrix3d turn = body.world_from_body.orientation.toRotationMatrix();
    const Vector3d spin = turn * moments.asDiagonal() * turn.transpose() * body.angular_velocity_rad_s;
    const Vector3d push = body.mass_kg * body.velocity_m_s;
    sum.momentum += push;
    sum.angular += body.world_from_body.position_m.cross(push) + spin;
    sum.energy_j += 0.5 * (push.dot(body.velocity_m_s) + spin.dot(body.angular_velocity_rad_s));
  }
  return sum;
}

// Six distant pairs with their own sub-intervals, on one thread or several.
TEST(RigidPairs, CcdSubstepsConserveMomentumOnAnyThreadCount) {
  const std::vector<Vector3d> kinds{{1.0, 1.0, 0.005}, {0.1, 0.002, 0.06}};
  std::vector<Pose> poses_of_one_thread;
  for (const int threads : {1, 2, 8}) {
    set_thread_count(threads);
    World world = world_at(60, 4, Vector3d::Zero());
    std::vector<Vector3d> sizes_m;
    for (uint32_t pair = 0; pair < 6; ++pair) {
      const Vector3d at(3.0 * pair, 0, 0);
      ASSERT_TRUE(world.add_rigid(box_at(2 * pair + 1, kinds[0], 5.0, at)));
      auto card = box_at(2 * pair + 2, kinds[1], 0.1, at + Vector3d(0, 0, 0.3));
      card.world_from_object.orientation = rotation_about(static_cast<int>(pair));
      card.velocity_m_s = {1.0, 2.0, -20.0 - 8.0 * pair};
      ASSERT_TRUE(world.add_rigid(card));
      sizes_m.insert(sizes_m.end(), kinds.begin(), kinds.end());
    }
    const Moving before = moving(world, sizes_m);
    for (int tick = 0; tick < 15; ++tick) world.step();
    const Moving after = moving(world, sizes_m);
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-14 * before.momentum.norm());  // rounding
    EXPECT_LT((after.angular - before.angular).norm(), 1e-9 * before.angular.norm());
    EXPECT_LE(after.energy_j, (1.0 + 1e-6) * before.energy_j);
    EXPECT_LT(after.energy_j, 0.99 * before.energy_j) << "no collision";
    std::vector<Pose> poses;
    for (const BodyState& body : world.bodies()) poses.push_back(body.world_from_body);
    if (threads == 1) poses_of_one_thread = poses;
    for (size_t i = 0; i < poses.size(); ++i) {
      EXPECT_EQ(poses[i].position_m, poses_of_one_thread[i].position_m) << threads;
      EXPECT_EQ(poses[i].orientation.coeffs(), poses_of_one_thread[i].orientation.coeffs()) << threads;
    }
  }
  set_thread_count(0);
}

TEST(RigidPairs, CoincidentBodiesSeparateSlowly) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    for (const int kind : {0, 1, 2}) {
      World world = world_at(rate, 4, Vector3d::Zero());
      for (uint32_t id : {1u, 2u}) {
        const auto added = kind == 0   ? world.add_rigid(box_at(id, {0.1, 0.1, 0.1}, 0.5, {0, 0, 0}))
                           : kind == 1 ? world.add_ball(ball(id, {0, 0, 0}))
                                       : world.add_rigid(body_of(id, notched_mesh(), 0.5));
        ASSERT_TRUE(added);
      }
      double fastest = 0.0;
      for (int i = 0; i < 3 * rate; ++i) {
        world.step();
        fastest = std::max(fastest, body_state(world, 1).velocity_m_s.norm());
      }
      const double apart =
          (body_state(world, 1).world_from_body.position_m - body_state(world, 2).world_from_body.position_m)
              .norm();
      EXPECT_GT(apart, kind == 2 ? 0.055 : 0.095) << kind;  // their smallest width
      EXPECT_LT(fastest, 3.0) << kind;                      // scene 19
    }
  }
}

// A paraboloid bowl 0.18 m wide and 60 mm high, with its foot at the origin. The wall is 6 mm thick along the
// vertical.
TriangleMesh bowl_mesh() {
  constexpr double kRim_m = 0.09, kHigh_m = 0.054, kWall_m = 0.006;
  constexpr int kRings = 6;
  constexpr uint32_t kAround = 24;
  TriangleMesh mesh;
  std::vector<std::pair<double, double>> profile;  // up the outside from the foot, then down the inside
  for (int i = 1; i <= kRings; ++i)
    profile.emplace_back(kRim_m * i / kRings, kHigh_m * i * i / (kRings * kRings));
  for (int i = kRings; i >= 1; --i)
    profile.emplace_back(kRim_m * i / kRings, kWall_m + kHigh_m * i * i / (kRings * kRings));
  mesh.vertices_m = {{0, 0, 0}, {0, kWall_m, 0}};
  for (const auto& [r, y] : profile) {
    for (uint32_t k = 0; k < kAround; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kAround;
      mesh.vertices_m.push_back({r * std::cos(angle), y, r * std::sin(angle)});
    }
  }
  const auto at = [](size_t ring, uint32_t k) {
    return static_cast<uint32_t>(2 + ring * kAround + k % kAround);
  };
  for (uint32_t k = 0; k < kAround; ++k) {
    mesh.triangles.push_back({0, at(0, k), at(0, k + 1)});
    for (size_t ring = 0; ring + 1 < profile.size(); ++ring) {
      mesh.triangles.push_back({at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)});
      mesh.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)});
    }
    mesh.triangles.push_back({1, at(profile.size() - 1, k + 1), at(profile.size() - 1, k)});
  }
  return mesh;
}

// The centres of the bowls are 9 mm apart, a seventh of their height. Bodies with walls of 6 mm are not
// coincident at that distance.
TEST(RigidPairs, NestedBowlsRestInEachOther) {
  const TriangleMesh bowl = bowl_mesh();
  ASSERT_GT(solid_mass_properties(bowl).volume_m3, 0.0);
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.6));
    for (uint32_t id = 1; id <= 4; ++id) {
      auto body = body_of(id, bowl, 0.3);
      body.world_from_object.position_m.y() = 0.001 + 0.009 * (id - 1);
      ASSERT_TRUE(world.add_rigid(body));
    }
    double fastest = 0.0;
    for (int tick = 0; tick < 6 * rate; ++tick) {
      world.step();
      for (const BodyState& body : world.bodies()) fastest = std::max(fastest, body.velocity_m_s.norm());
    }
    // The bowls fall by up to 10 mm.
    EXPECT_LT(fastest, 0.6);
    const double first_m = body_state(world, 1).world_from_body.position_m.y();
    for (uint32_t id = 1; id <= 4; ++id) {
      EXPECT_TRUE(body_state(world, id).asleep) << id;
      const double over_m = body_state(world, id).world_from_body.position_m.y() - first_m;
      EXPECT_NEAR(over_m, 0.006 * (id - 1), 0.002 * (id - 1) + 1e-9) << id;
    }
  }
}

// Hash of all poses after a scene with many contacts. `hulls` are made once because the order of a hull's
// triangles may differ.
uint64_t hash_of_pile(int threads, const std::vector<TriangleMesh>& hulls) {
  set_thread_count(threads);
  World world = world_at(60, 4);
  world.add_collider(floor_plane(0.5, 0.2));
  world.add_collider(
      Collider{BoxShape{{0.3, 0.1, 0.3}}, Pose{{0.2, 0.05, 0}, Eigen::Quaterniond::Identity()}, 0.5, 0.1});
  for (int i = 0; i < 40; ++i) {
    const uint32_t id = static_cast<uint32_t>(i + 1);
    const Vector3d at(0.12 * std::sin(3.0 * i), 0.2 + 0.06 * i, 0.12 * std::cos(7.0 * i));
    if (i % 4 == 3) {
      EXPECT_TRUE(world.add_ball(ball(id, at, 0.03, 0.1)));
      continue;
    }
    auto body = i % 8 == 1 ? body_of(id, notched_mesh(), 0.4)
                           : body_of(id, i % 2 ? box_mesh({0.08, 0.05, 0.1}) : hulls[i], 0.3);
    body.world_from_object.position_m = at;
    body.world_from_object.orientation = rotation_about(i);
    EXPECT_TRUE(world.add_rigid(body));
  }
  run_seconds(world, 3.0);
  uint64_t hash = 1469598103934665603ull;
  for (const BodyState& state : world.bodies()) {
    EXPECT_GT(state.world_from_body.position_m.y(), 0.0) << state.object_id << " fell through";
    double values[7] = {state.world_from_body.position_m.x(),  state.world_from_body.position_m.y(),
                        state.world_from_body.position_m.z(),  state.world_from_body.orientation.w(),
                        state.world_from_body.orientation.x(), state.world_from_body.orientation.y(),
                        state.world_from_body.orientation.z()};
    for (const double value : values) {
      uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      hash = (hash ^ bits) * 1099511628211ull;
    }
  }
  set_thread_count(0);
  return hash;
}

TEST(RigidPairs, SameBitsForOneTwoAndEightThreads) {
  std::vector<TriangleMesh> hulls;
  for (uint32_t i = 0; i < 40; ++i) hulls.push_back(random_hull(i, 0.1));
  const uint64_t one = hash_of_pile(1, hulls);
  EXPECT_EQ(one, hash_of_pile(2, hulls));
  EXPECT_EQ(one, hash_of_pile(8, hulls));
}

}  // namespace
}  // namespace livegs
