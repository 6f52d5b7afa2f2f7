// SPDX-License-Identifier: GPL-3.0-or-later
// Soft bodies that come to rest: alone, held, under loads and in a heap.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/surface/shape_mesh.h"
#include "study/stability/stability_scenes.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

constexpr double kMaxTime_s = 12.0;

}  // namespace

std::vector<Measurement> resting_block(StabilityRun& run) {
  constexpr double kHeight_m = 0.2, kBlockModulus_pa = 5e4, kDensity_kg_m3 = 1000.0;
  World world = run.world();
  world.add_collider(floor_of(0.0));
  ElasticBodyDescription block =
      soft_body(1, box_mesh(Vector3d::Constant(kHeight_m)), kBlockModulus_pa, 0.0, kDensity_kg_m3);
  block.material.loss_factor = 0.5;
  block.world_from_object.position_m = {0, 0.15, 0};
  if (!world.add_elastic(block)) return {};
  double awake_s = 0.0;
  run.step(world, kMaxTime_s, [&] {
    awake_s += 1.0 / run.rate_hz();
    return !world.elastic_body(1)->asleep();
  });
  const double sag_m = 0.5 * kHeight_m - world.elastic_body(1)->centre_m().y();
  return {relative("sag", sag_m,
                   kDensity_kg_m3 * kGravity_m_s2 * kHeight_m * kHeight_m / (3.0 * kBlockModulus_pa), 0.1),
          absolute("awake", awake_s, 0.0, 6.0, "s")};
}

std::vector<Measurement> held_bar(StabilityRun& run) {
  const auto sag_m = [&](double loss_factor, bool sleep) {
    World world = run.world(kWeightless, sleep);
    ElasticBodyDescription bar = soft_body(1, box_mesh({1.0, 0.05, 0.05}), 1e5, 0.0);
    bar.material.loss_factor = loss_factor;
    bar.regions.push_back(fixed_box({-9, -9, -9}, {-0.45, 9, 9}));
    BodyRegion pull;
    pull.min_m = {0.45, -9, -9};
    pull.max_m = {9, 9, 9};
    pull.traction_pa = {0, -0.073, 0};
    bar.regions.push_back(pull);
    if (!world.add_elastic(bar)) return std::nan("");
    run.step(world, 200.0, [&] { return !world.elastic_body(1)->asleep(); });
    return -world.elastic_body(1)->world_point({0.5, 0, 0}).y();
  };
  const double settled_m = sag_m(1.0, false);
  return {relative("sag", sag_m(0.1, true), settled_m, 0.01)};
}

std::vector<Measurement> loaded_pillow(StabilityRun& run) {
  struct Load {
    double youngs_modulus_pa, mass_kg;
  };
  double aside_m = 0.0, awake_s = 0.0;
  for (const Load& load : {Load{2e4, 5.0}, Load{5e3, 5.0}, Load{1e4, 8.0}}) {
    World world = run.world();
    world.add_collider(floor_of(0.6));
    ElasticBodyDescription pillow =
        soft_body(1, box_mesh({0.4, 0.1, 0.3}), load.youngs_modulus_pa, 0.3, 20.0);
    pillow.material.loss_factor = 0.3;
    pillow.world_from_object.position_m = {0, 0.05, 0};
    RigidBodyDescription box = rigid_body(2, box_mesh({0.2, 0.15, 0.15}), load.mass_kg);
    box.world_from_object.position_m = {0.02, 0.176, 0};
    if (!world.add_elastic(pillow) || !world.add_rigid(box)) return {};
    run.step(world, kMaxTime_s, [&] {
      awake_s += 1.0 / 3.0 / run.rate_hz();
      return !world.elastic_body(1)->asleep() || !body_of(world, 2).asleep;
    });
    const Vector3d at = body_of(world, 2).world_from_body.position_m;
    aside_m = std::max(aside_m, std::hypot(at.x() - 0.02, at.z()));
  }
  return {absolute("aside", aside_m, 0.0, 0.006, "m"), absolute("awake", awake_s, 0.0, 8.0, "s")};
}

std::vector<Measurement> soft_heap(StabilityRun& run) {
  constexpr uint32_t kBoxes = 12;
  World world = run.world();
  world.add_collider(floor_of(0.6));
  for (int side = 0; side < 4; ++side) {
    const double turn = 0.5 * M_PI * side;
    Collider wall{BoxShape{{0.02, 1.0, 1.0}}, Pose{}, 0.6, 0.0};
    wall.world_from_collider.orientation = Eigen::AngleAxisd(turn, Vector3d::UnitY());
    wall.world_from_collider.position_m = wall.world_from_collider.orientation * Vector3d(0.27, 0.5, 0);
    world.add_collider(wall);
  }
  for (uint32_t i = 0; i < kBoxes; ++i) {
    ElasticBodyDescription box = soft_body(i + 1, box_mesh({0.2, 0.15, 0.2}), 3e4, 0.3, 300.0);
    box.material.loss_factor = 0.3;
    box.material.friction = 0.6;
    const uint32_t place = i % 4;
    box.world_from_object.position_m = {place % 2 ? 0.12 : -0.12, 0.12 + 0.2 * (i / 4),
                                        place / 2 ? 0.12 : -0.12};
    box.world_from_object.orientation = Eigen::AngleAxisd(0.1 * (i + 1), Vector3d::UnitY());
    if (!world.add_elastic(box)) return {};
  }
  run.step(world, 5.0);
  int awake = 0;
  double lowest_m = 0.0;
  for (uint32_t i = 1; i <= kBoxes; ++i) {
    awake += !world.elastic_body(i)->asleep();
    for (const ParticleState& particle : world.elastic_body(i)->particles())
      lowest_m = std::min(lowest_m, particle.position_m.y());
  }
  return {absolute("awake", awake, 0.0, 1.0), absolute("sink", -lowest_m, 0.0, 0.002, "m")};
}

std::vector<Measurement> thin_shelf(StabilityRun& run) {
  double passed = 0.0;
  for (const double speed_m_s : {0.0, 4.0, 8.0}) {
    World world = run.world();
    world.add_collider(Collider{BoxShape{{1.0, 0.002, 1.0}}, Pose{}, 0.5, 0.0});
    ElasticBodyDescription block = soft_body(1, box_mesh({0.12, 0.1, 0.08}), 5e3, 0.3);
    block.world_from_object.position_m = {0, 0.3, 0};
    block.world_from_object.orientation = orientation_of(3);
    block.velocity_m_s = {0, -speed_m_s, 0};
    if (!world.add_elastic(block)) return {};
    run.step(world, 2.0);
    const std::vector<ParticleState> particles = world.elastic_body(1)->particles();
    const auto below = std::count_if(particles.begin(), particles.end(),
                                     [](const ParticleState& one) { return one.position_m.y() < -0.002; });
    passed = std::max(passed, static_cast<double>(below) / static_cast<double>(particles.size()));
  }
  return {absolute("passed", passed, 0.0, 0.001)};
}

}  // namespace livegs::study
