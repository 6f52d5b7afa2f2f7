// SPDX-License-Identifier: GPL-3.0-or-later
// Soft bodies that land, spin, collide and roll.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/surface/shape_mesh.h"
#include "study/stability/stability_scenes.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

double drift_of(const Vector3d& now, const Vector3d& before) { return (now - before).norm() / before.norm(); }

}  // namespace

std::vector<Measurement> soft_landing(StabilityRun& run) {
  constexpr double kMaxTime_s = 12.0;
  struct Fall {
    TriangleMesh mesh;
    double youngs_modulus_pa, poisson_ratio;
  };
  const std::vector<Fall> falls{
      {box_mesh(Vector3d::Constant(0.1)), 1e4, 0.3}, {box_mesh(Vector3d::Constant(0.1)), 1e6, 0.3},
      {cylinder_mesh(0.04, 0.12), 1e4, 0.3},         {cylinder_mesh(0.04, 0.12), 1e6, 0.3},
      {capsule_mesh(0.03, 0.12), 1e4, 0.3},          {box_mesh({0.1, 0.08, 0.06}), 3e4, 0.49},
      {box_mesh({0.3, 0.3, 0.012}), 1e4, 0.49}};
  double gain = 0.0, awake_s = 0.0;
  for (const Fall& fall : falls) {
    World world = run.world();
    world.add_collider(floor_of(0.5));
    ElasticBodyDescription body = soft_body(1, fall.mesh, fall.youngs_modulus_pa, fall.poisson_ratio);
    body.world_from_object.position_m = {0, 0.3, 0};
    body.world_from_object.orientation = Eigen::AngleAxisd(0.5, Vector3d(1, 0, 0.5).normalized());
    if (!world.add_elastic(body)) return {};
    const double start_j = total_j(world.energy());
    run.step(world, kMaxTime_s, [&] {
      gain = std::max(gain, total_j(world.energy()) / start_j - 1.0);
      awake_s += 1.0 / run.rate_hz();
      return !world.elastic_body(1)->asleep();
    });
  }
  return {absolute("gain", gain, 0.0, 5e-4),
          absolute("awake", awake_s / static_cast<double>(falls.size()), 0.0, 3.0, "s")};
}

std::vector<Measurement> limp_spin(StabilityRun& run) {
  double gain = 0.0, drift = 0.0;
  for (const double modulus_pa : {1e3, 1e4}) {
    for (const double poisson_ratio : {0.3, 0.49}) {
      World world = run.world(kWeightless);
      ElasticBodyDescription sheet = soft_body(1, box_mesh({0.3, 0.3, 0.002}), modulus_pa, poisson_ratio);
      sheet.angular_velocity_rad_s = 30.0 * Vector3d(0.3, 1.0, 0.2).normalized();
      if (!world.add_elastic(sheet)) return {};
      const BodyEnergy before = world.energy();
      run.step(world, 4.0, [&] {
        const BodyEnergy now = world.energy();
        gain = std::max(gain, kinetic_and_elastic_j(now) / kinetic_and_elastic_j(before) - 1.0);
        drift = std::max(drift, drift_of(now.angular_momentum, before.angular_momentum));
        return true;
      });
    }
  }
  return {absolute("gain", gain, 0.0, 0.01), absolute("momentum", drift, 0.0, 1e-3)};
}

std::vector<Measurement> soft_collision(StabilityRun& run) {
  World world = run.world(kWeightless);
  ElasticBodyDescription one = soft_body(1, box_mesh(Vector3d::Constant(0.1)), 3e4, 0.3, 500.0);
  one.world_from_object.position_m = {-0.15, 0.02, 0};
  one.velocity_m_s = {2, 0, 0};
  ElasticBodyDescription two = soft_body(2, box_mesh(Vector3d::Constant(0.1)), 3e4, 0.3, 300.0);
  two.world_from_object.orientation = orientation_of(2);
  if (!world.add_elastic(one) || !world.add_elastic(two)) return {};
  const BodyEnergy before = world.energy();
  double linear = 0.0, angular = 0.0;
  run.step(world, 1.0, [&] {
    const BodyEnergy now = world.energy();
    linear = std::max(linear, drift_of(now.linear_momentum, before.linear_momentum));
    angular = std::max(angular, drift_of(now.angular_momentum, before.angular_momentum));
    return true;
  });
  return {absolute("linear", linear, 0.0, 1e-4), absolute("angular", angular, 0.0, 1e-3)};
}

