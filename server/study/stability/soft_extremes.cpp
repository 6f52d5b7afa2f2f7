// SPDX-License-Identifier: GPL-3.0-or-later
// Soft bodies beyond what their cells are designed for: overstretched, scrambled, impaled, nearly empty.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/surface/shape_mesh.h"
#include "study/harness/particle_fit.h"
#include "study/stability/stability_scenes.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

// Adds the particles of `part`, moved and turned by `pose`.
void join(ParticleSet& particles, const ParticleSet& part, const Pose& pose) {
  particles.spacing_m =
      particles.positions_m.empty() ? part.spacing_m : std::max(particles.spacing_m, part.spacing_m);
  for (const Vector3d& position : part.positions_m) particles.positions_m.push_back(pose * position);
  particles.volumes_m3.insert(particles.volumes_m3.end(), part.volumes_m3.begin(), part.volumes_m3.end());
  particles.on_surface.insert(particles.on_surface.end(), part.on_surface.begin(), part.on_surface.end());
}

// A pot, a stem and six thin leaves: the corners of their cells have down to a millionth of the mass of the
// pot's.
ParticleSet plant() {
  ParticleSet particles;
  join(particles, sample_particles(cylinder_mesh(0.05, 0.08)),
       {{0, 0.04, 0}, Eigen::Quaterniond::Identity()});
  join(particles, sample_particles(cylinder_mesh(0.006, 0.2)),
       {{0, 0.17, 0}, Eigen::Quaterniond::Identity()});
  for (int leaf = 0; leaf < 6; ++leaf) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1 * leaf, Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(0.5, Vector3d::UnitZ()));
    for (int part = 0; part < 5; ++part) {  // an arc of five flat parts
      const Eigen::Quaterniond bend(Eigen::AngleAxisd(0.3 - 0.3 * part, Vector3d::UnitZ()));
      const double angle = 0.15 + 0.3 * part;
      const Vector3d at(0.09 * std::sin(angle), 0.16 + 0.02 * leaf + 0.09 * (std::cos(angle) - 1.0), 0);
      join(particles, sample_particles(box_mesh({0.028, 0.002, 0.03}), 8), {turn * at, turn * bend});
    }
  }
  particles.spacing_m = 0.03;  // cells much wider than leaves
  return particles;
}

ElasticBodyDescription body_with(ParticleSet particles, double youngs_modulus_pa, double density_kg_m3) {
  ElasticBodyDescription body = soft_body(1, box_mesh(Vector3d::Ones()), youngs_modulus_pa);
  double volume_m3 = 0.0;
  for (const double one : particles.volumes_m3) volume_m3 += one;
  body.material.mass_kg = density_kg_m3 * volume_m3;
  body.particles = std::move(particles);
  return body;
}

}  // namespace

std::vector<Measurement> overstretched_strip(StabilityRun& run) {
  constexpr double kStripLength_m = 0.35, kStretch = 4.0, kStripModulus_pa = 1e5;
  const Vector3d end(0.2, 0, 0);
  World world = run.world(kWeightless);
  ElasticBodyDescription strip = soft_body(1, box_mesh({0.4, 0.003, 0.1}), kStripModulus_pa);
  strip.regions.push_back(fixed_box({-0.3, -0.1, -0.1}, {-0.15, 0.1, 0.1}));
  if (!world.add_elastic(strip)) return {};
  world.set_spring(
      1, 1, {.rest_point_m = end, .target_m = {5, 0, 0}, .stiffness_n_m = 2000.0, .max_force_n = 100.0});
  double farthest_m = 0.0, most_j = 0.0;
  run.step(world, 3.0, [&] {
    farthest_m =
        std::max(farthest_m, (world.elastic_body(1)->world_point(end) - Vector3d(-0.15, 0, 0)).norm());
    most_j = std::max(most_j, kinetic_and_elastic_j(world.energy()));
    return true;
  });
  const double strain_j = 0.5 * kStripModulus_pa * std::pow(kStretch - 1.0, 2) * kStripLength_m * 0.003 * 0.1;
  return {absolute("energy", most_j / strain_j, 0.0, 1.1),
          absolute("length", farthest_m / (kStretch * kStripLength_m), 0.0, 1.2)};
}

