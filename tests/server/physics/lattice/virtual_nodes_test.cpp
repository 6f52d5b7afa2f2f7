// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/skin/kernels/rest_bodies.h"
#include "physics/lattice/build_lattice.h"
#include "scenes/elastic_bodies.h"
#include "server/physics/lattice/lattice_statics.h"
#include "skin/kernels/cell_fill.h"
#include "skin/skin_kernels.h"

// A fork: a palm 70 mm wide and 40 mm high with two fingers 30 mm wide, 30 mm deep and 100 mm high, 10 mm
// apart. In cells of 25 mm both fingers share the middle column, 0.4 cell apart.

namespace livegs {
namespace {

using test::Vector3d;

constexpr double kCell_m = 0.025, kSlit_m = 0.01, kPalm_m = 0.04, kHeight_m = 0.14;

bool in_slit(const Vector3d& p) { return std::abs(p.x()) < 0.5 * kSlit_m && p.y() > kPalm_m; }

ParticleSet fork_particles(double spacing_m) {
  const ParticleSet block = test::particle_grid({0.07, kHeight_m, 0.03}, spacing_m);
  ParticleSet fork;
  fork.spacing_m = spacing_m;
  for (const Vector3d& centred : block.positions_m) {
    const Vector3d p = centred + Vector3d(0, 0.5 * kHeight_m, 0);  // the palm is on y = 0
    if (!in_slit(p)) fork.positions_m.push_back(p);
  }
  fork.volumes_m3.assign(fork.positions_m.size(), std::pow(spacing_m, 3));
  fork.on_surface.assign(fork.positions_m.size(), false);
  return fork;
}

Lattice fork_lattice(double cell_m) {
  return build_lattice(measure_extent(fork_particles(0.01)), cell_m, {});
}

TEST(VirtualNodes, BlockHasNoVirtualNodes) {
  for (const double width : {0.02, 0.025, 0.03}) {
    const Lattice lattice =
        build_lattice(measure_extent(test::particle_grid({0.1, 0.1, 0.1}, 0.01)), width, {});
    EXPECT_FALSE(lattice.has_virtual_cells);
    std::set<std::array<int, 3>> places;
    for (const auto& n : lattice.node_coordinates) EXPECT_TRUE(places.insert({n.x(), n.y(), n.z()}).second);
  }
}

TEST(VirtualNodes, FingersHaveSeparateNodesAboveThePalm) {
  const Lattice lattice = fork_lattice(kCell_m);
  ASSERT_TRUE(lattice.has_virtual_cells);
  // The cells of the two fingers use disjoint nodes above the palm.
  std::set<uint32_t> nodes[2];
  double highest_shared_m = 0.0;
  for (const LatticeCell& cell : lattice.cells) {
    const Vector3d low = lattice.node_position_m(cell.nodes[0]);
    if (low.y() < kPalm_m) continue;
    const Vector3d centre = low + 0.5 * kCell_m * (cell.centroid + Vector3d::Ones());
    ASSERT_GT(std::abs(centre.x()), 0.5 * kSlit_m);  // the material of one finger only
    for (const uint32_t node : cell.nodes) nodes[centre.x() > 0.0].insert(node);
  }
  for (const uint32_t node : nodes[0]) {
    if (nodes[1].count(node))
      highest_shared_m = std::max(highest_shared_m, lattice.node_position_m(node).y());
  }
  // Joined at most up to the lower face of the first row of cells wholly above the palm.
  double first_row_m = 1.0;
  for (const LatticeCell& cell : lattice.cells) {
    const double y = lattice.node_position_m(cell.nodes[0]).y();
    if (y >= kPalm_m) first_row_m = std::min(first_row_m, y);
  }
  EXPECT_LE(highest_shared_m, first_row_m + 1e-9);
}

TEST(VirtualNodes, VolumeAndFirstMomentAreConserved) {
  const Lattice lattice = fork_lattice(kCell_m);
  const ParticleSet fork = fork_particles(0.01);
  Vector3d wanted = Vector3d::Zero(), found = Vector3d::Zero();
  double volume = 0.0, found_volume = 0.0;
  for (size_t i = 0; i < fork.positions_m.size(); ++i) {
    wanted += fork.volumes_m3[i] * fork.positions_m[i];
    volume += fork.volumes_m3[i];
  }
  for (size_t i = 0; i < lattice.node_volumes_m3.size(); ++i) {
    found += lattice.node_volumes_m3[i] * lattice.node_position_m(i);
    found_volume += lattice.node_volumes_m3[i];
  }
  EXPECT_NEAR(found_volume / volume, 1.0, 1e-12);
  EXPECT_NEAR((found - wanted).norm() / volume, 0.0, 1e-6);  // the lower bound of node masses shifts it
}

TEST(VirtualNodes, CellsOfOneColourShareNoNode) {
  const Lattice lattice = fork_lattice(kCell_m);
  ASSERT_EQ(lattice.colour_begin[kLatticeColours], lattice.cells.size());
  EXPECT_GT(lattice.cells.size(), lattice.colour_begin[8]);  // the finger roots need more than eight colours
  for (int colour = 0; colour < kLatticeColours; ++colour) {
    std::set<uint32_t> nodes;
    for (uint32_t i = lattice.colour_begin[colour]; i < lattice.colour_begin[colour + 1]; ++i) {
      for (const uint32_t node : lattice.cells[i].nodes) EXPECT_TRUE(nodes.insert(node).second);
    }
  }
}

TEST(VirtualNodes, PointsFollowTheirFinger) {
  const Lattice lattice = fork_lattice(kCell_m);
  for (double y = 0.08; y < kHeight_m; y += 0.003) {
    for (const double x : {-0.034, -0.02, -0.0055, 0.0055, 0.02, 0.034}) {
      const LatticeCell& cell = lattice.cells[lattice.embed({x, y, 0.004}).cell];
      const double centre =
          lattice.node_position_m(cell.nodes[0]).x() + 0.5 * kCell_m * (cell.centroid.x() + 1.0);
      EXPECT_GT(centre * x, 0.0) << "x " << x << " y " << y;
    }
  }
}

// Displacements of both fingertips under a sideways force on the left one, with the lower end of the palm
// held.
struct Tips {
  double pulled_m, other_m;
};
Tips pull_left_finger(const Lattice& lattice) {
  const IsotropicMaterial material{1e5, 0.3};
  std::vector<bool> held(lattice.node_coordinates.size());
  for (size_t i = 0; i < held.size(); ++i) held[i] = lattice.node_position_m(i).y() < 0.0025;
  const test::LatticeStatics statics(lattice, 1000.0, held, [&](const LatticeCell& cell) {
    return test::cell_matrix(cell, lattice.cell_width_m, material);
  });
  EXPECT_TRUE(statics.positive());
  const EmbeddedPoint tip = lattice.embed({-0.02, 0.135, 0.0});
  const auto weights = trilinear_weights(tip.local);
  std::vector<test::NodeLoad> loads;
  for (int c = 0; c < 8; ++c)
    loads.push_back({lattice.cells[tip.cell].nodes[c], weights[c] * Vector3d(-0.1, 0, 0)});
  const auto moved = statics.solve(loads);
  return {-test::moved(lattice, moved, {-0.02, 0.135, 0.0}).x(),
          -test::moved(lattice, moved, {0.02, 0.135, 0.0}).x()};
}

TEST(VirtualNodes, FingersInteractOnlyThroughThePalm) {
  // Reference: 5 mm cells, which leave the slit empty and need no virtual nodes.
  const Tips fine = pull_left_finger(fork_lattice(0.005));
  const Tips coarse = pull_left_finger(fork_lattice(kCell_m));
  EXPECT_GT(fine.pulled_m, 0.0);
  EXPECT_NEAR(coarse.pulled_m / fine.pulled_m, 1.0, 0.2) << coarse.pulled_m << " " << fine.pulled_m;
  // The fingers separate at the first lattice plane above the palm, 5 mm up. The palm is two cells high, so
  // its rotation at their roots is coarse. If the fingers were connected, both tips would move equally.
  EXPECT_NEAR(coarse.other_m / coarse.pulled_m, fine.other_m / fine.pulled_m, 0.1);
}

TEST(VirtualNodes, KernelsFollowTheirFinger) {
  const Lattice lattice = fork_lattice(kCell_m);
  RestBody rest;
  rest.kind = DriverKind::Lattice;
  rest.object_from_lattice = lattice.object_from_lattice;
  rest.cell_width_m = lattice.cell_width_m;
  rest.node_coordinates = lattice.node_coordinates;
  for (const LatticeCell& cell : lattice.cells) {
    rest.cells.push_back(cell.nodes);
    rest.cell_fills.push_back(cell.fill);
  }
  // Kernels on the surface of both fingers, also inside the slit, some just outside the material.
  std::vector<Vector3d> points;
  for (double y = 0.08; y < kHeight_m; y += 0.003) {
    for (const double x : {0.0045, 0.0055, 0.02, 0.0355}) {
      points.push_back({-x, y, 0.0152});
      points.push_back({x, y, 0.0152});
    }
  }
  const GaussianAsset asset = testing::kernels_at(rest, points, 1);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);

