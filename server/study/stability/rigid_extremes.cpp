// SPDX-License-Identifier: GPL-3.0-or-later
// Rigid bodies beyond what one contact search a substep covers: fast, thin, coincident, broken, heavy.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "geometry/surface/shape_mesh.h"
#include "prepare/prepare_pieces.h"
#include "study/stability/stability_scenes.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

// A bar of 200 x 60 x 60 mm with a notch of 60 x 30 mm across its middle.
TriangleMesh notched_bar() {
  constexpr double kOutline_m[8][2] = {{-0.1, -0.03}, {0.1, -0.03}, {0.1, 0.03},   {0.03, 0.03},
                                       {0.03, 0.0},   {-0.03, 0.0}, {-0.03, 0.03}, {-0.1, 0.03}};
  constexpr std::array<uint32_t, 3> kFront[6] = {{0, 1, 4}, {1, 2, 3}, {1, 3, 4},
                                                 {0, 4, 5}, {0, 5, 6}, {0, 6, 7}};
  TriangleMesh mesh;
  for (const double z : {-0.03, 0.03}) {
    for (const auto& point : kOutline_m) mesh.vertices_m.push_back({point[0], point[1], z});
  }
  for (const auto& [a, b, c] : kFront) {
    mesh.triangles.push_back({c, b, a});
    mesh.triangles.push_back({a + 8, b + 8, c + 8});
  }
  for (uint32_t i = 0; i < 8; ++i) {
    const uint32_t next = (i + 1) % 8;
    mesh.triangles.push_back({i, next, next + 8});
    mesh.triangles.push_back({i, next + 8, i + 8});
  }
  return mesh;
}

// A cylinder of 80 x 100 mm with a bore of 72 mm from the top to 5 mm above the bottom.
TriangleMesh cup() {
  constexpr int kSegments = 24;
  constexpr double kProfile_m[][2] = {{0.04, 0},    {0.04, 0.05},  {0.04, 0.1},
                                      {0.036, 0.1}, {0.036, 0.05}, {0.036, 0.005}};
  constexpr uint32_t kRings = std::size(kProfile_m);
  TriangleMesh mesh;
  for (const auto& ring : kProfile_m) {
    for (int s = 0; s < kSegments; ++s) {
      const double turn = 2.0 * std::numbers::pi * s / kSegments;
      mesh.vertices_m.emplace_back(ring[0] * std::cos(turn), ring[1], -ring[0] * std::sin(turn));
    }
  }
  const uint32_t bottom = kRings * kSegments, inside = bottom + 1;
  mesh.vertices_m.emplace_back(0, 0, 0);
  mesh.vertices_m.emplace_back(0, 0.005, 0);
  for (uint32_t s = 0; s < kSegments; ++s) {
    const uint32_t next = (s + 1) % kSegments, last = (kRings - 1) * kSegments;
    mesh.triangles.push_back({bottom, next, s});
    mesh.triangles.push_back({inside, last + s, last + next});
    for (uint32_t ring = 0; ring + 1 < kRings; ++ring) {
      const uint32_t a = ring * kSegments, b = a + kSegments;
      mesh.triangles.push_back({a + s, a + next, b + next});
      mesh.triangles.push_back({a + s, b + next, b + s});
    }
  }
  return mesh;
}

}  // namespace

