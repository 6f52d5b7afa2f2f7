// SPDX-License-Identifier: Apache-2.0
// Bodies as scenes create them: a mesh sampled with the default spacing, or a list of irregular points. Whole
// voxels end before or after the faces, and points fill one cell with eight and the next with seven. The
// modulus and a patch test must still be those of the body.
#include <algorithm>
#include <random>

#include "geometry/field/sample_particles.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/surface/shape_mesh.h"
#include "known_gaps.h"
#include "physics/lattice/lattice.h"
#include "scenes/elastic_bodies.h"

namespace livegs::test {
namespace {

// Strain: the slope of the mean displacement along x over the middle half.
double strain_along(const ElasticBody& body, const ParticleSet& rest, double half_length_m) {
  const std::vector<ParticleState> now = body.particles();
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (size_t i = 0; i < now.size(); ++i) {
    const double x = rest.positions_m[i].x();
    if (std::abs(x) > 0.5 * half_length_m) continue;
    n += 1;
    sx += x;
    sy += now[i].position_m.x();
    sxx += x * x;
    sxy += x * now[i].position_m.x();
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx) - 1.0;
}

// Strain of a plate: the displacement between its faces across x over their distance.
double strain_between(const ElasticBody& body, const Vector3d& size) {
  double sum = 0.0;
  for (const double y : {-0.25, 0.0, 0.25}) {
    for (const double z : {-0.25, 0.0, 0.25}) {
      const Vector3d face(0.5 * size.x(), y * size.y(), z * size.z());
      sum += (body.world_point(face) - body.world_point(face - Vector3d(size.x(), 0, 0))).x() / 9.0;
    }
  }
  return sum / size.x() - 1.0;
}

// E_app / E of a bar along x under a traction of 0.5 % of E over its true section at both ends.
double apparent_modulus(const ElasticBodyDescription& described, const Vector3d& size, double rate_hz,
                        bool plate = false) {
  ElasticBodyDescription bar = described;
  bar.material.loss_factor = 2.0;
  Stage stage;
  stage.rate_hz = rate_hz;
  stage.make(bar);
  const double stress_pa = 0.005 * bar.material.youngs_modulus_pa;
  constexpr int n = 8;
  const double force_n = stress_pa * size.y() * size.z() / (n * n);
  for (const double side : {-1.0, 1.0}) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        stage.forces.push_back(
            {{0.5 * side * size.x(), ((j + 0.5) / n - 0.5) * size.y(), ((k + 0.5) / n - 0.5) * size.z()},
             {side * force_n, 0, 0}});
      }
    }
  }
  stage.run(20.0 * size.x() / std::sqrt(bar.material.youngs_modulus_pa / 1000.0) + 1.0);
  // Neo-Hookean, to second order in the strain: at most 0.5 % from linear at 0.5 % strain.
  const double strain =
      plate ? strain_between(*stage.body, size) : strain_along(*stage.body, bar.particles, 0.5 * size.x());
  return stress_pa / bar.material.youngs_modulus_pa / strain;
}

TEST(SampledBody, BoxesOfAnySizeShowTheirModulus) {
  for (const Vector3d& size : {Vector3d(0.4, 0.1, 0.1), Vector3d(0.3, 0.07, 0.07), Vector3d(1.0, 0.3, 0.3),
                               Vector3d(0.35, 0.13, 0.09)}) {
    for (const double rate_hz : kRates_hz) {
      const auto bar = describe(sample_particles(box_mesh(size)), 1e5, 0.3);
      EXPECT_NEAR(apparent_modulus(bar, size, rate_hz), 1.0, 0.05)
          << size.transpose() << ", " << rate_hz << " Hz";
    }
  }
}

// Cubes two or four cells long, as with large cells or coarse particles: the apparent modulus matches the
// reported one.
TEST(SampledBody, CubesOfFewCellsShowTheReportedModulus) {
  const Vector3d size = Vector3d::Constant(0.2);
  for (const int cells : {2, 4}) {
    for (const double rate_hz : kRates_hz) {
      for (const double youngs_modulus_pa : {1e4, 1e5, 1e6}) {
        auto cube = describe(sample_particles(box_mesh(size)), youngs_modulus_pa, 0.3);
        cube.cell_width_m = size.x() / cells;
        SCOPED_TRACE(testing::Message()
                     << cells << " cells, " << youngs_modulus_pa << " Pa, " << rate_hz << " Hz");
        Stage stage;
        stage.rate_hz = rate_hz;
        stage.make(cube);
        const ElasticAccuracy accuracy = stage.body->accuracy();
        const double modulus = apparent_modulus(cube, size, rate_hz);
        if (accuracy.band == ElasticBand::Exact) {
          EXPECT_NEAR(modulus, 1.0, 0.05);
        } else {
          EXPECT_GT(modulus, 0.99 * accuracy.modulus_ratio_low);
          EXPECT_LT(modulus, 1.01 * accuracy.modulus_ratio_high);
          EXPECT_LT(accuracy.modulus_ratio_high, 1.3);
        }
      }
    }
  }
}

