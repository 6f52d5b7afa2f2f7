// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/mesh_topology.h"

#include <gtest/gtest.h>

#include "geometry/surface/assemble_surface.h"
#include "geometry/surface/remove_small_components.h"
#include "geometry/surface/shape_mesh.h"
#include "server/geometry/mesh/mesh_checks.h"

namespace livegs {
namespace {

using testing::joined;
using testing::moved;

TEST(MeshTopology, FindsHolesFinsAndPinchedVertices) {
  TriangleMesh open = box_mesh({1, 1, 1});
  open.triangles.pop_back();
  EXPECT_FALSE(mesh_topology(open).closed);

  TriangleMesh turned = box_mesh({1, 1, 1});
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_FALSE(mesh_topology(turned).closed);

  // Two boxes that share a corner: closed, one piece, but not a manifold.
  TriangleMesh pinched = joined(box_mesh({1, 1, 1}), moved(box_mesh({1, 1, 1}), {1, 1, 1}));
  for (auto& triangle : pinched.triangles) {
    for (uint32_t& v : triangle) v = v == 8 ? 7 : v;  // the second box's lowest corner is the first's highest
  }
  const MeshTopology topology = mesh_topology(pinched);
  EXPECT_TRUE(topology.closed);
  EXPECT_FALSE(topology.manifold);
  EXPECT_EQ(topology.piece_count, 1);
  EXPECT_EQ(mesh_topology(joined(box_mesh({1, 1, 1}), moved(box_mesh({1, 1, 1}), {2, 0, 0}))).piece_count, 2);
}

// Two tetrahedra (0 1 2 3) and (0 1 4 5) that meet only in the edge 0-1. Depending on `separate`, each body's
// own two triangles are paired, or each triangle with one of the other body.
PairedTriangles two_tetrahedra(bool separate) {
  PairedTriangles surface;
  surface.corners = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}, {0, 1, 4}, {0, 4, 5}, {0, 5, 1}, {1, 5, 4}};
  surface.twins.assign(24, UINT32_MAX);
  for (uint32_t h = 0; h < 24; ++h) {
    const uint32_t a = surface.corners[h / 3][h % 3], b = surface.corners[h / 3][(h + 1) % 3];
    for (uint32_t t = 0; t < 24; ++t) {
      const bool reverse = surface.corners[t / 3][t % 3] == b && surface.corners[t / 3][(t + 1) % 3] == a;
      const bool same_body = h / 12 == t / 12;
      const bool shared_edge = a <= 1 && b <= 1;
      if (reverse && (shared_edge ? same_body == separate : same_body)) surface.twins[h] = t;
    }
  }
  return surface;
}

const Eigen::Vector3d kCorners[6] = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};

TEST(AssembleSurface, SeparatesBodiesThatMeetInAnEdge) {
  const TriangleMesh mesh = assemble_surface(two_tetrahedra(true), [](uint32_t p) { return kCorners[p]; });
  const MeshTopology topology = mesh_topology(mesh);
  EXPECT_TRUE(topology.manifold);
  EXPECT_EQ(topology.piece_count, 2);
  EXPECT_EQ(topology.euler_characteristic, 4);
  EXPECT_NEAR(std::abs(signed_volume_m3(mesh)), 2.0 / 6.0, 1e-15);
}

TEST(AssembleSurface, SplitsAnEdgeSharedByTwoPairs) {
  const TriangleMesh mesh = assemble_surface(two_tetrahedra(false), [](uint32_t p) { return kCorners[p]; });
  const MeshTopology topology = mesh_topology(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.manifold);
  EXPECT_EQ(topology.piece_count, 1);
  EXPECT_NEAR(std::abs(signed_volume_m3(mesh)), 2.0 / 6.0, 1e-15);
}

TEST(DropSpecks, RemovesSmallShortPartsOnly) {
  // Small and short.
  TriangleMesh mesh = joined(box_mesh({1, 1, 1}), moved(box_mesh({0.02, 0.02, 0.02}), {1, 0, 0}));
  mesh = joined(mesh, moved(box_mesh({0.4, 0.01, 0.01}), {0, 1, 0}));  // long
  mesh = joined(mesh, moved(box_mesh({0.2, 0.2, 0.2}), {0, 0, 1}));    // large
  const SmallComponents dropped = remove_small_components(mesh);
  EXPECT_EQ(dropped.count, 1);
  EXPECT_NEAR(dropped.volume_share, 8e-6 / (1.0 + 8e-6 + 4e-5 + 8e-3), 1e-9);
  EXPECT_EQ(mesh_topology(mesh).piece_count, 3);
  EXPECT_EQ(mesh.vertices_m.size(), 24u);
  testing::expect_body(mesh);
}

}  // namespace
}  // namespace livegs
