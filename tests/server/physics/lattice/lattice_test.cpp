// SPDX-License-Identifier: Apache-2.0
#include "physics/lattice/lattice.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "physics/elastic/resolution/lattice_resolution.h"
#include "scenes/elastic_bodies.h"

namespace livegs {
namespace {

using test::particle_grid;
using test::Vector3d;

Lattice lattice_of(const ParticleSet& particles, double width, std::vector<BodyRegion> regions = {}) {
  return build_lattice(measure_extent(particles), width, regions);
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

TEST(Lattice, FullCellsAreFull) {
  const Lattice lattice = lattice_of(particle_grid({0.4, 0.1, 0.1}, 0.0125), 0.025);
  EXPECT_EQ(lattice.cells.size(), 16u * 4 * 4);
  EXPECT_EQ(lattice.node_coordinates.size(), 17u * 5 * 5);
  for (const LatticeCell& cell : lattice.cells) {
    EXPECT_NEAR(cell.volume_m3, 0.025 * 0.025 * 0.025, 1e-17);
    EXPECT_NEAR(cell.centroid.norm(), 0.0, 1e-12);
    EXPECT_NEAR((cell.spread - Vector3d::Ones()).norm(), 0.0, 1e-12);
  }
  EXPECT_NEAR(sum(lattice.node_volumes_m3), 0.004, 1e-15);
}

TEST(Lattice, ParticlesOffTheLatticeStillFillCells) {
  // Cells are 1.5 particles wide, so cell faces cut particles in half.
  const Lattice lattice = lattice_of(particle_grid({0.3, 0.15, 0.15}, 0.025), 0.0375);
  EXPECT_EQ(lattice.cells.size(), 8u * 4 * 4);
  for (const LatticeCell& cell : lattice.cells) {
    EXPECT_NEAR(cell.volume_m3 / std::pow(0.0375, 3), 1.0, 1e-12);
    EXPECT_NEAR((cell.spread - Vector3d::Ones()).norm(), 0.0, 1e-12);
  }
}

TEST(Lattice, SheetKeepsItsThicknessInTheSpread) {
  // One layer of 10 mm in cells of 25 mm: the variance across is (10/25)² of that of a full cell.
  const Lattice lattice = lattice_of(particle_grid({0.2, 0.2, 0.01}, 0.01), 0.025);
  EXPECT_EQ(lattice.cells.size(), 64u);
  for (const LatticeCell& cell : lattice.cells) {
    EXPECT_NEAR(cell.spread.x(), 1.0, 1e-12);
    EXPECT_NEAR(cell.spread.z(), 0.16, 1e-12);
  }
}

TEST(Lattice, ColoursShareNoNode) {
  const Lattice lattice = lattice_of(particle_grid({0.2, 0.15, 0.1}, 0.025), 0.05);
  ASSERT_EQ(lattice.colour_begin[8], lattice.cells.size());
  for (int colour = 0; colour < 8; ++colour) {
    std::set<uint32_t> nodes;
    for (uint32_t i = lattice.colour_begin[colour]; i < lattice.colour_begin[colour + 1]; ++i) {
      for (const uint32_t node : lattice.cells[i].nodes) EXPECT_TRUE(nodes.insert(node).second);
    }
  }
}

TEST(Lattice, EmbeddedPointsFollowFromTheirWeights) {
  const ParticleSet particles = particle_grid({0.2, 0.1, 0.1}, 0.02);
  const Lattice lattice = lattice_of(particles, 0.04);
  std::vector<Vector3d> points = particles.positions_m;
  points.push_back({0.11, 0.055, -0.055});  // slightly outside
  for (const Vector3d& point : points) {
    const EmbeddedPoint embedded = lattice.embed(point);
    const auto weights = trilinear_weights(embedded.local);
    Vector3d back = Vector3d::Zero();
    for (int c = 0; c < 8; ++c)
      back += weights[c] * lattice.node_position_m(lattice.cells[embedded.cell].nodes[c]);
    EXPECT_NEAR((back - point).norm(), 0.0, 1e-15);
  }
}

TEST(Lattice, LiesAlongARotatedBar) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Vector3d(1, 2, 3).normalized()));
  ParticleSet particles = particle_grid({0.4, 0.12, 0.08}, 0.02);
  for (Vector3d& p : particles.positions_m) p = turn * p;
  const BodyExtent extent = measure_extent(particles);
  const Vector3d size = extent.max_m - extent.min_m;
  EXPECT_NEAR(size.minCoeff(), 0.08, 1e-9);
  EXPECT_NEAR(size.maxCoeff(), 0.4, 1e-9);
}

TEST(Lattice, PlaneSnapsToAFixedRegion) {
  const BodyRegion clamp = fixed_box({-0.2, -0.05, -0.05}, {-0.19, 0.05, 0.05});
  const Lattice lattice = lattice_of(particle_grid({0.4, 0.1, 0.1}, 0.0125), 0.025, {clamp});
  size_t fixed = 0;
  for (const LatticeCell& cell : lattice.cells) {
    if (!cell.fixed) continue;
    ++fixed;
    EXPECT_NEAR(lattice.node_position_m(cell.nodes[7]).x(), -0.19, 1e-12);
  }
  EXPECT_EQ(fixed, 16u);
}

