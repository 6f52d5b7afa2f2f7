// SPDX-License-Identifier: Apache-2.0
// Young's modulus, Poisson's ratio and bending of the `cells` solver compared with closed forms. The modulus
// reached at each Courant number is in modulus_band_test.cpp.
#include <random>

#include "geometry/field/sample_particles.h"
#include "geometry/surface/shape_mesh.h"
#include "known_gaps.h"
#include "scenes/elastic_bodies.h"

namespace livegs::test {
namespace {

struct Tension {
  double modulus_ratio, poisson_ratio;
};

// Measures a free bar under opposite end tractions of 0.5 % strain over its middle half, after settling.
Tension measure_tension(const ElasticBodyDescription& description, int substeps) {
  Stage stage;
  stage.substeps = substeps;
  ElasticBodyDescription damped = description;
  damped.material.loss_factor = 2.0;
  stage.make(damped);
  const double traction = 0.005 * description.material.effective_youngs_modulus_pa();
  add_end_traction(stage.forces, 0.5 * kBarLength_m, traction);
  add_end_traction(stage.forces, -0.5 * kBarLength_m, -traction);
  // Runs for forty times the decay time of the slowest damped motion.
  const double wave_m_s = std::sqrt(description.material.effective_youngs_modulus_pa() / 1000.0);
  stage.run(40.0 / (2.0 * wave_m_s * 6.46 * kBarWidth_m / (kBarLength_m * kBarLength_m)));
  const auto stretch = [&](const Vector3d& half) {
    return (stage.body->world_point(half) - stage.body->world_point(-half)).norm() / (2.0 * half.norm()) -
           1.0;
  };
  const double along = stretch({0.1, 0, 0});
  const double across = 0.5 * (stretch({0, 0.05, 0}) + stretch({0, 0, 0.05}));
  return {0.005 / along, -across / along};
}

TEST(ElasticStatics, JitteredParticlesShowTheSameModulus) {
  // Particles of 10 mm are moved by up to 0.3 of their size. The bar is 2 %.
  ElasticBodyDescription bar = describe_bar(1e5, 0.3, 0.025, 0.01);
  std::mt19937_64 random(7);
  const auto jitter = [&] { return 0.6 * 0.01 * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5); };
  for (Vector3d& p : bar.particles.positions_m) p += Vector3d(jitter(), jitter(), jitter());
  const Tension found = measure_tension(bar, 4);
  EXPECT_NEAR(found.modulus_ratio, 1.0, 0.02);
  EXPECT_NEAR(found.poisson_ratio, 0.3, 0.01);
}

// Bars that extend into a second row of cells by a fifth must not bend too stiffly.
TEST(ElasticStatics, FlatBarsBendRightAboutTheirStiffAxis) {
  for (const Vector3d& size : {Vector3d(1.0, 0.15, 0.05), Vector3d(2.0, 0.3, 0.1), Vector3d(1.0, 0.12, 0.05),
                               Vector3d(1.0, 0.19, 0.06)}) {
    for (const double poisson_ratio : {0.0, 0.3}) {
      SCOPED_TRACE(testing::Message() << size.transpose() << ", nu " << poisson_ratio);
      const double stiffness = 1e6, clamp = 0.1 * size.x(), length = size.x() - clamp,
                   area = size.y() * size.z();
      const double inertia = size.z() * std::pow(size.y(), 3) / 12.0,
                   shear = 0.5 * stiffness / (1.0 + poisson_ratio);
      const double of_load = std::pow(length, 4) / (8 * stiffness * inertia) +
                             length * length / (2 * (5.0 / 6.0) * shear * area);
      const double load = 0.01 * length / of_load;
      ElasticBodyDescription bar = describe(sample_particles(box_mesh(size)), stiffness, poisson_ratio);
      bar.material.loss_factor = 2.0;
      bar.regions.push_back(fixed_box({-size.x(), -1, -1}, {-0.5 * size.x() + clamp, 1, 1}));
      Stage stage;
      stage.gravity_m_s2 = {0, -load / (1000.0 * area), 0};
      stage.make(bar);
      stage.run(6.0);
      report_gap("statics.flat_bar_sag",
                 std::abs(-stage.body->world_point({0.5 * size.x(), 0, 0}).y() / (0.01 * length) - 1.0));
    }
  }
}

TEST(ElasticStatics, AffineDeformationHasClosedFormEnergy) {
  // V [ mu |S - I|² + lambda/2 (det F - 1)² ] without bending or twisting: exact, also for cells that are not
  // full.
  const double youngs = 2e5, poisson = 0.3;
  ElasticBodyDescription block = describe(particle_grid({0.2, 0.15, 0.1}, 0.02), youngs, poisson, 0.045);
  Matrix3d stretch;
  stretch << 1.2, 0.05, 0, 0.05, 0.9, -0.02, 0, -0.02, 1.1;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.4, Vector3d(1, -1, 2).normalized()));
  block.initial_deformation = turn.toRotationMatrix() * stretch;
  Stage stage;
  stage.make(block);
  double volume = 0.0;
  for (const double v : block.particles.volumes_m3) volume += v;
  const double mu = youngs / (2 * (1 + poisson)),
               lambda = youngs * poisson / ((1 + poisson) * (1 - 2 * poisson));
  const double expected = volume * (mu * (stretch - Matrix3d::Identity()).squaredNorm() +
                                    0.5 * lambda * std::pow(stretch.determinant() - 1, 2));
  EXPECT_NEAR(stage.body->energy(kNoGravity).elastic_j / expected, 1.0, 1e-6);
  for (const ParticleState& p : stage.body->particles()) {
    EXPECT_NEAR((p.deformation_gradient - block.initial_deformation).norm(), 0.0,
                1e-6);  // single precision over a cell
  }
}

TEST(ElasticStatics, RigidPlacementHasNoStrain) {
  ElasticBodyDescription block = describe(particle_grid({0.2, 0.15, 0.1}, 0.02), 1e5, 0.4, 0.045);
  block.world_from_object = {{3, -2, 1},
                             Eigen::Quaterniond(Eigen::AngleAxisd(2.5, Vector3d(1, 2, -1).normalized()))};
  Stage stage;
  stage.make(block);
  stage.run(1.0);
  // Rounding only: lengths of 0.1 m in single precision over 240 substeps.
  for (size_t i = 0; i < block.particles.positions_m.size(); ++i) {
    const Vector3d now = stage.body->particles()[i].position_m;
    ASSERT_NEAR((now - block.world_from_object * block.particles.positions_m[i]).norm(), 0.0, 1e-7);
    i += 50;
  }
  // Rounding gives strains of 1e-7: V E e²/2 is 1e-12 to 1e-10 J.
  EXPECT_LT(stage.body->energy(kNoGravity).elastic_j, 1e-9);
  EXPECT_LT(stage.body->energy(kNoGravity).kinetic_j, 1e-9);
}

}  // namespace
}  // namespace livegs::test
