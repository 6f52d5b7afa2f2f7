// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "physics/elastic/rigid_proxy.h"
#include "physics/elastic_body.h"
#include "physics/elastic_device.h"
#include "rates.h"

// Bodies of the elastic tests: regular grids of particles, and a bar (describe_bar).

namespace livegs::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

inline const Vector3d kNoGravity = Vector3d::Zero();
inline const Vector3d kGravity{0, -9.81, 0};

// Particles at the voxel centres of a box centred on the origin. `size_m` holds full edge lengths.
inline ParticleSet particle_grid(const Vector3d& size_m, double spacing_m) {
  ParticleSet set;
  set.spacing_m = spacing_m;
  const Eigen::Vector3i n = (size_m / spacing_m).array().round().cast<int>();
  for (int k = 0; k < n.z(); ++k) {
    for (int j = 0; j < n.y(); ++j) {
      for (int i = 0; i < n.x(); ++i) {
        set.positions_m.push_back(Vector3d(i + 0.5, j + 0.5, k + 0.5) * spacing_m -
                                  0.5 * n.cast<double>() * spacing_m);
      }
    }
  }
  set.volumes_m3.assign(set.positions_m.size(), spacing_m * spacing_m * spacing_m);
  set.on_surface.assign(set.positions_m.size(), false);
  return set;
}

inline ElasticBodyDescription describe(ParticleSet particles, double youngs_modulus_pa, double poisson_ratio,
                                       double cell_width_m = 0.0, double density_kg_m3 = 1000.0) {
  ElasticBodyDescription description;
  double volume = 0.0;
  for (const double v : particles.volumes_m3) volume += v;
  description.particles = std::move(particles);
  description.material.behavior = Behavior::Elastic;
  description.material.mass_kg = density_kg_m3 * volume;
  description.material.youngs_modulus_pa = youngs_modulus_pa;
  description.material.poisson_ratio = poisson_ratio;
  description.material.loss_factor = 0.0;
  description.cell_width_m = cell_width_m;
  return description;
}

inline constexpr double kBarLength_m = 0.4, kBarWidth_m = 0.1;

inline ElasticBodyDescription describe_bar(double youngs_modulus_pa, double poisson_ratio,
                                           double cell_width_m, double spacing_m = 0.025) {
  return describe(particle_grid({kBarLength_m, kBarWidth_m, kBarWidth_m}, spacing_m), youngs_modulus_pa,
                  poisson_ratio, cell_width_m);
}

// An elastic body, the loads and colliders that act on it, and the scene's clock.
struct Stage {
  double rate_hz = 60.0;
  int substeps = 4;
  Vector3d gravity_m_s2 = kNoGravity;
  std::vector<Collider> colliders;
  std::vector<RigidProxy*> bodies;
  std::vector<PointForce> forces;
  std::unique_ptr<ElasticBody> body;
  double time_s = 0.0;

  void make(const ElasticBodyDescription& description, ElasticBodyFactory solver = make_elastic_body,
            bool may_sleep = false) {
    auto made = solver(description, rate_hz, substeps, may_sleep);
    ASSERT_TRUE(made.has_value()) << made.error().message;
    body = std::move(*made);
  }
  double substep_s() const { return 1.0 / (rate_hz * substeps); }
  void substep() {
    SubstepContext context;
    context.start_s = time_s;
    context.duration_s = substep_s();
    time_s += context.duration_s;
    context.gravity_m_s2 = gravity_m_s2;
    context.colliders = colliders;
    context.bodies = bodies;
    context.forces = forces;
    body->substep(context);
  }
  // All substeps of a frame on the device of the process; false if there is none or it cannot take the body.
  bool frame_on_device() {
    auto* flat = dynamic_cast<FlatBody*>(body.get());
    if (!elastic_device() || !flat || !bodies.empty()) return false;
    FlatTick tick;
    tick.start_s = time_s;
    tick.duration_s = 1.0 / rate_hz;
    tick.substeps = substeps;
    tick.gravity_m_s2 = gravity_m_s2;
    tick.colliders = colliders;
    DeviceBody one{flat, forces};
    elastic_device()->step({&one, 1}, tick);
    if (one.reason) return false;
    time_s += tick.duration_s;
    return true;
  }
  void frame() {
    if (!frame_on_device()) {
      for (int i = 0; i < substeps; ++i) substep();
    }
    body->end_frame(1.0 / rate_hz);
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * rate_hz)); ++i) frame();
  }
  double total_energy_j() const {
    const BodyEnergy energy = body->energy(gravity_m_s2);
    return energy.kinetic_j + energy.elastic_j + energy.gravity_j;
  }
  void add_floor(double friction = 0.5) {
    Collider floor;
    floor.shape = PlaneShape{};
    floor.friction = friction;
    colliders.push_back(floor);
  }
};

// A uniform traction on the bar's face x = `x_m`: equal forces on a regular grid of points.
inline void add_end_traction(std::vector<PointForce>& forces, double x_m, double traction_pa) {
  constexpr int n = 8;
  const double force_n = traction_pa * kBarWidth_m * kBarWidth_m / (n * n);
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < n; ++k) {
      const double y = ((j + 0.5) / n - 0.5) * kBarWidth_m, z = ((k + 0.5) / n - 0.5) * kBarWidth_m;
      forces.push_back({{x_m, y, z}, {force_n, 0, 0}});
    }
  }
}

inline double rms_distance_from_rest_shape(const ElasticBody& body, const ParticleSet& rest) {
  const Pose pose = body.centre_pose();
  Vector3d rest_centre = Vector3d::Zero();
  double volume = 0.0;
  for (size_t i = 0; i < rest.positions_m.size(); ++i) {
    rest_centre += rest.volumes_m3[i] * rest.positions_m[i];
    volume += rest.volumes_m3[i];
  }
  rest_centre /= volume;
  const std::vector<ParticleState> now = body.particles();
  double sum = 0.0;
  for (size_t i = 0; i < now.size(); ++i) {
    sum += (now[i].position_m - pose * (rest.positions_m[i] - rest_centre)).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(now.size()));
}

inline bool all_finite(const ElasticBody& body) {
  for (const ParticleState& p : body.particles()) {
    if (!p.position_m.allFinite() || !p.velocity_m_s.allFinite() || !p.deformation_gradient.allFinite())
      return false;
  }
  return true;
}

}  // namespace livegs::test
