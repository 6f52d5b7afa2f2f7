// SPDX-License-Identifier: Apache-2.0
// Inputs that break elastic solvers: flattened and inverted starts, high stiffness and resolution, shapes
// without volume, invalid input.
#include <random>

#include "baseline/elastic_solvers.h"
#include "physics/elastic_body.h"
#include "scenes/elastic_bodies.h"

namespace livegs::test {
namespace {

TEST(ElasticRecovery, BlockRecoversFromDegenerateStarts) {
  // A block of 4³ cells recovers its rest shape to 1e-3 of its size within 2 s at loss factor 0.5.
  const double size = 0.1;
  for (const double stiffness : {1e4, 1e5}) {
    for (const Vector3d& scale : {Vector3d(-1, 1, 1), Vector3d(1, 0, 1), Vector3d(1, 0, 0), Vector3d(0, 0, 0),
                                  Vector3d(-1, -1, -1), Vector3d(1, 1, -0.5)}) {
      Stage stage;
      ElasticBodyDescription block =
          describe(particle_grid(Vector3d::Constant(size), 0.0125), stiffness, 0.3, 0.025);
      block.material.loss_factor = 0.5;
      block.initial_deformation.setZero();
      block.initial_deformation.diagonal() = scale;
      stage.make(block);
      const double stored = stage.body->energy(kNoGravity).elastic_j;
      double kinetic = 0.0;
      for (int frame = 0; frame < 120; ++frame) {
        stage.frame();
        kinetic = std::max(kinetic, stage.body->energy(kNoGravity).kinetic_j);
      }
      ASSERT_TRUE(all_finite(*stage.body));
      EXPECT_LT(rms_distance_from_rest_shape(*stage.body, block.particles), 1e-3 * size)
          << stiffness << " from " << scale.transpose();
      EXPECT_LE(kinetic, stored);
    }
  }
}

TEST(ElasticRecovery, StaysFiniteOverStiffnessAndSubsteps) {
  for (const double stiffness : {1e4, 1e6, 1e8}) {
    for (const int substeps : {1, 4}) {
      Stage stage;
      stage.substeps = substeps;
      stage.gravity_m_s2 = kGravity;
      stage.add_floor();
      ElasticBodyDescription block = describe(particle_grid(Vector3d::Constant(0.1), 0.02), stiffness, 0.45);
      block.world_from_object = {{0, 0.55, 0},
                                 Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vector3d(1, 0, 1).normalized()))};
      stage.make(block);
      const double start = stage.total_energy_j();
      double kinetic = 0.0;
      for (int frame = 0; frame < 180; ++frame) {
        stage.frame();
        kinetic = std::max(kinetic, stage.body->energy(kGravity).kinetic_j);
      }
      ASSERT_TRUE(all_finite(*stage.body)) << stiffness << ", " << substeps;
      EXPECT_LE(kinetic, start) << stiffness << ", " << substeps;  // the floor is at height zero
    }
  }
}

TEST(ElasticRecovery, SingleParticlesLinesAndSheetsFallAndLand) {
  const auto lattice_line = [](int nx, int nz) {
    ParticleSet set;
    set.spacing_m = 0.01;
    for (int k = 0; k < nz; ++k) {
      for (int i = 0; i < nx; ++i) set.positions_m.emplace_back(0.01 * i, 0.0, 0.01 * k);
    }
    set.volumes_m3.assign(set.positions_m.size(), 1e-6);
    return set;
  };
  for (const ElasticBodyFactory solver : {make_elastic_body, make_livegs_v1_body}) {
    for (const ParticleSet& set :
         {lattice_line(1, 1), lattice_line(20, 1), lattice_line(12, 12), lattice_line(2, 1)}) {
      Stage stage;
      stage.gravity_m_s2 = kGravity;
      stage.add_floor();
      ElasticBodyDescription body = describe(set, 1e5, 0.3);
      body.material.loss_factor = 0.3;
      body.world_from_object = {{0, 0.2, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d::UnitX()))};
      stage.make(body, solver);
      stage.run(3.0);
      ASSERT_TRUE(all_finite(*stage.body)) << set.positions_m.size();
      for (const ParticleState& p : stage.body->particles()) {
        EXPECT_GT(p.position_m.y(), 0.0) << set.positions_m.size();
        EXPECT_LT(p.position_m.y(), 0.1) << set.positions_m.size();
      }
    }
  }
}

TEST(ElasticRecovery, CoincidentAndIrregularParticlesMakeABody) {
  std::mt19937_64 random(3);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  ParticleSet set;
  set.spacing_m = 0.02;
  for (int i = 0; i < 300; ++i) {
    set.positions_m.emplace_back(0.2 * unit(), 0.1 * unit(), 0.1 * unit());
    if (i % 10 == 0) set.positions_m.push_back(set.positions_m.back());
  }
  for (size_t i = 0; i < set.positions_m.size(); ++i) set.volumes_m3.push_back(1e-6 * (0.1 + 10 * unit()));
  for (const ElasticBodyFactory solver : {make_elastic_body, make_livegs_v1_body}) {
    Stage stage;
    stage.gravity_m_s2 = kGravity;
    stage.add_floor();
    ElasticBodyDescription body = describe(set, 1e5, 0.3);
    body.world_from_object.position_m = {0, 0.1, 0};
    stage.make(body, solver);
    stage.run(2.0);
    ASSERT_TRUE(all_finite(*stage.body));
    EXPECT_LT(stage.body->centre_pose().position_m.y(), 0.15);
    EXPECT_GT(stage.body->centre_pose().position_m.y(), 0.0);
  }
}

