// SPDX-License-Identifier: Apache-2.0
// Motion of the `cells` solver compared with closed forms. The bars are in server/physics/ACCURACY.md.
#include <Eigen/Geometry>

#include "geometry/field/sample_particles.h"
#include "geometry/surface/shape_mesh.h"
#include "scenes/elastic_bodies.h"
#include "skin/skin_kernels.h"

namespace livegs::test {
namespace {

TEST(ElasticDynamics, FreeFallMatchesTheSchemesClosedForm) {
  // The velocity is exact. The first step is of first order and g h²/2 too long, and BDF2 carries the error
  // on by thirds: x = g t²/2 + 3/4 g h² (1 - 3^-n).
  Stage stage;
  stage.gravity_m_s2 = kGravity;
  ElasticBodyDescription block = describe(particle_grid(Vector3d::Constant(0.1), 0.02), 1e4, 0.3);
  block.velocity_m_s = {1, 10, 0};
  stage.make(block);
  ASSERT_EQ(stage.body->accuracy().substeps, stage.substeps);
  stage.run(2.0);
  const double h = stage.substep_s(), fall = 0.5 * 9.81 * 4.0 + 0.75 * 9.81 * h * h;
  // Single precision: 480 steps of 4 cm, each rounded by at most 2e-9 m, all in one direction in the worst
  // case.
  EXPECT_NEAR(stage.body->centre_pose().position_m.y(), 20.0 - fall, 1e-6);
  EXPECT_NEAR(stage.body->centre_pose().position_m.x(), 2.0, 1e-6);
  // momentum is summed in double precision
  EXPECT_NEAR(stage.body->velocity_m_s().y(), 10.0 - 9.81 * 2.0, 1e-11);
}

TEST(ElasticDynamics, PointForceAcceleratesTheCentreOfMassExactly) {
  Stage stage;
  stage.make(describe(particle_grid(Vector3d::Constant(0.1), 0.02), 1e5, 0.3));
  stage.forces.push_back({{0.05, 0.02, -0.01}, {0.3, 0.1, -0.2}});
  stage.run(0.5);
  EXPECT_NEAR((stage.body->velocity_m_s() - Vector3d(0.3, 0.1, -0.2) * 0.5).norm(), 0.0, 1e-12);  // 1 kg
}

// A body that spins, vibrates and touches the floor, of half cells and of two materials.
Stage busy_stage() {
  Stage stage;
  stage.rate_hz = 90.0;
  stage.gravity_m_s2 = kGravity;
  stage.add_floor();
  ElasticBodyDescription body = describe(sample_particles(capsule_mesh(0.05, 0.13)), 2e4, 0.3);
  BodyRegion heavy;
  heavy.min_m = {-9, 0.01, -9};
  heavy.max_m = {9, 9, 9};
  heavy.material.emplace().density_kg_m3 = 3000.0;
  body.regions.push_back(heavy);
  body.world_from_object = {{3.0, 0.2, -2.0},
                            Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()))};
  body.velocity_m_s = {1.0, 0.0, 0.5};
  body.angular_velocity_rad_s = {3.0, -2.0, 5.0};
  stage.make(body);
  return stage;
}

TEST(ElasticDynamics, ParticlesHaveTheMomentumOfTheLedger) {
  Stage stage = busy_stage();
  for (int k = 0; k < 10; ++k) {
    stage.run(0.05);
    const BodyEnergy ledger = stage.body->energy(kGravity);
    Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
    double scale = 0.0, angular_scale = 0.0, mass_kg = 0.0;
    for (const ParticleState& particle : stage.body->particles()) {
      const Vector3d momentum = particle.mass_kg * particle.velocity_m_s;
      linear += momentum;
      angular += particle.position_m.cross(momentum);
      mass_kg += particle.mass_kg;
      scale += momentum.norm();
      angular_scale += particle.position_m.norm() * momentum.norm();
    }
    EXPECT_NEAR(mass_kg / stage.body->mass_kg(), 1.0, 1e-12);
    EXPECT_LT((linear - ledger.linear_momentum).norm(), 1e-7 * scale);
    EXPECT_LT((angular - ledger.angular_momentum).norm(), 1e-7 * angular_scale);
  }
}

TEST(ElasticDynamics, ParticlesAndKernelsHaveOneDeformation) {
  Stage stage = busy_stage();
  stage.run(0.3);
  GaussianAsset asset;
  const ParticleSet set = sample_particles(capsule_mesh(0.05, 0.13));
  asset.resize(set.positions_m.size());
  for (size_t i = 0; i < asset.size(); ++i) {
    asset.positions[i] = set.positions_m[i].cast<float>();
    asset.rotations[i].setIdentity();
    asset.log_scales[i].setConstant(-6.0f);
    asset.opacity_logits[i] = 0.0f;
    asset.sh_dc[i].setZero();
  }
  RestBody rest = stage.body->rest_body();
  const auto bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings) << bindings.error().message;
  ObjectDrivers drivers;
  stage.body->write_drivers(drivers);
  PosedKernels kernels;
  std::vector<Eigen::Matrix3f> gradients;
  skin_kernels(asset, rest, *bindings, drivers, kernels, &gradients);
  const std::vector<ParticleState> particles = stage.body->particles();
  ASSERT_EQ(particles.size(), gradients.size());
  double most = 0.0, strain = 0.0;
  for (size_t i = 0; i < particles.size(); ++i) {
    const Matrix3d& f = particles[i].deformation_gradient;
    most = std::max(most, (f - gradients[i].cast<double>()).cwiseAbs().maxCoeff());
    strain = std::max(strain, (f.transpose() * f - Matrix3d::Identity()).norm());
  }
  EXPECT_GT(strain, 0.02);  // the body is deformed
  EXPECT_LT(most, 1e-4);
}