  // Every node of the left finger above 60 mm moves by 20 mm.
  ObjectDrivers drivers = testing::rest_drivers(rest);
  for (const LatticeCell& cell : lattice.cells) {
    const Vector3d low = lattice.node_position_m(cell.nodes[0]);
    if (low.x() + 0.5 * kCell_m * (cell.centroid.x() + 1.0) > 0.0) continue;
    for (const uint32_t node : cell.nodes) {
      const Vector3d at = lattice.node_position_m(node);
      if (at.y() > 0.06) drivers.positions_m[node] = (at + Vector3d(0, 0, 0.02)).cast<float>();
    }
  }
  PosedKernels kernels;
  skin_kernels(asset, rest, *bindings, drivers, kernels);
  for (size_t k = 0; k < points.size(); ++k) {
    const double moved = kernels.positions_m[k].z() - points[k].z();
    EXPECT_NEAR(moved, points[k].x() < 0.0 ? 0.02 : 0.0, 1e-6) << points[k].transpose();
  }
}

TEST(VirtualNodes, DisconnectedPartsStayOneBody) {
  // Two blocks separated by one missing row of voxels count as sampling noise, not as fingers.
  ParticleSet halves;
  for (const Vector3d& p : test::particle_grid({0.11, 0.05, 0.05}, 0.01).positions_m) {
    if (std::abs(p.x()) > 0.006) halves.positions_m.push_back(p);
  }
  halves.spacing_m = 0.01;
  halves.volumes_m3.assign(halves.positions_m.size(), 1e-6);
  halves.on_surface.assign(halves.positions_m.size(), false);
  const BodyExtent extent = measure_extent(halves);
  const Lattice lattice = build_lattice(extent, 0.025, {});
  EXPECT_FALSE(lattice.has_virtual_cells);
  std::map<uint32_t, uint32_t> part;
  const auto links = link_boxes(extent, 0.025);
  EXPECT_TRUE(std::is_sorted(links.begin(), links.end()));
  EXPECT_GT(links.size(), 0u);
}

TEST(VirtualNodes, JitteredBlockStaysWhole) {
  ParticleSet block = test::particle_grid({0.1, 0.1, 0.1}, 0.01);
  std::mt19937_64 random(3);
  for (Vector3d& p : block.positions_m) p += testing::uniform3(random, -0.003, 0.003);
  const Lattice lattice = build_lattice(measure_extent(block), 0.025, {});
  EXPECT_FALSE(lattice.has_virtual_cells);
}

TEST(CellFill, MarksThePartsThatABoxOverlaps) {
  using Eigen::Vector3f;
  EXPECT_EQ(fill_of_box(Vector3f::Zero(), Vector3f::Ones()), kFullCell);
  EXPECT_EQ(fill_of_box(Vector3f::Zero(), Vector3f::Constant(0.25f)), 1u);
  EXPECT_EQ(fill_of_box({0.3f, 0.0f, 0.0f}, {0.45f, 0.25f, 0.25f}), 2u);
  EXPECT_EQ(fill_of_box({0.3f, 0.0f, 0.0f}, {0.55f, 0.25f, 0.5f}), 6u | 6u << 16);
  EXPECT_EQ(fill_of_box(Vector3f::Ones(), Vector3f::Ones()), uint64_t{1} << 63);
}

TEST(CellFill, DistanceIsToTheNearestPart) {
  const uint64_t corner = fill_of_box(Eigen::Vector3f::Zero(), Eigen::Vector3f::Constant(0.25f));
  EXPECT_EQ(fill_distance(corner, {0.1f, 0.2f, 0.0f}).to_material, 0.0f);
  EXPECT_NEAR(fill_distance(corner, {0.75f, 0.1f, 0.1f}).to_material, 0.25f, 1e-6);
  EXPECT_EQ(fill_distance(corner, {0.75f, 0.1f, 0.1f}).to_cell, 0.0f);
  EXPECT_NEAR(fill_distance(kFullCell, {1.5f, 0.5f, -1.0f}).to_cell, 1.25f, 1e-6);
  EXPECT_NEAR(fill_distance(0, {1.5f, 0.5f, -1.0f}).to_material, 1.25f, 1e-6);
}

}  // namespace
}  // namespace livegs