// A plate one cell thick is too stiff across, because no neighbouring cell shares the correction of the pass.
// The reported ratio must match.
TEST(SampledBody, PlateShowsTheReportedModulusAcross) {
  double worst = 0.0;
  for (const double thickness_m : {0.03, 0.05}) {
    for (const double rate_hz : kRates_hz) {
      for (const double youngs_modulus_pa : {1e4, 1e5}) {
        const Vector3d size(thickness_m, 0.3, 0.3);
        const auto plate = describe(sample_particles(box_mesh(size)), youngs_modulus_pa, 0.3);
        SCOPED_TRACE(testing::Message()
                     << thickness_m << " m, " << youngs_modulus_pa << " Pa, " << rate_hz << " Hz");
        Stage stage;
        stage.rate_hz = rate_hz;
        stage.make(plate);
        const ElasticAccuracy accuracy = stage.body->accuracy();
        const double modulus = apparent_modulus(plate, size, rate_hz, true);
        EXPECT_GT(modulus, 0.95 * accuracy.modulus_ratio_low);
        EXPECT_LT(modulus, 1.02 * accuracy.modulus_ratio_across);
        report_gap("sampled.plate_modulus_stated", accuracy.modulus_ratio_across);
        worst = std::max(worst, modulus);
      }
    }
  }
  report_gap("sampled.plate_modulus", worst);
}

// Rods and plates thinner than a voxel: the lattice has as many connected components as the mesh. Corner
// points alone would split a rod or plate.
TEST(SampledBody, ThinShapesHangTogether) {
  struct Case {
    const char* name;
    TriangleMesh mesh;
    double spacing_m;
  };
  const std::vector<Case> cases = {{"rod, 10 mm", box_mesh({0.4, 0.01, 0.01}), 0.0},
                                   {"rod, 4 mm", box_mesh({0.4, 0.004, 0.004}), 0.0},
                                   {"rod, 1 mm", box_mesh({0.4, 0.001, 0.001}), 0.0},
                                   {"round rod, 5 mm", cylinder_mesh(0.0025, 0.4), 0.0},
                                   {"plate, 10 mm", box_mesh({1.0, 0.01, 1.0}), 0.0},
                                   {"plate, 3 mm", box_mesh({0.3, 0.003, 0.2}), 0.0},
                                   {"plate, 1 mm", box_mesh({0.3, 0.001, 0.3}), 0.0},
                                   {"disc, 4 mm", cylinder_mesh(0.15, 0.004), 0.0},
                                   {"ball in one voxel", sphere_mesh(0.02, 3), 0.1},
                                   {"bar of half a voxel", box_mesh({0.4, 0.05, 0.05}), 0.1}};
  for (const Case& one : cases) {
    const ParticleSet particles = sample_particles(one.mesh, kDefaultSamplingDensity, one.spacing_m);
    // Points must be taken from both faces of a plate. Points of one face only would shift the centre of
    // mass.
    const Eigen::AlignedBox3d bounds = mesh_bounds_m(one.mesh);
    Eigen::AlignedBox3d sampled;
    Vector3d centre_m = Vector3d::Zero();
    double volume_m3 = 0.0;
    for (size_t i = 0; i < particles.positions_m.size(); ++i) {
      sampled.extend(particles.positions_m[i]);
      centre_m += particles.volumes_m3[i] * particles.positions_m[i];
      volume_m3 += particles.volumes_m3[i];
    }
    const Vector3d aside = (centre_m / volume_m3).cwiseQuotient(bounds.sizes());
    if (particles.surface_carries) {
      report_gap("sampled.thin_centre", aside.cwiseAbs().maxCoeff());  // the 10 mm rod has few points
      EXPECT_GT(sampled.sizes().cwiseQuotient(bounds.sizes()).minCoeff(), 0.9) << one.name;
    }
    for (const double youngs_modulus_pa : {1e5, 1e7}) {
      Stage stage;
      stage.make(describe(particles, youngs_modulus_pa, 0.3));
      const Lattice lattice =
          build_lattice(measure_extent(particles), stage.body->accuracy().cell_width_m, {});
      EXPECT_EQ(piece_count(lattice), 1) << one.name << ", " << particles.positions_m.size()
                                         << " particles, cells " << lattice.cell_width_m << " m";
    }
  }
}