std::vector<Measurement> scrambled_block(StabilityRun& run) {
  double worst = 0.0;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    World world = run.world(kWeightless);
    const Vector3d size_m = seed % 2 ? Vector3d(0.1, 0.08, 0.06) : Vector3d(0.2, 0.2, 0.025);
    ElasticBodyDescription block = soft_body(1, box_mesh(size_m), seed % 2 ? 3e4 : 1e5);
    const ParticleSet rest = block.particles;
    block.cells.scramble = seed;
    if (!world.add_elastic(block)) return {};
    run.step(world, seed % 2 ? 2.0 : 4.0);
    worst = std::max(worst, distance_from_rest_shape_m(*world.elastic_body(1), rest) / size_m.maxCoeff());
  }
  return {absolute("shape", worst, 0.0, 1e-3)};
}

std::vector<Measurement> impaled_block(StabilityRun& run) {
  constexpr int kSeeds = 6;
  double sum_j = 0.0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    World world = run.world(kWeightless, false);
    ElasticBodyDescription block = soft_body(1, box_mesh(Vector3d::Constant(0.1)), 1.5e5, 0.45, 100.0);
    block.material.loss_factor = 0.3;
    block.cells.scramble = seed;
    if (!world.add_elastic(block) || !world.add_rigid(rigid_body(2, box_mesh({0.02, 0.6, 0.02}), 5.0)))
      return {};
    run.step(world, 3.0);
    sum_j += world.energy().elastic_j;
  }
  return {absolute("energy", sum_j / kSeeds, 0.0, 1.5, "J")};
}

std::vector<Measurement> jerked_plant(StabilityRun& run) {
  double gain = 0.0, returned = 0.0;
  const ParticleSet particles = plant();
  for (int jerk = 0; jerk < 8; ++jerk) {
    World world = run.world(kWeightless);
    ElasticBodyDescription body = body_with(particles, 1.5e6, 800.0);
    body.material.plasticity = jerk % 2 ? 0.3 : 0.0;
    if (!world.add_elastic(body)) return {};
    const size_t at = particles.positions_m.size() * (4 + static_cast<size_t>(jerk)) / 12;
    world.set_force(1, 1, {particles.positions_m[at], 50.0 * (orientation_of(jerk) * Vector3d::UnitX())},
                    0.33);
    run.step(world, 0.34);
    const BodyEnergy released = world.energy();
    double flow_j = released.plastic_work_j;
    run.step(world, 3.0, [&] {
      const BodyEnergy now = world.energy();
      gain = std::max(gain, kinetic_and_elastic_j(now) / kinetic_and_elastic_j(released) - 1.0);
      returned = std::max(returned, (flow_j - now.plastic_work_j) / kinetic_and_elastic_j(released));
      flow_j = now.plastic_work_j;
      return true;
    });
  }
  return {absolute("gain", gain, 0.0, 0.01), absolute("flow", returned, 0.0, 1e-6)};
}

std::vector<Measurement> haze(StabilityRun& run) {
  ParticleSet particles = sample_particles(sphere_mesh(0.1, 3));
  const double volume_m3 = 1e-5 * particles.volumes_m3.front();
  double farthest_rest_m = 0.0;
  for (int i = 0; i < 120; ++i) {
    const Vector3d at = (0.1 + 0.001 * (i % 60)) * (orientation_of(i) * Vector3d::UnitX());
    farthest_rest_m = std::max(farthest_rest_m, at.norm());
    particles.positions_m.push_back(at);
    particles.volumes_m3.push_back(volume_m3);
    particles.on_surface.push_back(false);
  }
  World world = run.world();
  world.add_collider(floor_of(0.5));
  ElasticBodyDescription body = body_with(std::move(particles), 1e5, 300.0);
  body.world_from_object.position_m = {0, 0.5, 0};
  body.angular_velocity_rad_s = {2, 1, 3};
  if (!world.add_elastic(body)) return {};
  const double start_j = total_j(world.energy());
  double gain = 0.0, apart = 0.0;
  run.step(world, 4.0, [&] {
    gain = std::max(gain, total_j(world.energy()) / start_j - 1.0);
    const ElasticBody& soft = *world.elastic_body(1);
    for (const ParticleState& particle : soft.particles())
      apart = std::max(apart, (particle.position_m - soft.centre_m()).norm() / farthest_rest_m);
    return true;
  });
  return {absolute("gain", gain, 0.0, 0.02), absolute("apart", apart, 0.0, 1.5)};
}

}  // namespace livegs::study
