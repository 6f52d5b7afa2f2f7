// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "known_gaps.h"
#include "scenes/rigid_fixtures.h"

// Curved fragments that rock on a floor. The points at which such a body touches change as it turns; each of
// them must be a contact before it has sunk in, or its correction feeds the rocking.

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

constexpr double kWall_m = 0.003, kDensity_kg_m3 = 2400.0;

// A piece of the wall of a bowl of radius `bend_m`, 40 mm wide, with an outline that differs for each
// `number`; the hollow faces up.
TriangleMesh fragment_mesh(double bend_m, int number) {
  constexpr uint32_t kRings = 4, kAround = 14;
  TriangleMesh mesh;
  for (const double wall_m : {0.0, kWall_m}) {
    mesh.vertices_m.push_back({0.0, wall_m, 0.0});
    for (uint32_t ring = 1; ring <= kRings; ++ring) {
      for (uint32_t k = 0; k < kAround; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / kAround;
        const double outline_m = 0.02 * (1.0 + 0.25 * std::cos(2.0 * angle + number) +
                                         0.15 * std::cos(3.0 * angle + 2.0 * number));
        const double r_m = outline_m * ring / kRings;
        mesh.vertices_m.push_back(
            {r_m * std::cos(angle), wall_m + 0.5 * r_m * r_m / bend_m, r_m * std::sin(angle)});
      }
    }
  }
  constexpr uint32_t kInner = 1 + kRings * kAround;
  const auto at = [](uint32_t ring, uint32_t k) { return 1 + (ring - 1) * kAround + k % kAround; };
  const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({kInner + a, kInner + c, kInner + b});
  };
  for (uint32_t k = 0; k < kAround; ++k) {
    add(0, at(1, k), at(1, k + 1));
    for (uint32_t ring = 1; ring < kRings; ++ring) {
      add(at(ring, k), at(ring + 1, k), at(ring + 1, k + 1));
      add(at(ring, k), at(ring + 1, k + 1), at(ring, k + 1));
    }
    const uint32_t a = at(kRings, k), b = at(kRings, k + 1);
    mesh.triangles.push_back({a, kInner + a, kInner + b});
    mesh.triangles.push_back({a, kInner + b, b});
  }
  return mesh;
}

struct Rocking {
  double gained_j = 0.0, released_j = 0.0, rest_s = 0.0;
};

// Releases a fragment 20 degrees tilted and 1 mm above the floor, and sums what its energy gains from tick to
// tick.
Rocking rock(double rate_hz, double bend_m, int number, bool hollow_up) {
  World world = world_at(rate_hz, 4);
  world.add_collider(floor_plane(0.6, 0.2));
  RigidBodyDescription fragment = body_of(1, fragment_mesh(bend_m, number), 1.0);
  const double mass_kg = kDensity_kg_m3 * fragment.properties.volume_m3;
  fragment.material.mass_kg = mass_kg;
  fragment.material.restitution = 0.2;
  fragment.material.friction = 0.6;
  const double turn = radians((hollow_up ? 0.0 : 180.0) + 20.0);
  fragment.world_from_object.orientation =
      Eigen::AngleAxisd(turn, Vector3d(std::cos(number), 0.0, std::sin(number)));
  double lowest_m = 0.0;
  for (const Vector3d& vertex : fragment.mesh.vertices_m)
    lowest_m = std::min(lowest_m, (fragment.world_from_object.orientation * vertex).y());
  fragment.world_from_object.position_m = {0.0, 0.001 - lowest_m, 0.0};
  EXPECT_TRUE(world.add_rigid(fragment));
  Rocking result;
  const auto energy_j = [&] {
    const BodyEnergy energy = world.energy();
    return energy.kinetic_j + energy.gravity_j;
  };
  double before_j = energy_j();
  result.released_j = before_j;
  for (int tick = 1; tick <= static_cast<int>(8.0 * rate_hz); ++tick) {
    world.step();
    const double now_j = energy_j();
    result.gained_j += std::max(0.0, now_j - before_j);
    before_j = now_j;
    if (!body_state(world, 1).asleep) result.rest_s = tick / rate_hz;
  }
  result.released_j -= before_j;
  return result;
}

// The energy of a rocking body only falls, but for the sag of its contacts.
TEST(RigidRocking, CurvedFragmentsComeToRest) {
  std::optional<double> most_at_60_hz;
  for (const double rate_hz : kRates_hz) {
    for (const double bend_m : {0.03, 0.06}) {
      for (int number = 0; number < seed_count(12); ++number) {
        for (const bool hollow_up : {true, false}) {
          SCOPED_TRACE(testing::Message() << rate_hz << " Hz, fragment " << number << " of a bowl of "
                                          << bend_m << " m, hollow " << (hollow_up ? "up" : "down"));
          const Rocking rocking = rock(rate_hz, bend_m, number, hollow_up);
          EXPECT_LT(rocking.rest_s, 3.0);
          const double gain = rocking.gained_j / rocking.released_j;
          if (rate_hz < 90.0)
            most_at_60_hz = std::max(most_at_60_hz.value_or(0.0), gain);
          else
            EXPECT_LT(gain, 0.02);
        }
      }
    }
  }
  if (most_at_60_hz) report_gap("rocking.energy_at_60_hz", *most_at_60_hz);
}

}  // namespace
}  // namespace livegs