std::vector<Measurement> couple(StabilityRun& run) {
  constexpr double kCoupleSpin_rad_s = 2.0, kTime_s = 0.2;
  struct Box {
    Vector3d size_m;
    double cell_width_m;
    int axis;  // of the spin
  };
  double worst = 0.0;
  for (const Box& box : {Box{Vector3d::Constant(0.12), 0.12, 2}, Box{Vector3d::Constant(0.12), 0.06, 2},
                         Box{Vector3d::Constant(0.12), 0.02, 1}, Box{{0.2, 0.02, 0.2}, 0.02, 1},
                         Box{{0.3, 0.03, 0.03}, 0.03, 0}}) {
    World world = run.world(kWeightless);
    ElasticBodyDescription body = soft_body(1, box_mesh(box.size_m), 2e6);
    body.particles = sample_particles(box_mesh(box.size_m), kDefaultSamplingDensity, 0.01);
    body.cell_width_m = box.cell_width_m;
    body.material.loss_factor = 0.0;
    if (!world.add_elastic(body)) return {};
    const int along = (box.axis + 1) % 3, across = (box.axis + 2) % 3;
    const double a = box.size_m[along], b = box.size_m[across];
    const double inertia = body.material.mass_kg * (a * a + b * b) / 12.0;
    const Vector3d arm = 0.5 * a * Vector3d::Unit(along);
    const Vector3d force = inertia * kCoupleSpin_rad_s / kTime_s / a * Vector3d::Unit(across);
    world.set_force(1, 1, {arm, force}, kTime_s);
    world.set_force(2, 1, {-arm, -force}, kTime_s);
    run.step(world, kTime_s);
    // The forces keep their direction while the body turns: the couple falls by its cosine.
    const double turned = 0.5 * kCoupleSpin_rad_s * kTime_s;
    const double spin = world.elastic_body(1)->angular_velocity_rad_s()[box.axis] / kCoupleSpin_rad_s;
    worst = std::max(worst, std::abs(spin / (1.0 - turned * turned / 10.0) - 1.0));
  }
  return {absolute("spin", worst, 0.0, 0.02)};
}

std::vector<Measurement> soft_flight(StabilityRun& run) {
  constexpr double kFlightSpin_rad_s = 3.0, kFlight_s = 4.0;
  World world = run.world(kWeightless);
  ElasticBodyDescription box = soft_body(1, box_mesh({0.3, 0.1, 0.2}), 1e6);
  box.angular_velocity_rad_s = kFlightSpin_rad_s * Vector3d::UnitY();
  if (!world.add_elastic(box)) return {};
  const Vector3d before = world.energy().angular_momentum;
  run.step(world, kFlight_s);
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(kFlightSpin_rad_s * kFlight_s, Vector3d::UnitY()));
  return {absolute("angle", expected.angularDistance(world.elastic_body(1)->centre_pose().orientation), 0.0,
                   0.02, "rad"),
          absolute("momentum", drift_of(world.energy().angular_momentum, before), 0.0, 1e-3)};
}

std::vector<Measurement> soft_rolling(StabilityRun& run) {
  constexpr double kRadius_m = 0.1, kCylinderLength_m = 0.2, kRollingPoissonRatio = 0.3, kTime_s = 1.0;
  struct Slope {
    bool cylinder;
    double youngs_modulus_pa, degrees;
  };
  double worst = 0.0;
  for (const Slope& slope : {Slope{false, 1e5, 5.0}, Slope{false, 1e6, 10.0}, Slope{true, 1e6, 5.0}}) {
    const double angle = slope.degrees * std::numbers::pi / 180.0;
    World world = run.world(kGravity_m_s2 * Vector3d(std::sin(angle), -std::cos(angle), 0.0));
    world.add_collider(floor_of(1.0));
    ElasticBodyDescription body =
        soft_body(1, slope.cylinder ? cylinder_mesh(kRadius_m, kCylinderLength_m) : sphere_mesh(kRadius_m, 3),
                  slope.youngs_modulus_pa, kRollingPoissonRatio, 300.0);
    body.material.friction = 1.0;
    body.world_from_object.position_m = {0.0, kRadius_m, 0.0};
    if (slope.cylinder)
      body.world_from_object.orientation = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX());
    if (!world.add_elastic(body)) return {};
    const double start_m = world.elastic_body(1)->centre_m().x();
    run.step(world, kTime_s);
    // Half the width of the contact by Hertz, and the couple of the loss factor.
    const double stiffness_pa = slope.youngs_modulus_pa / (1.0 - kRollingPoissonRatio * kRollingPoissonRatio);
    const double load_n = body.material.mass_kg * kGravity_m_s2 * std::cos(angle);
    const double contact_m =
        slope.cylinder
            ? std::sqrt(4.0 * load_n / kCylinderLength_m * kRadius_m / (std::numbers::pi * stiffness_pa))
            : std::cbrt(0.75 * load_n * kRadius_m / stiffness_pa);
    const double couple_n_m =
        3.0 / 16.0 * 2.0 * std::numbers::pi * body.material.loss_factor * load_n * contact_m;
    const double inertia = slope.cylinder ? 1.5 : 1.4;  // of rolling, over mass and radius squared
    const double acceleration_m_s2 =
        (kGravity_m_s2 * std::sin(angle) - couple_n_m / (kRadius_m * body.material.mass_kg)) / inertia;
    const double way_m = world.elastic_body(1)->centre_m().x() - start_m;
    worst = std::max(worst, std::abs(way_m / (0.5 * acceleration_m_s2 * kTime_s * kTime_s) - 1.0));
  }
  return {absolute("way", worst, 0.0, 0.05)};
}

}  // namespace livegs::study