std::vector<Measurement> fast_plate(StabilityRun& run) {
  constexpr double kBall_m = 0.025, kPlate_m = 0.005;
  int passed = 0, shots = 0;
  double sink_m = 0.0;  // of balls into the fixed plate
  const auto shoot = [&](bool free_plate, const RigidBodyDescription& thing) {
    World world = run.world(kWeightless);
    if (!free_plate) {
      world.add_collider(Collider{BoxShape{{1.0, 1.0, kPlate_m}}, Pose{}, 0.3, 0.0});
    } else if (!world.add_rigid(rigid_body(1, box_mesh({1.0, 1.0, kPlate_m}), 5.0))) {
      return;
    }
    if (!world.add_rigid(thing)) return;
    bool through = false;
    run.step(world, 0.3, [&] {
      const Pose plate = free_plate ? body_of(world, 1).world_from_body : Pose{};
      const Vector3d seen = plate.inverse() * body_of(world, 2).world_from_body.position_m;
      const bool over = std::abs(seen.x()) < 0.5 && std::abs(seen.y()) < 0.5;
      through = over && seen.z() < 0.0;
      if (over && !free_plate) sink_m = std::max(sink_m, kBall_m + 0.5 * kPlate_m - seen.z());
      return !through;
    });
    passed += through;
    ++shots;
  };
  for (const double speed_m_s : {15.0, 30.0, 45.0, 60.0, 100.0}) {
    for (int aim = 0; aim < 150; ++aim) {
      RigidBodyDescription thing = aim % 3 == 0   ? rigid_body(2, box_mesh({0.1, 0.002, 0.06}), 0.1)
                                   : aim % 3 == 1 ? rigid_body(2, box_mesh({0.01, 0.3, 0.01}), 0.1)
                                                  : rigid_body(2, sphere_mesh(kBall_m, 3), 0.5);
      thing.world_from_object = {{0, 0, 0.6}, orientation_of(aim)};
      thing.velocity_m_s = {0.06 * speed_m_s * std::sin(aim), 0.06 * speed_m_s * std::cos(aim), -speed_m_s};
      thing.angular_velocity_rad_s =
          60.0 * Vector3d(std::sin(2.0 * aim), std::cos(3.0 * aim), std::sin(5.0 * aim));
      shoot(aim % 3 != 2, thing);
    }
  }
  return {absolute("passed", static_cast<double>(passed) / shots, 0.0, 0.01),
          absolute("sink", sink_m, 0.0, 0.001, "m")};
}

std::vector<Measurement> coincident_bodies(StabilityRun& run) {
  constexpr double kApart_m = 0.05;
  int stuck = 0, pairs = 0;
  double fastest_m_s = 0.0;
  for (const TriangleMesh& mesh : {box_mesh(Vector3d::Constant(0.1)), notched_bar()}) {
    World world = run.world(kWeightless);
    if (!world.add_rigid(rigid_body(1, mesh, 0.5)) || !world.add_rigid(rigid_body(2, mesh, 0.5))) return {};
    run.step(world, 3.0, [&] {
      for (const BodyState& body : world.bodies())
        fastest_m_s = std::max(fastest_m_s, body.velocity_m_s.norm());
      return true;
    });
    stuck +=
        (body_of(world, 1).world_from_body.position_m - body_of(world, 2).world_from_body.position_m).norm() <
        kApart_m;
    ++pairs;
  }
  return {absolute("apart", static_cast<double>(stuck) / pairs, 0.0, 0.01),
          absolute("speed", fastest_m_s, 0.0, 2.0, "m/s")};
}

std::vector<Measurement> fragment_heap(StabilityRun& run) {
  constexpr double kMass_kg = 0.25;
  const TriangleMesh mesh = cup();
  const auto pieces = prepare_pieces(mesh, Fill::Solid, {.piece_count = 64, .seed = 1});
  if (!pieces) return {};
  std::array<double, 5> weights{};
  for (size_t heap = 0; heap < weights.size(); ++heap) {
    World world = run.world();
    world.add_collider(floor_of(0.5));
    RigidBodyDescription body = rigid_body(1, mesh, kMass_kg);
    body.material.fragile = true;
    body.material.break_impulse_n_s = 0.7;
    body.material.restitution = 0.2;
    body.world_from_object.position_m.y() = 4.0 + 0.001 * static_cast<double>(heap);
    if (!world.add_rigid(body) || !world.set_pieces(1, *pieces)) return {};
    run.step(world, 1.4);
    run.step(world, 3.0, [&] {
      double sum_n_s = 0.0;
      for (const VoronoiPiece& piece : (*pieces)->cut.pieces)
        sum_n_s += world.contact_impulse_n_s(1, piece.mass.centre_of_mass_m);
      weights[heap] = std::max(weights[heap], sum_n_s * run.rate_hz() / (kMass_kg * kGravity_m_s2));
      return true;
    });
  }
  std::sort(weights.begin(), weights.end());
  return {absolute("weight", weights[weights.size() / 2], 0.0, 3.7)};
}

