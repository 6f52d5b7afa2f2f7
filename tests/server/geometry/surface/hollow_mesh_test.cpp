// SPDX-License-Identifier: Apache-2.0
#include "geometry/surface/hollow_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/fracture/fracture_seeds.h"
#include "geometry/fracture/voronoi_pieces.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/surface/shape_mesh.h"
#include "server/geometry/fracture/fracture_shapes.h"

namespace livegs {
namespace {

// Volume of the wall of a ball: 4/3 pi (R³ - (R - t)³), minus the facets of the mesh. The bar is 3 %, because
// the distance is concave inside and trilinear interpolation lowers it by h² / (4 r) for a cell h.
TEST(HollowMesh, BallHasTheVolumeOfItsWall) {
  const TriangleMesh ball = sphere_mesh(0.05, 4);
  for (const double wall_m : {0.005, 0.02}) {
    const auto shell = hollow_mesh(ball, wall_m);
    ASSERT_TRUE(shell) << shell.error().message;
    const double inner = 0.05 - wall_m;
    const double wall_m3 = signed_volume_m3(ball) - 4.0 / 3.0 * std::numbers::pi * inner * inner * inner;
    EXPECT_NEAR(signed_volume_m3(*shell), wall_m3, 0.03 * wall_m3) << wall_m;
    const MeshTopology topology = mesh_topology(*shell);
    EXPECT_TRUE(topology.manifold);
    EXPECT_EQ(topology.piece_count, 2);
    EXPECT_EQ(topology.euler_characteristic, 4);
    EXPECT_TRUE(has_hollow(*shell));
  }
  EXPECT_FALSE(has_hollow(ball));
  EXPECT_TRUE(has_hollow(testing::hollow_ball()));
}

// The cavity of a box is the box minus the wall on all sides; at its edges the nearest point is on a face
// too.
TEST(HollowMesh, BoxBecomesAShell) {
  const TriangleMesh box = box_mesh({0.1, 0.08, 0.12});
  const auto shell = hollow_mesh(box, 0.01);
  ASSERT_TRUE(shell) << shell.error().message;
  const double wall_m3 = 0.1 * 0.08 * 0.12 - 0.08 * 0.06 * 0.1;
  EXPECT_NEAR(signed_volume_m3(*shell), wall_m3, 0.02 * wall_m3);
  SeedOptions seeding;
  seeding.count = 24;
  const auto seeds = fracture_seeds(*shell, seeding);
  ASSERT_TRUE(seeds) << seeds.error().message;
  const auto pieces = cut_voronoi_pieces(*shell, *seeds);
  ASSERT_TRUE(pieces) << pieces.error().message;
  double sum_m3 = 0.0;
  for (const VoronoiPiece& piece : pieces->pieces) sum_m3 += piece.mass.volume_m3;
  EXPECT_NEAR(sum_m3, signed_volume_m3(*shell), 1e-9 * sum_m3);
}

TEST(HollowMesh, RefusesWallsOutOfRange) {
  const TriangleMesh ball = sphere_mesh(0.05, 3);
  for (const auto& [wall_m, why] :
       {std::pair(0.0, "too thin"), {0.001, "too thin"}, {0.06, "no cavity"}, {NAN, "too thin"}}) {
    const auto shell = hollow_mesh(ball, wall_m);
    ASSERT_FALSE(shell) << wall_m;
    EXPECT_NE(shell.error().message.find(why), std::string::npos) << shell.error().message;
  }
}

}  // namespace
}  // namespace livegs