// A bar held at one end and displaced by 4 mm at the other. A grip of less than half a voxel must hold more
// than the corners. Material within a grip may stretch or not: either length is right.
TEST(SampledBody, GripOfAnyThicknessHolds) {
  const Vector3d size(0.4, 0.1, 0.1);
  for (const double spacing_m : {0.0, 0.025}) {
    for (const double grip_m : {0.001, 0.005, 0.01, 0.012, 0.02, 0.03, 0.06}) {
      ElasticBodyDescription bar =
          describe(sample_particles(box_mesh(size), kDefaultSamplingDensity, spacing_m), 1e5, 0.3);
      bar.material.loss_factor = 2.0;
      const Vector3d half = 0.51 * size;
      BodyRegion held, drawn;
      held.name = "held";
      held.min_m = -half;
      held.max_m = Vector3d(-0.5 * size.x() + grip_m, half.y(), half.z());
      held.fixed = true;
      drawn.name = "drawn";
      drawn.min_m = Vector3d(0.5 * size.x() - grip_m, -half.y(), -half.z());
      drawn.max_m = half;
      drawn.motion = DisplacementRamp{{0.004, 0, 0}, 0.0, 0.5};
      bar.regions = {held, drawn};
      Stage stage;
      stage.make(bar);
      stage.run(2.0);
      const Vector3d a(-0.1, 0.01, 0.01), b(0.1, 0.01, 0.01);
      const double strain = (stage.body->world_point(b) - stage.body->world_point(a)).x() / 0.2 - 1.0;
      EXPECT_GT(strain, 0.9 * 0.004 / size.x()) << grip_m << " m, spacing " << spacing_m;
      EXPECT_LT(strain, 1.1 * 0.004 / (size.x() - 2.0 * grip_m)) << grip_m << " m, spacing " << spacing_m;
    }
  }
}

// Particles of a grid, each moved by up to 0.3 of the spacing along each axis.
ParticleSet jittered(const Vector3d& size, double spacing) {
  ParticleSet set = particle_grid(size, spacing);
  std::mt19937_64 random(7);
  const auto step = [&] { return 0.6 * spacing * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5); };
  for (Vector3d& point : set.positions_m) point += Vector3d(step(), step(), step());
  set.on_surface.assign(set.positions_m.size(), true);  // as a scene treats a list of points
  return set;
}

// A ball filled with particles on a grid of 10 mm.
ParticleSet gridded_ball(double radius) {
  const ParticleSet cube = particle_grid(Vector3d::Constant(2.0 * radius + 0.02), 0.01);
  ParticleSet ball;
  ball.spacing_m = cube.spacing_m;
  for (const Vector3d& point : cube.positions_m) {
    if (point.norm() < radius) ball.positions_m.push_back(point);
  }
  ball.volumes_m3.assign(ball.positions_m.size(), 1e-6);
  ball.on_surface.assign(ball.positions_m.size(), true);
  return ball;
}

TEST(SampledBody, JitteredBarShowsItsModulus) {
  const Vector3d size(0.4, 0.1, 0.1);
  for (const double rate_hz : kRates_hz) {
    EXPECT_NEAR(apparent_modulus(describe(jittered(size, 0.0125), 1e5, 0.3), size, rate_hz), 1.0, 0.05)
        << rate_hz;
  }
}

// The outer particles are moved by a matrix. At a depth of one cell or more the deformation gradient becomes
// that matrix.
TEST(SampledBody, PassesThePatchTest) {
  Matrix3d stretch = Vector3d(1.5, 1.0, 0.8).asDiagonal(), shear = Matrix3d::Identity();
  shear(0, 1) = 1.0;
  struct Case {
    const char* name;
    ParticleSet particles;
    std::function<double(const Vector3d&)> depth_m;  // depth below the surface
  };
  const double radius = 0.1, half = 0.1;
  const auto in_cube = [&](const Vector3d& p) { return half - p.cwiseAbs().maxCoeff(); };
  const std::vector<Case> cases = {
      {"ball of points", gridded_ball(radius), [&](const Vector3d& p) { return radius - p.norm(); }},
      {"jittered block", jittered(Vector3d::Constant(2 * half), 0.0125), in_cube},
      {"sphere", sample_particles(sphere_mesh(radius, 3)),
       [&](const Vector3d& p) { return radius - p.norm(); }},
      {"box", sample_particles(box_mesh(Vector3d::Constant(2 * half))), in_cube}};
  for (const Case& one : cases) {
    for (const Matrix3d& matrix : {stretch, shear}) {
      for (const double rate_hz : kRates_hz) {
        ElasticBodyDescription body = describe(one.particles, 1e4, 0.3);
        body.material.loss_factor = 2.0;
        body.material.plasticity = 0.0;  // a strain of 0.5 is beyond yield
        AffineRamp ramp;
        ramp.matrix = matrix;
        ramp.end_s = 1.0;
        BodyRegion boundary;
        boundary.boundary = true;
        boundary.motion = ramp;
        body.regions.push_back(boundary);
        Stage stage;
        stage.rate_hz = rate_hz;
        stage.substeps = 8;
        stage.make(body);
        stage.run(2.5);
        const double cell_m = stage.body->accuracy().cell_width_m;
        const std::vector<ParticleState> now = stage.body->particles();
        double worst = 0.0;
        int inside = 0;
        for (size_t i = 0; i < now.size(); ++i) {
          if (one.depth_m(one.particles.positions_m[i]) < cell_m) continue;
          ++inside;
          worst = std::max(worst, (now[i].deformation_gradient - matrix).norm() / matrix.norm());
        }
        EXPECT_GT(inside, 0) << one.name;
        EXPECT_LT(worst, 0.02) << one.name << ", " << rate_hz << " Hz, of " << inside;
      }
    }
  }
}

}  // namespace
}  // namespace livegs::test
