// SPDX-License-Identifier: Apache-2.0
#include "physics/fracture/bond_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "geometry/fracture/fracture_seeds.h"
#include "geometry/mesh/mass_properties.h"
#include "server/geometry/fracture/fracture_shapes.h"

namespace livegs {
namespace {

constexpr double kThreshold = 0.8;  // N s

VoronoiPieces cut_cup(size_t count, uint64_t seed) {
  const TriangleMesh mesh = testing::cup_mesh(48, 10);
  return cut_voronoi_pieces(mesh,
                            fracture_seeds(mesh, {.count = count, .seed = seed, .impacts_m = {}}).value())
      .value();
}

size_t group_count(const BondGraph& graph) {
  const auto groups = connected_groups(graph);
  return std::set(groups.begin(), groups.end()).size();
}

BondGraph broken(BondGraph graph, const Impact& impact) {
  for (uint32_t b : broken_bonds(graph, impact)) graph.bonds[b].integrity = 0.0;
  return graph;
}

// A row of three equal pieces struck at its end moves at J / 3m. The first bond transmits two thirds of the
// impulse, the second one third.
TEST(BondGraph, BondImpulseIsTheShareOfMassBehind) {
  BondGraph row;
  // The equivalent box is 0.2933 m long: 12 times the variance of 2/3 · 0.1² between centres and 1e-3 / 2 in
  // each piece. With this volume the mean cross-section is 1e-4 m².
  const double length_m = std::sqrt(12.0 * (0.02 / 3.0 + 0.5e-3));
  for (int n = 0; n < 3; ++n) {
    row.pieces.push_back({1.0, {0.1 * n, 0, 0}, 1e-3 * Eigen::Matrix3d::Identity(), 1e-4 * length_m / 3.0});
  }
  row.bonds = {{1, 2, 1e-4}, {0, 1, 1e-4}};
  row.break_impulse_n_s = kThreshold;
  row.whole_area_m2 = 2e-4;
  Impact impact{0, {0, 0, 0}, {kThreshold, 0, 0}};
  EXPECT_EQ(broken_bonds(row, impact), std::vector<uint32_t>{1});
  // The cracked area grows with the square of the impulse, so both bonds break from sqrt(2) of the threshold.
  impact.impulse_n_s *= 1.41;
  EXPECT_EQ(broken_bonds(row, impact), std::vector<uint32_t>{1});
  impact.impulse_n_s *= 1.42 / 1.41;
  EXPECT_EQ(broken_bonds(row, impact), (std::vector<uint32_t>{1, 0}));
  // With an integrity of 0.4 the far bond breaks first, at 0.4 / (1/3) · 2/3 = 0.8 of the threshold.
  row.bonds[0].integrity = 0.4;
  EXPECT_NEAR(break_threshold_n_s(row, impact), 0.8 * kThreshold, 1e-12);
  impact.impulse_n_s = {0.81 * kThreshold, 0, 0};
  EXPECT_EQ(broken_bonds(row, impact), std::vector<uint32_t>{0});
}

// An impact at 0.9 of the threshold reduces the integrity of the near bond by 0.25 · (0.9 - 0.5) / 0.5 = 0.2.
// The far bond carries 0.45 of its threshold and keeps its integrity.
TEST(BondGraph, ImpactsAboveHalfThresholdDamageBonds) {
  BondGraph row;
  for (int n = 0; n < 3; ++n)
    row.pieces.push_back({1.0, {0.1 * n, 0, 0}, 1e-3 * Eigen::Matrix3d::Identity(), 1e-4});
  row.bonds = {{1, 2, 1e-4}, {0, 1, 1e-4}};
  row.break_impulse_n_s = kThreshold;
  row.whole_area_m2 = 2e-4;
  const Impact impact{0, {0, 0, 0}, {0.9 * kThreshold, 0, 0}}, light{0, {0, 0, 0}, {0.5 * kThreshold, 0, 0}};
  ASSERT_TRUE(broken_bonds(row, impact).empty());
  accumulate_damage(row, impact);
  EXPECT_NEAR(row.bonds[1].integrity, 0.8, 1e-12);
  EXPECT_EQ(row.bonds[0].integrity, 1.0);
  EXPECT_NEAR(break_threshold_n_s(row, impact), 0.8 * kThreshold, 1e-12);
  EXPECT_EQ(broken_bonds(row, impact).front(), 1u);
  // The damage of an impact does not depend on earlier damage. An impact at half the threshold causes none.
  accumulate_damage(row, light);
  EXPECT_NEAR(row.bonds[1].integrity, 0.8, 1e-12);
  accumulate_damage(row, {0, {0, 0, 0}, {0.7 * kThreshold, 0, 0}});
  EXPECT_NEAR(row.bonds[1].integrity, 0.7, 1e-12);
  for (int i = 0; i < 100; ++i) accumulate_damage(row, {0, {0, 0, 0}, {0.7 * kThreshold, 0, 0}});
  EXPECT_EQ(row.bonds[1].integrity, kMinIntegrity);
}

// Repeated equal impacts crack a cup along the bonds that they damaged.
TEST(BondGraph, CracksFollowDamagedBonds) {
  int worn_first = 0, cracks = 0;
  for (uint64_t seed = 1; seed <= 25; ++seed) {
    const VoronoiPieces pieces = cut_cup(32, seed);
    const BondGraph fresh = make_bond_graph(pieces, 0.3, kThreshold);
    BondGraph worn = fresh;
    const Impact impact{7, pieces.pieces[7].mesh.vertices_m[0],
                        0.72 * kThreshold * Eigen::Vector3d(-0.6, 0, 0.8)};
    int impacts = 1;
    for (; broken_bonds(worn, impact).empty() && impacts < 20; ++impacts) accumulate_damage(worn, impact);
    EXPECT_EQ(impacts, 4) << "each impact takes 0.11; the impact of 0.72 exceeds the remaining 0.67";
    const std::vector<uint32_t> crack = broken_bonds(worn, impact);
    ++cracks;
    worn_first +=
        std::any_of(crack.begin(), crack.end(), [&](uint32_t b) { return worn.bonds[b].integrity < 0.99; });
  }
  EXPECT_EQ(worn_first, cracks);
}

TEST(BondGraph, BreaksAtItsThresholdForAnyImpactPoint) {
  for (uint64_t seed = 1; seed <= 25; ++seed) {
    const VoronoiPieces pieces = cut_cup(seed % 2 ? 16 : 48, seed);
    const BondGraph graph = make_bond_graph(pieces, 0.3, kThreshold);
    ASSERT_EQ(group_count(graph), 1u);
    for (uint32_t struck = 0; struck < pieces.pieces.size(); struck += 5) {
      for (const Eigen::Vector3d& way : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(-0.6, 0, 0.8)}) {
        const Eigen::Vector3d point = pieces.pieces[struck].mesh.vertices_m[0];
        EXPECT_NEAR(break_threshold_n_s(graph, {struck, point, way}), kThreshold, 1e-12);
        EXPECT_TRUE(broken_bonds(graph, {struck, point, 0.9999 * kThreshold * way}).empty());
        EXPECT_GE(group_count(broken(graph, {struck, point, 1.0001 * kThreshold * way})), 2u);
      }
    }
  }
}

// The bonds that one impact breaks also break under a stronger one. The strongest impact separates all
// pieces.
TEST(BondGraph, StrongerImpactsBreakMoreBonds) {
  const VoronoiPieces pieces = cut_cup(32, 4);
  const BondGraph graph = make_bond_graph(pieces, 0.3, kThreshold);
  const Eigen::Vector3d point(0.04, 0.0, 0.0);
  const uint32_t struck = pieces.locate(point);
  std::vector<uint32_t> before;
  for (double times = 0.5; times < 40.0; times *= 1.25) {
    const auto bonds = broken_bonds(graph, {struck, point, {0, times * kThreshold, 0}});
    ASSERT_GE(bonds.size(), before.size());
    EXPECT_TRUE(std::equal(before.begin(), before.end(), bonds.begin()));
    before = bonds;
  }
  EXPECT_EQ(before.size(), graph.bonds.size());
}

TEST(BondGraph, FragmentsBreakAtTheirShareOfThreshold) {
  const VoronoiPieces pieces = cut_cup(48, 6);
  const BondGraph graph = make_bond_graph(pieces, 0.3, kThreshold);
  const Eigen::Vector3d point(0.04, 0.0, 0.0);
  const BondGraph after = broken(graph, {pieces.locate(point), point, {0, 2 * kThreshold, 0}});
  const auto groups = connected_groups(after);
  ASSERT_GT(group_count(after), 2u);
  double mass_kg = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  for (uint32_t group : std::set(groups.begin(), groups.end())) {
    const BondGraph::Piece body = joined_piece(after, groups, group);
    mass_kg += body.mass_kg;
    first += body.mass_kg * body.centre_m;
    double area_m2 = 0.0;
    for (const BondGraph::Bond& bond : after.bonds) {
      if (bond.integrity > 0.0 && groups[bond.first] == group) area_m2 += bond.area_m2;
    }
    const Impact impact{group, body.centre_m, {0, 0, 1}};
    if (area_m2 > 0.0) {
      EXPECT_NEAR(break_threshold_n_s(after, impact), kThreshold * area_m2 / graph.whole_area_m2, 1e-12);
    } else {
      EXPECT_TRUE(std::isinf(break_threshold_n_s(after, impact)));
      EXPECT_TRUE(broken_bonds(after, {group, body.centre_m, {0, 0, 1e6}}).empty());
    }
  }
  const MassProperties whole = solid_mass_properties(testing::cup_mesh(48, 10));
  EXPECT_NEAR(mass_kg, 0.3, 1e-14);
  EXPECT_LT((first / mass_kg - whole.centre_of_mass_m).norm(), 1e-14);
  const BondGraph::Piece joined = joined_piece(graph, connected_groups(graph), 0);
  EXPECT_LT((joined.inertia - 0.3 * whole.inertia_m2).norm(), 1e-12 * whole.inertia_m2.norm());
}

TEST(BondGraph, DisconnectedPartsStayBonded) {
  TriangleMesh pair = box_mesh({0.1, 0.1, 0.1});
  const TriangleMesh other = sphere_mesh(0.03, 2);
  for (const auto& [a, b, c] : other.triangles) pair.triangles.push_back({a + 8, b + 8, c + 8});
  for (const auto& vertex : other.vertices_m) pair.vertices_m.push_back(vertex + Eigen::Vector3d(0.2, 0, 0));
  const auto pieces = cut_voronoi_pieces(pair, std::vector<Eigen::Vector3d>{{-0.02, 0, 0}, {0.02, 0, 0}});
  const BondGraph graph = make_bond_graph(*pieces, 1.0, kThreshold);
  EXPECT_EQ(graph.pieces.size(), 3u);
  EXPECT_EQ(graph.bonds.size(), pieces->bonds.size() + 1);
  EXPECT_EQ(group_count(graph), 1u);
}

}  // namespace
}  // namespace livegs