std::vector<Measurement> snapping_chain(StabilityRun& run) {
  constexpr uint32_t kLinks = 20;
  constexpr double kLink_m = 0.1, kLink_kg = 0.1;
  double stretch = 0.0, gain = 0.0;
  for (const double ratio : {1.0, 1000.0, 50000.0}) {
    World world = run.world();
    for (uint32_t i = 1; i <= kLinks + 1; ++i) {
      const bool heavy = i > kLinks;
      RigidBodyDescription link =
          rigid_body(i, box_mesh(heavy ? Vector3d::Constant(0.1) : Vector3d(0.1, 0.02, 0.02)),
                     heavy ? ratio * kLink_kg : kLink_kg);
      link.world_from_object.position_m = {kLink_m * i - 0.5 * kLink_m, 0, 0};
      BallJointDescription joint{i, {}, {-0.5 * kLink_m, 0, 0}};
      if (i > 1) joint.other_id = i - 1;
      if (!world.add_rigid(link) || !world.add_ball_joint(joint)) return {};
    }
    const double before_j = total_j(world.energy());
    const double fall_j = ratio * kLink_kg * kGravity_m_s2 * kLinks * kLink_m;
    run.step(world, 1.5, [&] {
      const std::vector<JointState> joints = world.joints();
      double length_m = 0.0;
      for (size_t j = 1; j < joints.size(); ++j)
        length_m += (joints[j].point_m - joints[j - 1].point_m).norm();
      if (ratio <= 1000.0) stretch = std::max(stretch, std::abs(length_m / (kLinks * kLink_m) - 1.0));
      gain = std::max(gain, (total_j(world.energy()) - before_j) / fall_j);
      return true;
    });
  }
  return {absolute("stretch", stretch, 0.0, 0.02), absolute("gain", gain, 0.0, 0.05)};
}

std::vector<Measurement> heavy_on_light_box(StabilityRun& run) {
  constexpr double kSize_m = 0.1;
  World world = run.world();
  world.add_collider(floor_of(0.6));
  for (uint32_t id : {1u, 2u}) {
    RigidBodyDescription box = rigid_body(id, box_mesh(Vector3d::Constant(kSize_m)), id == 1 ? 1.0 : 1000.0);
    box.world_from_object.position_m = {0, kSize_m * (id - 0.5), 0};
    if (!world.add_rigid(box)) return {};
  }
  double sunk_m = 0.0;
  run.step(world, 5.0, [&] {
    sunk_m = std::max(sunk_m, 1.5 * kSize_m - body_of(world, 2).world_from_body.position_m.y());
    return true;
  });
  return {absolute("sink", sunk_m / kSize_m, 0.0, 0.002)};
}

std::vector<Measurement> pile_of_books(StabilityRun& run) {
  constexpr uint32_t kBooks = 5;
  constexpr double kThick_m = 0.03, kBook_kg = 0.3, kSize_m = 0.15;
  World world = run.world();
  world.add_collider(floor_of(0.6));
  for (uint32_t i = 1; i <= kBooks; ++i) {
    RigidBodyDescription book = rigid_body(i, box_mesh({0.2, kThick_m, 0.15}), kBook_kg);
    book.world_from_object.position_m = {0, (i - 0.5) * kThick_m, 0};
    if (!world.add_rigid(book)) return {};
  }
  RigidBodyDescription box = rigid_body(kBooks + 1, box_mesh(Vector3d::Constant(kSize_m)), 100.0 * kBook_kg);
  const double laid_m = kBooks * kThick_m + 0.5 * kSize_m;
  box.world_from_object.position_m = {0.01, laid_m, 0.01};
  if (!world.add_rigid(box)) return {};
  double lowest_m = laid_m;
  run.step(world, 5.0, [&] {
    lowest_m = std::min(lowest_m, body_of(world, kBooks + 1).world_from_body.position_m.y());
    return true;
  });
  return {absolute("sink", (laid_m - lowest_m) / (kBooks * kThick_m), 0.0, 0.01)};
}

}  // namespace livegs::study