TEST(ElasticBody, MotionIsTheSameFarFromTheOrigin) {
  const auto shape_after = [](const Vector3d& place) {
    Stage stage;
    ElasticBodyDescription block = describe(particle_grid({0.2, 0.1, 0.1}, 0.02), 1e4, 0.3);
    block.world_from_object.position_m = place;
    block.angular_velocity_rad_s = {3, 5, 1};
    stage.make(block);
    stage.run(2.0);
    return (stage.body->world_point({0.1, 0, 0}) - stage.body->world_point({-0.1, 0, 0})).eval();
  };
  // At 1 km each read-out and the origin of the nodes lose 1e-13 m.
  EXPECT_NEAR((shape_after({0, 0, 0}) - shape_after({1000, -2000, 500})).norm(), 0.0, 1e-9);
}

TEST(ElasticBody, RejectsUnphysicalDescriptions) {
  const ElasticBodyDescription good = describe(particle_grid(Vector3d::Constant(0.1), 0.05), 1e5, 0.3);
  const auto message = [](const ElasticBodyDescription& d, double rate = 60, int substeps = 4) {
    auto made = make_elastic_body(d, rate, substeps, true);
    return made ? std::string() : made.error().message;
  };
  EXPECT_EQ(message(good), "");
  ElasticBodyDescription bad = good;
  bad.particles = {};
  EXPECT_NE(message(bad).find("no particles"), std::string::npos);
  bad = good;
  bad.particles.positions_m[3].x() = std::nan("");
  EXPECT_NE(message(bad).find("position"), std::string::npos);
  bad = good;
  bad.particles.volumes_m3[0] = 0.0;
  EXPECT_NE(message(bad).find("volume"), std::string::npos);
  bad = good;
  bad.particles.volumes_m3.pop_back();
  EXPECT_NE(message(bad).find("volumes_m3"), std::string::npos);
  bad = good;
  bad.material.mass_kg = 0.0;
  EXPECT_NE(message(bad).find("mass_kg"), std::string::npos);
  bad = good;
  bad.material.poisson_ratio = 0.5;
  EXPECT_NE(message(bad).find("poisson_ratio"), std::string::npos);
  bad = good;
  bad.material.youngs_modulus_pa = -1.0;
  EXPECT_NE(message(bad).find("youngs_modulus_pa"), std::string::npos);
  bad = good;
  bad.material.friction = 3.0;
  EXPECT_EQ(message(bad), "object 0: friction is 3; it must be 0 to 2");
  bad = good;
  bad.material.plasticity = -1.0;
  EXPECT_NE(message(bad).find("plasticity"), std::string::npos);
  bad = good;
  bad.material.restitution = std::nan("");
  EXPECT_NE(message(bad).find("restitution"), std::string::npos);
  bad = good;
  bad.material.structure_coefficient = 0.0;
  EXPECT_NE(message(bad).find("structure_coefficient"), std::string::npos);
  bad = good;
  bad.material.behavior = Behavior::Auto;
  EXPECT_NE(message(bad).find("AUTO"), std::string::npos);
  EXPECT_NE(message(good, 0.0).find("rate_hz"), std::string::npos);
  EXPECT_NE(message(good, 60, 0).find("substeps"), std::string::npos);
}

TEST(ElasticBody, ChangedMaterialChangesAccuracy) {
  Stage stage;
  ElasticBodyDescription block = describe(particle_grid(Vector3d::Constant(0.1), 0.02), 1e4, 0.3);
  stage.make(block);
  const ElasticAccuracy before = stage.body->accuracy();
  Material stiffer = block.material;
  stiffer.youngs_modulus_pa = 1e9;
  stage.body->set_material(stiffer);
  const ElasticAccuracy after = stage.body->accuracy();
  EXPECT_EQ(after.cell_width_m, before.cell_width_m);
  EXPECT_GT(after.substeps, before.substeps);
  EXPECT_TRUE(after.clipped);
  EXPECT_LT(after.reached_youngs_modulus_pa, 1e9);
  stage.run(0.1);
  EXPECT_TRUE(all_finite(*stage.body));
}

TEST(ElasticBody, RayMeetsTheNearSide) {
  Stage stage;
  ElasticBodyDescription block = describe(particle_grid(Vector3d::Constant(0.2), 0.02), 1e4, 0.3);
  block.world_from_object.position_m = {1, 2, 3};
  stage.make(block);
  const auto hit = stage.body->ray_cast({1.05, 2.03, 5}, -Vector3d::UnitZ());
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->distance_m, 1.91,
              1e-7);  // single precision; the outermost layer's centres are at z = 3.09
  EXPECT_NEAR(hit->rest_point_m.z(), 0.09, 1e-12);
  EXPECT_FALSE(stage.body->ray_cast({1.05, 2.03, 5}, Vector3d::UnitZ()).has_value());
  EXPECT_FALSE(stage.body->ray_cast({2, 2, 5}, -Vector3d::UnitZ()).has_value());
}

}  // namespace
}  // namespace livegs::test
