// SPDX-License-Identifier: Apache-2.0
// One budget for all elastic bodies of a scene (elastic_budget.h).
#include "physics/elastic/resolution/elastic_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace livegs {
namespace {

CellDemand demand_of(const Eigen::Vector3d& size_m, double youngs_modulus_pa) {
  CellDemand demand;
  demand.size_m = size_m;
  demand.particle_edge_m = 0.02 * size_m.minCoeff();
  demand.youngs_modulus_pa = youngs_modulus_pa;
  demand.poisson_ratio = 0.3;
  demand.density_kg_m3 = 1000;
  demand.rate_hz = 90;
  demand.substeps = 4;
  return demand;
}
CellDemand cube(double youngs_modulus_pa) { return demand_of({0.1, 0.1, 0.1}, youngs_modulus_pa); }
CellDemand sheet() { return demand_of({1.0, 0.002, 1.0}, 1e6); }

CellChoice with_share(CellDemand demand, double share) {
  demand.most_node_substeps = std::min(demand.most_node_substeps, share);
  return choose_cells(demand);
}

TEST(ElasticBudget, WhatFitsGetsWhatItAsksFor) {
  const std::vector<CellDemand> demands(8, cube(1e5));
  EXPECT_TRUE(std::isinf(fair_share(demands, kMostNodeSubsteps)));
  EXPECT_TRUE(std::isinf(fair_share({}, kMostNodeSubsteps)));
}

// Ten sheets of which each would take nearly all of a frame: together they take no more than one did. Small things beside
// them keep their cells.
TEST(ElasticBudget, TenSheetsShareAFrameAndTheSmallKeepTheirs) {
  std::vector<CellDemand> demands(10, sheet());
  const double alone = choose_cells(sheet()).node_substeps;
  ASSERT_GT(10 * alone, 4 * kMostNodeSubsteps);
  for (int i = 0; i < 5; ++i) demands.push_back(cube(1e4));
  const double share = fair_share(demands, kMostNodeSubsteps);
  double sum = 0;
  for (const CellDemand& demand : demands) {
    const CellChoice choice = with_share(demand, share);
    EXPECT_LE(choice.node_substeps, share);
    sum += choice.node_substeps;
  }
  EXPECT_LE(sum, kMostNodeSubsteps);
  EXPECT_GT(sum, kMostNodeSubsteps / (1.2 * 1.2 * 1.2));  // what is there is used, as far as steps of 1.2 in width allow
  EXPECT_GT(with_share(sheet(), share).cell_width_m, choose_cells(sheet()).cell_width_m);
  EXPECT_EQ(with_share(cube(1e4), share).cell_width_m, choose_cells(cube(1e4)).cell_width_m);
  EXPECT_EQ(with_share(cube(1e4), share).substeps, choose_cells(cube(1e4)).substeps);
}

// Cells get wider first; what the widest cannot pay for is less stiff, down to the scene's own substeps.
TEST(ElasticBudget, CellsGetWiderBeforeStiffnessIsClipped) {
  double width_m = 0, reached_pa = 1e99;
  bool was_clipped = false;
  for (double share = 20e3; share > 50; share *= 0.7) {
    const CellChoice choice = with_share(cube(1e7), share);
    EXPECT_GE(choice.cell_width_m, width_m) << share;
    EXPECT_LE(choice.youngs_modulus_pa, reached_pa) << share;
    if (choice.clipped) EXPECT_EQ(choice.cell_width_m, 0.1) << share;  // one cell
    EXPECT_TRUE(choice.node_substeps <= share || choice.substeps == 4) << share;
    EXPECT_LE(choice.courant, courant_limit(0.3, 0.1 / choice.cell_width_m) + 1e-12);
    width_m = choice.cell_width_m;
    reached_pa = choice.youngs_modulus_pa;
    was_clipped = choice.clipped;
  }
  EXPECT_TRUE(was_clipped);
}

// Cells that a person typed stay, and the others keep an equal part at least.
TEST(ElasticBudget, GivenCellsStayAndTheOthersAreNotStarved) {
  CellDemand given = cube(1e5);
  given.cell_width_m = 0.002;
  given.most_node_substeps = std::numeric_limits<double>::infinity();
  const std::vector<CellDemand> demands{given, sheet(), sheet(), cube(1e4)};
  ASSERT_GT(choose_cells(given).node_substeps, kMostNodeSubsteps);
  EXPECT_EQ(choose_cells(given).cell_width_m, 0.002);
  EXPECT_DOUBLE_EQ(fair_share(demands, kMostNodeSubsteps), kMostNodeSubsteps / 4);
}

}  // namespace
}  // namespace livegs
