// SPDX-License-Identifier: Apache-2.0
// The shared budget of all elastic bodies of a scene (share_elastic_budget.h).
#include "scene/build/share_elastic_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace livegs {
namespace {

ResolutionRequest request_of(const Eigen::Vector3d& size_m, double youngs_modulus_pa) {
  ResolutionRequest request;
  request.size_m = size_m;
  request.particle_edge_m = 0.02 * size_m.minCoeff();
  request.youngs_modulus_pa = youngs_modulus_pa;
  request.poisson_ratio = 0.3;
  request.density_kg_m3 = 1000;
  request.rate_hz = 90;
  request.substeps = 4;
  return request;
}
ResolutionRequest cube(double youngs_modulus_pa) { return request_of({0.1, 0.1, 0.1}, youngs_modulus_pa); }
ResolutionRequest sheet() { return request_of({1.0, 0.002, 1.0}, 1e6); }

LatticeResolution with_share(ResolutionRequest request, double share) {
  request.max_node_substeps = std::min(request.max_node_substeps, share);
  return choose_resolution(request);
}

TEST(ElasticBudget, RequestsThatFitAreUnchanged) {
  const std::vector<ResolutionRequest> requests(8, cube(1e5));
  EXPECT_TRUE(std::isinf(fair_share(requests, kMaxNodeSubsteps)));
  EXPECT_TRUE(std::isinf(fair_share({}, kMaxNodeSubsteps)));
}

// Ten sheets, each of which would fill nearly a whole frame. Together they stay within the budget of one, and
// small bodies keep their cells.
TEST(ElasticBudget, TenSheetsShareAFrameAndSmallBodiesKeepTheirs) {
  std::vector<ResolutionRequest> requests(10, sheet());
  const double alone = choose_resolution(sheet()).node_substeps;
  ASSERT_GT(10 * alone, 4 * kMaxNodeSubsteps);
  for (int i = 0; i < 5; ++i) requests.push_back(cube(1e4));
  const double share = fair_share(requests, kMaxNodeSubsteps);
  double sum = 0;
  for (const ResolutionRequest& request : requests) {
    const LatticeResolution resolution = with_share(request, share);
    EXPECT_LE(resolution.node_substeps, share);
    sum += resolution.node_substeps;
  }
  EXPECT_LE(sum, kMaxNodeSubsteps);
  EXPECT_GT(sum, kMaxNodeSubsteps / (1.2 * 1.2 * 1.2));  // the budget is used up to the width steps of 1.2
  EXPECT_GT(with_share(sheet(), share).cell_width_m, choose_resolution(sheet()).cell_width_m);
  EXPECT_EQ(with_share(cube(1e4), share).cell_width_m, choose_resolution(cube(1e4)).cell_width_m);
  EXPECT_EQ(with_share(cube(1e4), share).substeps, choose_resolution(cube(1e4)).substeps);
}

// Cells get wider first. Stiffness is clipped only if the widest cells exceed the share, down to the scene's
// own substeps.
TEST(ElasticBudget, CellsWidenBeforeStiffnessIsClipped) {
  double width_m = 0, reached_pa = 1e99;
  bool was_clipped = false;
  for (double share = 20e3; share > 50; share *= 0.7) {
    const LatticeResolution resolution = with_share(cube(1e7), share);
    EXPECT_GE(resolution.cell_width_m, width_m) << share;
    EXPECT_LE(resolution.youngs_modulus_pa, reached_pa) << share;
    if (resolution.clipped) EXPECT_EQ(resolution.cell_width_m, 0.1) << share;  // one cell
    EXPECT_TRUE(resolution.node_substeps <= share || resolution.substeps == 4) << share;
    EXPECT_LE(resolution.courant, courant_limit(0.3, 0.1 / resolution.cell_width_m) + 1e-12);
    width_m = resolution.cell_width_m;
    reached_pa = resolution.youngs_modulus_pa;
    was_clipped = resolution.clipped;
  }
  EXPECT_TRUE(was_clipped);
}

// A cell width given by the user is kept. The other bodies keep at least an equal share.
TEST(ElasticBudget, GivenCellWidthStaysAndOthersKeepAShare) {
  ResolutionRequest given = cube(1e5);
  given.cell_width_m = 0.002;
  given.max_node_substeps = std::numeric_limits<double>::infinity();
  const std::vector<ResolutionRequest> requests{given, sheet(), sheet(), cube(1e4)};
  ASSERT_GT(choose_resolution(given).node_substeps, kMaxNodeSubsteps);
  EXPECT_EQ(choose_resolution(given).cell_width_m, 0.002);
  EXPECT_DOUBLE_EQ(fair_share(requests, kMaxNodeSubsteps), kMaxNodeSubsteps / 4);
}

}  // namespace
}  // namespace livegs