// A couple on a box: spin = couple * time / inertia, for any number of cells across.
TEST(ElasticDynamics, CoupleSpinsBoxesByTheInertiaOfTheirMaterial) {
  struct Case {
    Vector3d size_m;
    double spacing_m, cell_width_m;
    int axis;  // of the spin
  };
  const Case cases[] = {{{0.12, 0.12, 0.12}, 0.02, 0.12, 2}, {{0.12, 0.12, 0.12}, 0.02, 0.06, 2},
                        {{0.12, 0.12, 0.12}, 0.02, 0.04, 0}, {{0.12, 0.12, 0.12}, 0.02, 0.02, 1},
                        {{0.2, 0.02, 0.2}, 0.01, 0.02, 1},   {{0.2, 0.02, 0.2}, 0.01, 0.02, 0},
                        {{0.3, 0.03, 0.03}, 0.01, 0.03, 0},  {{0.3, 0.03, 0.03}, 0.01, 0.03, 2}};
  for (const Case& c : cases) {
    for (const double rate_hz : kRates_hz) {
      SCOPED_TRACE(::testing::Message() << c.size_m.transpose() << " m, cells " << c.cell_width_m
                                        << " m, axis " << c.axis << ", " << rate_hz << " Hz");
      Stage stage;
      stage.rate_hz = rate_hz;
      ElasticBodyDescription box =
          describe(sample_particles(box_mesh(c.size_m), kDefaultSamplingDensity, c.spacing_m), 2e6, 0.3,
                   c.cell_width_m);
      box.material.mass_kg = 1.0;
      stage.make(box);
      const int along = (c.axis + 1) % 3, across = (c.axis + 2) % 3;
      const double a = c.size_m[along], b = c.size_m[across];
      const double inertia = (a * a + b * b) / 12.0, spin_rad_s = 2.0, time_s = 0.2;
      const double force_n = inertia * spin_rad_s / time_s / a;
      const Vector3d arm = 0.5 * a * Vector3d::Unit(along), force = force_n * Vector3d::Unit(across);
      stage.forces.push_back({arm, force});
      stage.forces.push_back({-arm, -force});
      stage.run(time_s);
      // The forces keep their direction while the body turns by 0.2 rad: the couple falls by its cosine.
      const double turned = spin_rad_s * time_s / 2.0;
      EXPECT_NEAR(stage.body->angular_velocity_rad_s()[c.axis] / spin_rad_s, 1.0 - turned * turned / 10.0,
                  0.02);
      const BodyEnergy now = stage.body->energy(kNoGravity);
      EXPECT_NEAR(now.angular_momentum[c.axis] / (inertia * spin_rad_s), 1.0 - turned * turned / 10.0, 0.02);
    }
  }
}

// A crushed bar has the inertia of its nodes; placed, it has that of its material at once.
TEST(ElasticDynamics, PlacedCrushedBarKeepsItsSpin) {
  const Vector3d size_m(0.3, 0.03, 0.03), spin_rad_s(2.0, 0.0, 0.0);
  for (const double rate_hz : kRates_hz) {
    Stage stage;
    stage.rate_hz = rate_hz;
    ElasticBodyDescription bar =
        describe(sample_particles(box_mesh(size_m), kDefaultSamplingDensity, 0.01), 1e4, 0.3, 0.03);
    bar.material.mass_kg = 1.0;
    bar.initial_deformation.diagonal() = Vector3d(0.3, 1, 1);
    stage.make(bar);
    stage.frame();
    ASSERT_TRUE(stage.body->place(Pose{}, Vector3d::Zero(), spin_rad_s));
    stage.run(0.2);
    EXPECT_NEAR(stage.body->angular_velocity_rad_s().x(), spin_rad_s.x(), 0.02);
    const double inertia = (size_m.y() * size_m.y() + size_m.z() * size_m.z()) / 12.0;
    EXPECT_NEAR(stage.body->energy(kNoGravity).angular_momentum.x() / (inertia * spin_rad_s.x()), 1.0, 0.02);
  }
}