TEST(Lattice, PlaneSnapsToAMovedRegion) {
  BodyRegion pulled;
  pulled.min_m = {0.187, -0.05, -0.05};
  pulled.max_m = {0.2, 0.05, 0.05};
  pulled.motion = DisplacementRamp{};
  const Lattice lattice = lattice_of(particle_grid({0.4, 0.1, 0.1}, 0.0125), 0.025, {pulled});
  double nearest = 1.0;
  for (size_t i = 0; i < lattice.node_coordinates.size(); ++i) {
    nearest = std::min(nearest, std::abs(lattice.node_position_m(i).x() - 0.187));
  }
  EXPECT_NEAR(nearest, 0.0, 1e-12);
}

TEST(Lattice, MeshVerticesSetFacesAndCarryNoMass) {
  // Voxels of 30 mm leave 10 mm of a 100 mm cube unfilled; its corner vertices define the faces.
  ParticleSet particles = particle_grid(Vector3d::Constant(0.09), 0.03);
  const double share = 0.001 / (27 + 8);
  for (int c = 0; c < 8; ++c) {
    particles.positions_m.push_back(Vector3d(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1) * 0.05);
    particles.volumes_m3.push_back(share);
    particles.on_surface.push_back(true);
  }
  particles.volumes_m3.assign(35, share);
  const BodyExtent extent = measure_extent(particles);
  EXPECT_NEAR((extent.max_m - Vector3d::Constant(0.05)).norm(), 0.0, 1e-15);
  const Lattice lattice = build_lattice(extent, 0.05, {});
  for (const LatticeCell& cell : lattice.cells) EXPECT_NEAR(cell.volume_m3, 1.25e-4, 1e-15);
}

ResolutionRequest bar_request(double youngs_modulus_pa, double width_m) {
  ResolutionRequest request;
  request.size_m = {0.4, 0.1, 0.1};
  request.particle_edge_m = 0.0125;
  request.youngs_modulus_pa = youngs_modulus_pa;
  request.poisson_ratio = 0.3;
  request.density_kg_m3 = 1000;
  request.rate_hz = 60;
  request.substeps = 1;
  request.cell_width_m = width_m;
  return request;
}

TEST(LatticeResolution, SubstepsFollowTheWaveSpeed) {
  // ceil( sqrt(E/rho) / (Co* rate a) ), rho 1000, 60 Hz. Co* is 0.6 (courant_limit).
  EXPECT_EQ(choose_resolution(bar_request(1e4, 0.0125)).substeps, 8);  // 7.03
  EXPECT_EQ(choose_resolution(bar_request(1e5, 0.025)).substeps, 12);  // 11.1
  EXPECT_EQ(choose_resolution(bar_request(1e6, 0.05)).substeps, 18);   // 17.6
  EXPECT_FALSE(choose_resolution(bar_request(1e6, 0.05)).clipped);
  EXPECT_TRUE(choose_resolution(bar_request(1e6, 0.025)).clipped);  // 35.1, more than kMaxBodySubsteps
}

TEST(LatticeResolution, ClipsAtTheCapAndReportsTheCeiling) {
  const LatticeResolution resolution = choose_resolution(bar_request(1e9, 0.025));
  EXPECT_EQ(resolution.substeps, kMaxBodySubsteps);
  EXPECT_TRUE(resolution.clipped);
  EXPECT_NEAR(resolution.youngs_modulus_pa, 1000 * std::pow(0.6 * 60 * kMaxBodySubsteps * 0.025, 2), 1e-6);
  EXPECT_NEAR(resolution.courant, 0.6, 1e-12);
}

TEST(LatticeResolution, StifferBodiesGetWiderCellsBeforeClipping) {
  double width = 0.0;
  for (const double stiffness : {1e4, 1e6, 1e7, 1e9}) {
    ResolutionRequest request = bar_request(stiffness, 0.0);
    request.substeps = 4;
    const LatticeResolution resolution = choose_resolution(request);
    EXPECT_GE(resolution.cell_width_m, width);
    EXPECT_EQ(resolution.substeps % 4, 0);
    EXPECT_LE(resolution.courant, courant_limit(0.3, 0.1 / resolution.cell_width_m) + 1e-12);
    width = resolution.cell_width_m;
  }
}

// A wide thin sheet in cells of its thickness would exceed the frame budget many times.
TEST(LatticeResolution, WideThinSheetFitsTheFrameBudget) {
  ResolutionRequest request = bar_request(1e5, 0.0);
  request.substeps = 4;
  for (const double width : {0.3, 1.0, 2.0, 10.0}) {
    for (const double thickness : {1e-4, 1e-3, 2e-3, 2e-2}) {
      request.size_m = {width, thickness, width};
      request.particle_edge_m = 0.5 * thickness;
      const LatticeResolution resolution = choose_resolution(request);
      const double along = std::ceil(width / resolution.cell_width_m - 1e-6) + 1.0;
      EXPECT_LE(2.0 * along * along * resolution.substeps, 250e3) << width << " x " << thickness;
      EXPECT_EQ(resolution.over_budget, resolution.cell_width_m > 5.0001 * thickness)
          << width << " x " << thickness;
    }
  }
}

}  // namespace
}  // namespace livegs
