// SPDX-License-Identifier: Apache-2.0
// Regions that fix or move meshed bodies as in scenes, at any position of their faces among particles and
// cells.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "geometry/surface/shape_mesh.h"
#include "physics/material/return_mapping.h"
#include "scenes/elastic_bodies.h"

namespace livegs {
namespace {

using test::Stage;
using test::Vector3d;

ElasticBodyDescription mesh_bar(const Vector3d& size_m, double youngs_modulus_pa, double poisson_ratio,
                                double spacing_m = 0.0) {
  ParticleSet particles = sample_particles(box_mesh(size_m), kDefaultSamplingDensity, spacing_m);
  return test::describe(std::move(particles), youngs_modulus_pa, poisson_ratio);
}

BodyRegion clamp_to(double face_m) {
  BodyRegion clamp = fixed_box({-9, -9, -9}, {face_m, 9, 9});
  clamp.name = "clamp";
  return clamp;
}

// Applies 16 equal forces over the end.
void load_end(Stage& stage, const Vector3d& size_m, const Vector3d& force_n) {
  for (int j = 0; j < 4; ++j) {
    for (int k = 0; k < 4; ++k) {
      const Vector3d at(0.5 * size_m.x(), ((j + 0.5) / 4 - 0.5) * size_m.y(),
                        ((k + 0.5) / 4 - 0.5) * size_m.z());
      stage.forces.push_back({at, force_n / 16.0});
    }
  }
}

double end_moved_m(const Stage& stage, int axis) {
  double sum = 0.0;
  for (const PointForce& force : stage.forces)
    sum += (stage.body->world_point(force.point_m) - force.point_m)[axis] / 16.0;
  return sum;
}

// Sag of the end over Timoshenko's, under a load that bends the bar by a hundredth of its free length.
double sag_ratio(const Vector3d& size_m, double face_m, double spacing_m, double poisson = 0.3) {
  constexpr double youngs_pa = 1e6;
  const double free_m = 0.5 * size_m.x() - face_m;
  const double area_m2 = size_m.y() * size_m.z(), second_m4 = size_m.z() * std::pow(size_m.y(), 3) / 12.0;
  const double force_n = 0.01 * 3.0 * youngs_pa * second_m4 / (free_m * free_m);
  const double shear_pa = youngs_pa / (2.0 * (1.0 + poisson));
  const double beam_m = 0.01 * free_m + force_n * free_m / (5.0 / 6.0 * shear_pa * area_m2);
  ElasticBodyDescription bar = mesh_bar(size_m, youngs_pa, poisson, spacing_m);
  bar.material.loss_factor = 1.0;
  bar.regions.push_back(clamp_to(face_m));
  Stage stage;
  stage.make(bar);
  load_end(stage, size_m, {0, -force_n, 0});
  // Damping is at least critical for the slowest vibration, so the bar comes to rest.
  const double rate_rad_s =
      3.516 / std::sqrt(12.0) * size_m.y() / (size_m.x() * size_m.x()) * std::sqrt(youngs_pa / 1000.0);
  stage.run(25.0 / rate_rad_s);
  EXPECT_TRUE(test::all_finite(*stage.body)) << size_m.transpose() << ", held to " << face_m;
  return -end_moved_m(stage, 1) / beam_m;
}

// Clay keeps the set of the flow rule, whether a region drives all of it or only its boundary.
TEST(ElasticRegions, DrivenClayKeepsItsSet) {
  constexpr double kPlasticity = 0.95, kPoisson = 0.3, kStretch = 0.12;
  const Eigen::Matrix3d stretch = Vector3d(1.0 + kStretch, 1.0, 1.0).asDiagonal();
  // The set of one cell under the same stretch, in as many steps.
  const YieldSurface surface = yield_surface(kPlasticity, kPoisson);
  Eigen::Matrix3d set = Eigen::Matrix3d::Identity();
  for (int k = 1; k <= 60; ++k) {
    const Eigen::Matrix3d f =
        Eigen::Matrix3d::Identity() + k / 60.0 * (stretch - Eigen::Matrix3d::Identity());
    set = flow_plastically(surface, f * set.inverse(), set).plastic_part;
  }
  for (const bool boundary : {false, true}) {
    SCOPED_TRACE(boundary ? "boundary" : "whole");
    Stage stage;
    ElasticBodyDescription clay =
        test::describe(test::particle_grid({0.2, 0.2, 0.2}, 0.025), 1e5, kPoisson, 0.05);
    clay.material.plasticity = kPlasticity;
    clay.material.loss_factor = 0.5;
    BodyRegion driven;
    driven.name = "hand";
    driven.boundary = boundary;
    driven.min_m = {-9, -9, -9};
    driven.max_m = {9, 9, 9};
    driven.motion = AffineRamp{stretch, Vector3d::Zero(), 0.0, 1.0, 0.0};
    clay.regions.push_back(driven);
    stage.make(clay);
    stage.run(1.1);
    ASSERT_TRUE(stage.body->release_region("hand"));
    stage.run(2.0);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d end = 0.1 * Vector3d::Unit(axis);
      const double length_m = (stage.body->world_point(end) - stage.body->world_point(-end)).norm();
      // Within 2 % of the set along the stretch.
      EXPECT_NEAR(length_m / 0.2, set(axis, axis), 0.02 * (set(0, 0) - 1.0)) << axis;
    }
  }
}

// The nodes between two held regions stay with the second one when the first is released.
TEST(ElasticRegions, NeighbourOfAReleasedRegionStaysHeld) {
  Stage stage;
  ElasticBodyDescription bar = test::describe(test::particle_grid({0.4, 0.1, 0.1}, 0.025), 1e5, 0.3, 0.05);
  bar.regions = {fixed_box({-9, -9, -9}, {0, 9, 9}), fixed_box({0, -9, -9}, {9, 9, 9})};
  bar.regions[0].name = "left";
  bar.material.loss_factor = 0.5;
  stage.gravity_m_s2 = {0.0, -9.81, 0.0};
  stage.make(bar);
  const auto place_m = [&](double x_m) { return stage.body->world_point({x_m, 0.0, 0.0}); };
  const Vector3d middle_m = place_m(0.0), end_m = place_m(-0.2);
  ASSERT_TRUE(stage.body->release_region("left"));
  stage.run(2.0);
  EXPECT_LT((place_m(0.0) - middle_m).norm(), 1e-6);
  // 3/2 rho g L^4 / (E a^2) for a bar of width a, without shear.
  EXPECT_NEAR(end_m.y() - place_m(-0.2).y(), 0.0235, 0.2 * 0.0235);
}

// A moved face reaches its place wherever it lies in a cell, in the middle and at the edges.
TEST(ElasticRegions, MovedFaceReachesItsPlace) {
  constexpr double kWay_m = 0.01;
  for (const double spacing_m : {0.02, 0.0125}) {
    for (const double cell_width_m : {0.05, 0.0333}) {
      for (const double thickness_m : {0.0201, 0.027, 0.034, 0.041, 0.05, 0.063}) {
        SCOPED_TRACE(testing::Message() << spacing_m << " " << cell_width_m << " " << thickness_m);
        Stage stage;
        const double end_m = 0.2, face_m = end_m - thickness_m;
        ElasticBodyDescription bar =
            test::describe(test::particle_grid({2 * end_m, 0.1, 0.1}, spacing_m), 1e5, 0.3, cell_width_m);
        bar.material.loss_factor = 1.0;
        bar.regions.push_back(clamp_to(-0.15));
        BodyRegion moved;
        moved.min_m = {face_m, -9, -9};
        moved.max_m = {9, 9, 9};
        moved.motion = DisplacementRamp{{kWay_m, 0.5 * kWay_m, 0.0}, 0.0, 0.25};
        bar.regions.push_back(moved);
        stage.make(bar);
        stage.run(1.0);
        size_t held = 0;
        for (const Vector3d& rest_m : bar.particles.positions_m) {
          if (rest_m.x() < face_m) continue;
          ++held;
          const Vector3d way_m = stage.body->world_point(rest_m) - rest_m;
          EXPECT_NEAR(way_m.x() / kWay_m, 1.0, 0.01) << rest_m.transpose();
          EXPECT_NEAR(way_m.y() / kWay_m, 0.5, 0.01) << rest_m.transpose();
        }
        EXPECT_GT(held, 0u);
      }
    }
  }
}

// Timoshenko's clamped end is softer than a solid one at nu 0.3, by 8 % for a free length of two widths. Bars
// of cells three times as wide as they are thick are 6 % too soft. Many of these faces coincide with a plane
// of particles, which must not produce NaN.
TEST(ElasticRegions, ClampHoldsAtAnyFacePosition) {
  for (const double length_m : gate_or_full<double>({0.4, 1.0}, {0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.2, 2.0})) {
    for (const double width_m : {0.1, length_m / 8}) {
      for (const double part : gate_or_full<double>({1.0 / 30, 0.5}, {1.0 / 30, 0.1, 1.0 / 6, 0.3, 0.5})) {
        const double ratio = sag_ratio({length_m, width_m, width_m}, (part - 0.5) * length_m, 0.0);
        const bool stubby = (1.0 - part) * length_m < 2.5 * width_m;
        EXPECT_NEAR(ratio, 1.0, stubby ? 0.09 : 0.07)
            << length_m << " by " << width_m << ", held for " << part;
      }
    }
  }
  for (const auto& [spacing_m, held_m] : {std::pair{0.02, 0.05}, {0.025, 0.0375}, {0.04, 0.06}}) {
    EXPECT_NEAR(sag_ratio({0.4, 0.1, 0.1}, held_m - 0.2, spacing_m), 1.0, 0.07)
        << spacing_m << ", " << held_m;
  }
}

// The few particles of a short clamp must not rotate the lattice, and a single held particle must not act as
// a hinge.
TEST(ElasticRegions, ShortClampOfSlenderBarIsNotAHinge) {
  EXPECT_NEAR(sag_ratio({2.4, 0.1, 0.1}, -1.15, 0.0), 1.0, 0.07);
  EXPECT_NEAR(sag_ratio({1.2, 0.05, 0.05}, -0.59, 0.0), 1.0, 0.07);
  EXPECT_NEAR(sag_ratio({0.4, 0.01, 0.01}, -0.19, 0.0), 1.0, 0.07);
}

// Bodies thinner than a voxel. Their particles lie on their faces, so boxes around the particles do not
// represent the section.
TEST(ElasticRegions, PlatesAndRodsBendLikeBeams) {
  for (const Vector3d& size_m : {Vector3d(0.5, 0.01, 0.5), Vector3d(0.5, 0.02, 0.1),
                                 Vector3d(0.4, 0.01, 0.01), Vector3d(0.4, 0.02, 0.02)}) {
    EXPECT_NEAR(sag_ratio(size_m, -0.4 * size_m.x(), 0.0, 0.0), 1.0, 0.07) << size_m.transpose();
  }
}

// A contact point on the held face has almost no weight on free nodes.
TEST(ElasticRegions, ClampMayOverlapACollider) {
  ElasticBodyDescription bar = mesh_bar({0.4, 0.1, 0.1}, 1e5, 0.3);
  bar.world_from_object.position_m.y() = 0.049;
  bar.regions.push_back(clamp_to(-0.16));
  Stage stage;
  stage.gravity_m_s2 = test::kGravity;
  stage.make(bar);
  stage.add_floor();
  stage.run(1.0);
  EXPECT_TRUE(test::all_finite(*stage.body));
  EXPECT_LT(stage.body->bounds_m().max().y(), 0.15);
}

// A body sleeps until its region moves, and stays awake during the motion, however slow.
TEST(ElasticRegions, SleepingBodyWakesWhenItsRegionMoves) {
  DisplacementRamp late, slow;
  late.displacement_m = slow.displacement_m = {0.004, 0, 0};
  late.start_s = 2.0;
  late.end_s = 2.5;
  slow.end_s = 30.0;
  HalfSinePulse pulse;
  pulse.displacement_m = {0, 0.01, 0};
  pulse.start_s = 2.0;
  pulse.width_s = 1.0;
  ConstantVelocity carried;
  carried.velocity_m_s = {0.004, 0, 0};
  carried.start_s = 2.0;
  carried.end_s = 3.0;
  AffineRamp stretch;
  stretch.matrix(0, 0) = 1.02;
  stretch.start_s = 2.0;
  stretch.end_s = 2.5;
  struct Case {
    RegionMotion motion;
    double at_s, seconds;
  };
  for (const Case& one : {Case{late, 2.5, 1.9}, Case{slow, 30.0, 0.0}, Case{pulse, 2.5, 1.9},
                          Case{carried, 3.0, 1.9}, Case{stretch, 2.5, 1.9}}) {
    ElasticBodyDescription bar = mesh_bar({0.4, 0.1, 0.1}, 1e5, 0.0);
    bar.material.loss_factor = 1.0;
    bar.regions.push_back(clamp_to(-0.15));
    BodyRegion grip;
    grip.name = "grip";
    grip.min_m = {0.15, -9, -9};
    grip.max_m = {9, 9, 9};
    grip.motion = one.motion;
    bar.regions.push_back(grip);
    Stage stage;
    stage.make(bar, make_elastic_body, true);
    stage.run(one.seconds);
    EXPECT_EQ(stage.body->asleep(), one.seconds > 0.0);
    stage.run(one.at_s - one.seconds);
    const Vector3d end(0.2, 0.0, 0.0), target = moved_point(one.motion, end, one.at_s);
    EXPECT_LT((stage.body->world_point(end) - target).norm(), 1e-5) << target.transpose();
    stage.run(6.0);
    EXPECT_TRUE(stage.body->asleep());
  }
}

// A slow vibration is stationary at its extremes for seconds. The bar must not fall asleep there.
TEST(ElasticRegions, HeldBodySleepsAtItsRestPosition) {
  ElasticBodyDescription bar = mesh_bar({1.0, 0.05, 0.05}, 1e5, 0.0);
  bar.regions.push_back(clamp_to(-0.45));
  BodyRegion pull;
  pull.min_m = {0.45, -9, -9};
  pull.max_m = {9, 9, 9};
  pull.traction_pa = {0, -0.073, 0};
  bar.regions.push_back(pull);
  const auto sag_m = [&](double loss_factor, bool may_sleep) {
    bar.material.loss_factor = loss_factor;
    Stage stage;
    stage.make(bar, make_elastic_body, may_sleep);
    for (double t = 0.0; t < 200.0 && !stage.body->asleep(); t += 1.0) stage.run(1.0);
    EXPECT_EQ(stage.body->asleep(), may_sleep);
    return -stage.body->world_point({0.5, 0, 0}).y();
  };
  const double settled_m = sag_m(1.0, false);
  EXPECT_NEAR(sag_m(0.1, true) / settled_m, 1.0, 0.01);
  EXPECT_NEAR(sag_m(1.0, true) / settled_m, 1.0, 0.01);
}

// A NaN force is the simplest way to invalidate the state of a body.
TEST(ElasticRegions, InvalidBodyIsResetAndReported) {
  for (const bool held : {false, true}) {
    ElasticBodyDescription bar = mesh_bar({0.4, 0.1, 0.1}, 1e5, 0.3);
    bar.velocity_m_s = held ? Vector3d::Zero() : Vector3d(1, 0, 0);
    if (held) bar.regions.push_back(clamp_to(-0.16));
    Stage stage;
    stage.gravity_m_s2 = held ? test::kGravity : test::kNoGravity;
    stage.make(bar, make_elastic_body, true);
    stage.run(0.5);
    const Vector3d before = stage.body->centre_m();
    stage.forces.push_back({{0.2, 0, 0}, Vector3d::Constant(NAN)});
    stage.frame();
    stage.forces.clear();
    EXPECT_TRUE(test::all_finite(*stage.body));
    EXPECT_EQ(stage.body->accuracy().recovery_count, 1);
    EXPECT_LT((stage.body->centre_m() - before).norm(), held ? 0.2 : 1e-6);
    EXPECT_TRUE(stage.body->velocity_m_s().isZero());
    stage.run(1.0);
    EXPECT_TRUE(test::all_finite(*stage.body));
    EXPECT_EQ(stage.body->accuracy().recovery_count, 1);
  }
}

}  // namespace
}  // namespace livegs