TEST(ElasticDynamics, SpinningFreeBallConservesMomentum) {
  // 8 cells across, 10 rad/s, 10 s. Bars: linear momentum 1e-6 of m v, angular momentum 1e-3, energy 1 %.
  ElasticBodyDescription ball = describe({}, 1e4, 0.3, 0.025);
  ball.particles = particle_grid(Vector3d::Constant(0.2), 0.02);
  ParticleSet& set = ball.particles;
  for (size_t i = 0; i < set.positions_m.size();) {
    if (set.positions_m[i].norm() <= 0.1) {
      ++i;
      continue;
    }
    set.positions_m.erase(set.positions_m.begin() + static_cast<ptrdiff_t>(i));
    set.volumes_m3.pop_back();
    set.on_surface.pop_back();
  }
  ball.material.mass_kg = 1000 * 8e-6 * static_cast<double>(set.positions_m.size());
  ball.velocity_m_s = {1, 0.5, -0.25};
  ball.angular_velocity_rad_s = {0, 10, 0};
  const Vector3d far_off(1000, -30, 200);
  for (const Vector3d& place : gate_or_full<Vector3d>({far_off}, {Vector3d(0, 0, 0), far_off})) {
    for (const double rate_hz : kRates_hz) {
      ball.world_from_object.position_m = place;
      Stage stage;
      stage.rate_hz = rate_hz;
      stage.make(ball);
      const auto spin_momentum = [&] {
        const BodyEnergy now = stage.body->energy(kNoGravity);
        return (now.angular_momentum - stage.body->centre_m().cross(now.linear_momentum)).eval();
      };
      const Vector3d linear = stage.body->energy(kNoGravity).linear_momentum, spin = spin_momentum();
      EXPECT_NEAR(stage.body->angular_velocity_rad_s().y(), 10.0, 1e-9);
      const double start = stage.total_energy_j();
      double settled = 0.0, most = 0.0;
      for (int frame = 0; frame < 10 * rate_hz; ++frame) {
        stage.frame();
        most = std::max(most, stage.total_energy_j());
        if (frame == rate_hz / 2)
          settled = stage.total_energy_j();  // at first it bulges, which converts energy to vibration
      }
      const double drift = (stage.body->energy(kNoGravity).linear_momentum - linear).norm() / linear.norm();
      EXPECT_LT(drift, 1e-6) << rate_hz << " Hz at " << place.transpose();
      EXPECT_LT((spin_momentum() - spin).norm() / spin.norm(), 1e-3)
          << rate_hz << " Hz at " << place.transpose();
      EXPECT_LT(most / start, 1.01) << rate_hz << " Hz at " << place.transpose();
      EXPECT_GT(stage.total_energy_j() / settled, 0.99) << rate_hz << " Hz at " << place.transpose();
    }
  }
}

// A loss factor eta takes 2 pi eta of the energy per cycle of the lowest mode, the axial one in a bar half as
// thick as it is long. The bar is released from a stretch of 1 % and vibrates with the period 2 L / c. The
// bar of 10 % over four periods includes the numerical damping of the second-order step.
TEST(ElasticDynamics, LossFactorSetsDampingOfLowestMode) {
  for (const double loss_factor : {0.05, 0.1}) {
    for (const double rate_hz : kRates_hz) {
      ElasticBodyDescription bar = describe(particle_grid({kBarLength_m, 0.2, 0.2}, 0.025), 1e4, 0.0);
      bar.material.loss_factor = loss_factor;
      bar.initial_deformation.diagonal() = Vector3d(1.01, 1, 1);
      Stage stage;
      stage.rate_hz = rate_hz;
      stage.substeps = 16;
      stage.make(bar);
      const double period_s = 2.0 * kBarLength_m / std::sqrt(1e4 / 1000.0);
      const auto energy_over_a_period = [&] {
        double sum = 0.0;
        const int frames = static_cast<int>(std::lround(period_s * rate_hz));
        for (int i = 0; i < frames; ++i) {
          stage.frame();
          sum += stage.total_energy_j();
        }
        return sum / frames;
      };
      const double first = energy_over_a_period();
      energy_over_a_period();
      energy_over_a_period();
      energy_over_a_period();
      const double rate = std::log(first / energy_over_a_period()) / (4.0 * 2.0 * M_PI * loss_factor);
      EXPECT_NEAR(rate, 1.0, 0.1) << loss_factor << ", " << rate_hz << " Hz";
    }
  }
}

TEST(ElasticDynamics, ShapeDampingConservesMomentum) {
  ElasticBodyDescription block = describe(particle_grid({0.2, 0.1, 0.1}, 0.02), 1e4, 0.3);
  block.material.loss_factor = 0.5;
  block.angular_velocity_rad_s = {1, 2, 3};
  block.velocity_m_s = {0.5, 0, 0};
  block.initial_deformation.diagonal() = Vector3d(1.1, 0.95, 1);
  Stage stage;
  stage.make(block);
  const BodyEnergy start = stage.body->energy(kNoGravity);
  stage.run(3.0);
  const BodyEnergy end = stage.body->energy(kNoGravity);
  EXPECT_LT((end.linear_momentum - start.linear_momentum).norm() / start.linear_momentum.norm(), 1e-6);
  EXPECT_LT((end.angular_momentum - start.angular_momentum).norm() / start.angular_momentum.norm(), 1e-5);
  EXPECT_LT(end.elastic_j, 0.02 * start.elastic_j);  // the rest is the stretch due to the spin
}

}  // namespace
}  // namespace livegs::test
