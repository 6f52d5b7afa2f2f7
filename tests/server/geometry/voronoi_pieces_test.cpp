// SPDX-License-Identifier: Apache-2.0
#include "geometry/voronoi_pieces.h"

#include <gtest/gtest.h>

#include <set>

#include "core/parallel_for.h"
#include "geometry/fracture_seeds.h"
#include "geometry/mesh_topology.h"
#include "server/geometry/fracture_shapes.h"

namespace livegs {
namespace {

using testing::cup_mesh;
using testing::hollow_ball;

VoronoiPieces cut(const TriangleMesh& mesh, size_t count, uint64_t seed, const CutOptions& options = {}) {
  const auto seeds = fracture_seeds(mesh, {.count = count, .seed = seed, .impacts_m = {}});
  EXPECT_TRUE(seeds) << (seeds ? "" : seeds.error().message);
  Result<VoronoiPieces> pieces = cut_voronoi_pieces(mesh, *seeds, options);
  EXPECT_TRUE(pieces) << (pieces ? "" : pieces.error().message);
  return std::move(*pieces);
}

double cut_area(const VoronoiPieces& cut) {
  double area = 0.0;
  for (const VoronoiPiece& piece : cut.pieces) {
    for (size_t t = 0; t < piece.mesh.triangles.size(); ++t) {
      if (piece.triangle_bond[t] == kNoBond) continue;
      const auto& [a, b, c] = piece.mesh.triangles[t];
      const auto& v = piece.mesh.vertices_m;
      area += 0.5 * (v[b] - v[a]).cross(v[c] - v[a]).norm();
    }
  }
  return area;
}

// The whole put together again from its pieces.
void expect_whole(const TriangleMesh& mesh, const VoronoiPieces& cut) {
  const MassProperties whole = solid_mass_properties(mesh);
  double volume = 0.0, skin = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (const VoronoiPiece& piece : cut.pieces) {
    const MeshTopology topology = mesh_topology(piece.mesh);
    ASSERT_TRUE(topology.closed);
    ASSERT_GT(signed_volume_m3(piece.mesh), 0.0);
    ASSERT_EQ(piece.triangle_bond.size(), piece.mesh.triangles.size());
    volume += piece.mass.volume_m3;
    first += piece.mass.volume_m3 * piece.mass.centre_of_mass_m;
    const Eigen::Vector3d arm = piece.mass.centre_of_mass_m - whole.centre_of_mass_m;
    inertia += piece.mass.volume_m3 * (piece.mass.inertia_m2 + arm.squaredNorm() * Eigen::Matrix3d::Identity() -
                                       arm * arm.transpose());
    skin += piece.mass.area_m2;
  }
  // Exact but for rounding: the bar asked for is 1e-4 of the volume and 1e-6 of the rest.
  EXPECT_NEAR(volume / whole.volume_m3, 1.0, 1e-11);
  const double size = std::sqrt(whole.inertia_m2.trace());
  EXPECT_LT((first / volume - whole.centre_of_mass_m).norm(), 1e-11 * size);
  EXPECT_LT((inertia / volume - whole.inertia_m2).norm(), 1e-11 * whole.inertia_m2.norm());
  double bonded = 0.0;
  for (const VoronoiBond& bond : cut.bonds) {
    EXPECT_LT(bond.first, bond.second);
    EXPECT_NEAR(bond.normal.norm(), 1.0, 1e-12);
    bonded += bond.area_m2;
  }
  EXPECT_NEAR(cut_area(cut), 2.0 * bonded, 1e-9 * bonded);           // both sides of every face
  EXPECT_NEAR(skin - cut_area(cut), whole.area_m2, 1e-9 * whole.area_m2);  // and the old surface is all there
}

TEST(VoronoiPieces, AddUpToTheWholeOverAHundredSeeds) {
  const std::vector<TriangleMesh> shapes{sphere_mesh(0.1, 3), box_mesh({0.2, 0.1, 0.05}), cup_mesh(48, 10),
                                         hollow_ball()};
  for (const TriangleMesh& mesh : shapes) {
    for (uint64_t seed = 1; seed <= 25; ++seed) {
      SCOPED_TRACE(::testing::Message() << mesh.triangles.size() << " triangles, seed " << seed);
      const VoronoiPieces pieces = cut(mesh, seed % 5 == 0 ? 64 : 16, seed);
      expect_whole(mesh, pieces);
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace livegs
