// SPDX-License-Identifier: Apache-2.0
#include "geometry/fracture/voronoi_pieces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>

#include "core/parallel_for.h"
#include "gaussian/asset_file.h"
#include "geometry/fracture/fracture_seeds.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/reconstruct_surface.h"
#include "rates.h"
#include "server/geometry/fracture/fracture_shapes.h"

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

// Compares the sum of the pieces with the whole.
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
    inertia +=
        piece.mass.volume_m3 *
        (piece.mass.inertia_m2 + arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
    skin += piece.mass.area_m2;
  }
  // Exact up to rounding; the required bars are 1e-4 of the volume and 1e-6 of the other values.
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
  EXPECT_NEAR(cut_area(cut), 2.0 * bonded, 1e-9 * bonded);                 // both sides of each face
  EXPECT_NEAR(skin - cut_area(cut), whole.area_m2, 1e-9 * whole.area_m2);  // the original surface is complete
}

TEST(VoronoiPieces, AddUpToTheWholeForAllSeeds) {
  const std::vector<TriangleMesh> shapes{sphere_mesh(0.1, 3), box_mesh({0.2, 0.1, 0.05}), cup_mesh(48, 10),
                                         hollow_ball()};
  for (const TriangleMesh& mesh : shapes) {
    for (uint64_t seed = 1; seed <= static_cast<uint64_t>(seed_count(10)); ++seed) {
      SCOPED_TRACE(::testing::Message() << mesh.triangles.size() << " triangles, seed " << seed);
      const VoronoiPieces pieces = cut(mesh, seed % 5 == 0 ? 64 : 16, seed);
      expect_whole(mesh, pieces);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(VoronoiPieces, AddUpToTheWholeOfACapturedAsset) {
  const std::filesystem::path file =
      std::filesystem::path(LIVEGS_SHARED_DATA_DIR) / "splats/camera_leica/leica-sofort-top8192.ply";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << ": the shared data is missing";
  const auto asset = read_asset(file);
  ASSERT_TRUE(asset);
  Similarity up;
  up.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  const auto surface = reconstruct_surface(body_points(asset->asset, up), elastic_surface_options());
  ASSERT_TRUE(surface);
  for (uint64_t seed = 1; seed <= static_cast<uint64_t>(seed_count(2)); ++seed) {
    SCOPED_TRACE(seed);
    expect_whole(surface->mesh, cut(surface->mesh, seed % 2 ? 16 : 64, seed));
  }
}

TEST(VoronoiPieces, AddUpForCutsThroughVerticesAndEdges) {
  // Planes through the corners, edges and diagonals of a box with subdivided faces. Eight cells meet in one
  // point, and four in each of six lines.
  TriangleMesh box = box_mesh({2, 2, 2});
  TriangleMesh fine;
  for (const auto& [a, b, c] : box.triangles) {
    const std::array corners{box.vertices_m[a], box.vertices_m[b], box.vertices_m[c]};
    const std::array<Eigen::Vector3d, 3> middles{
        0.5 * (corners[0] + corners[1]), 0.5 * (corners[1] + corners[2]), 0.5 * (corners[2] + corners[0])};
    const auto start = static_cast<uint32_t>(fine.vertices_m.size());
    for (const auto& corner : corners) fine.vertices_m.push_back(corner);
    for (const auto& middle : middles) fine.vertices_m.push_back(middle);
    for (const auto& [i, j, k] : {std::array{0u, 3u, 5u}, {3u, 1u, 4u}, {5u, 4u, 2u}, {3u, 4u, 5u}}) {
      fine.triangles.push_back({start + i, start + j, start + k});
    }
  }
  std::vector<Eigen::Vector3d> seeds;
  for (int corner = 0; corner < 8; ++corner) {
    seeds.emplace_back(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
  }
  const auto pieces = cut_voronoi_pieces(fine, seeds);  // a triangle soup: each triangle has its own vertices
  ASSERT_TRUE(pieces) << pieces.error().message;
  ASSERT_EQ(pieces->pieces.size(), 8u);
  for (const VoronoiPiece& piece : pieces->pieces) EXPECT_NEAR(piece.mass.volume_m3, 1.0, 1e-14);
  ASSERT_EQ(pieces->bonds.size(), 12u);
  for (const VoronoiBond& bond : pieces->bonds) EXPECT_NEAR(bond.area_m2, 1.0, 1e-14);
  expect_whole(box, *pieces);

  // A cut in the plane of a face, and cells that contain no part of the body.
  const auto flush = cut_voronoi_pieces(box, std::vector<Eigen::Vector3d>{{0, 0, 0}, {0, 0, 2}, {9, 0, 0}});
  ASSERT_TRUE(flush) << flush.error().message;
  EXPECT_EQ(flush->pieces.size(), 1u);
  EXPECT_EQ(flush->seeds_m.size(), 1u);
  expect_whole(box, *flush);
}

TEST(VoronoiPieces, HaveTheFaceBetweenTwoHalves) {
  const TriangleMesh box = box_mesh({0.3, 0.2, 0.1});
  const auto halves = cut_voronoi_pieces(box, std::vector<Eigen::Vector3d>{{-0.1, 0.01, 0}, {0.06, 0.01, 0}});
  ASSERT_TRUE(halves);
  ASSERT_EQ(halves->pieces.size(), 2u);
  EXPECT_NEAR(halves->pieces[0].mass.volume_m3, 0.13 * 0.2 * 0.1, 1e-16);
  ASSERT_EQ(halves->bonds.size(), 1u);
  EXPECT_NEAR(halves->bonds[0].area_m2, 0.2 * 0.1, 1e-15);
  EXPECT_LT((halves->bonds[0].normal - Eigen::Vector3d::UnitX()).norm(), 1e-14);
  EXPECT_LT((halves->bonds[0].centroid_m - Eigen::Vector3d(-0.02, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(halves->locate({-0.021, 0.05, 0.02}), 0u);
  EXPECT_EQ(halves->locate({-0.019, 0.05, 0.02}), 1u);
}

TEST(VoronoiPieces, KeepCavitiesHollow) {
  const TriangleMesh ball = hollow_ball();
  const auto whole = cut_voronoi_pieces(ball, std::vector<Eigen::Vector3d>{{0.045, 0, 0}});
  ASSERT_TRUE(whole);
  ASSERT_EQ(whole->pieces.size(), 1u);
  EXPECT_NEAR(whole->pieces[0].mass.volume_m3, signed_volume_m3(ball), 1e-13 * signed_volume_m3(ball));
  // Two halves of a shell: the face between them is a ring.
  const auto halves =
      cut_voronoi_pieces(ball, std::vector<Eigen::Vector3d>{{0.045, 0, 0}, {-0.045, 0.001, 0}});
  ASSERT_TRUE(halves);
  ASSERT_EQ(halves->bonds.size(), 1u);
  // pi (0.05² - 0.04²) = 2.83e-3, minus a few per cent, because the balls are inscribed polyhedra.
  EXPECT_NEAR(halves->bonds[0].area_m2, 2.827e-3, 0.05e-3);
  expect_whole(ball, *halves);
}

TEST(VoronoiPieces, AreOnePerConnectedPart) {
  TriangleMesh pair = box_mesh({0.1, 0.1, 0.1});
  TriangleMesh other = box_mesh({0.1, 0.1, 0.2});
  for (auto& vertex : other.vertices_m) vertex += Eigen::Vector3d(0.5, 0, 0);
  for (const auto& [a, b, c] : other.triangles) pair.triangles.push_back({a + 8, b + 8, c + 8});
  pair.vertices_m.insert(pair.vertices_m.end(), other.vertices_m.begin(), other.vertices_m.end());
  const auto pieces = cut_voronoi_pieces(pair, std::vector<Eigen::Vector3d>{{0.2, 0, 0}});
  ASSERT_TRUE(pieces);
  ASSERT_EQ(pieces->pieces.size(), 2u);
  EXPECT_TRUE(pieces->bonds.empty());
  EXPECT_EQ(pieces->locate({0.01, 0.02, 0.03}), 0u);
  EXPECT_EQ(pieces->locate({0.49, 0.02, 0.09}), 1u);
  EXPECT_EQ(pieces->locate({0.3, 0, 0}), 1u);  // outside both: the nearer one
  expect_whole(pair, *pieces);
}

TEST(VoronoiPieces, MergeSliversAndLimitTheirNumber) {
  for (const TriangleMesh& mesh : {cup_mesh(48, 10), sphere_mesh(0.1, 3)}) {
    for (uint64_t seed = 1; seed <= 5; ++seed) {
      CutOptions options;
      options.smallest_share = 0.02;
      const VoronoiPieces joined = cut(mesh, 48, seed, options);
      for (const VoronoiPiece& piece : joined.pieces) {
        EXPECT_GE(piece.mass.volume_m3, 0.02 * signed_volume_m3(mesh));
      }
      expect_whole(mesh, joined);
      options = {};
      options.most_pieces = 7;
      const VoronoiPieces few = cut(mesh, 48, seed, options);
      EXPECT_EQ(few.pieces.size(), 7u);
      expect_whole(mesh, few);
    }
  }
}

// Where a point is inside exactly one piece, locate returns that piece.
TEST(VoronoiPieces, LocateFindsThePieceAroundAPoint) {
  for (const TriangleMesh& mesh : {cup_mesh(48, 10), hollow_ball()}) {
    const VoronoiPieces pieces = cut(mesh, 24, 3);
    std::mt19937_64 engine(5);
    const Eigen::AlignedBox3d bounds = mesh_bounds_m(mesh);
    int inside_count = 0;
    for (int n = 0; n < 4000; ++n) {
      Eigen::Vector3d point;
      for (int axis = 0; axis < 3; ++axis) {
        point[axis] =
            bounds.min()[axis] + bounds.sizes()[axis] * static_cast<double>(engine() >> 11) * 0x1.0p-53;
      }
      for (uint32_t p = 0; p < pieces.pieces.size(); ++p) {
        double angle = 0.0;  // van Oosterom and Strackee 1983
        for (const auto& triangle : pieces.pieces[p].mesh.triangles) {
          const auto& v = pieces.pieces[p].mesh.vertices_m;
          const Eigen::Vector3d a = (v[triangle[0]] - point).normalized(),
                                b = (v[triangle[1]] - point).normalized(),
                                c = (v[triangle[2]] - point).normalized();
          angle += 2.0 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
        }
        if (angle < 2 * std::numbers::pi) continue;
        ++inside_count;
        ASSERT_EQ(pieces.locate(point), p);
      }
    }
    EXPECT_GT(inside_count, 400);
  }
}

uint64_t bits_of(const VoronoiPieces& pieces) {
  uint64_t hash = 1469598103934665603ull;
  const auto add = [&](const void* data, size_t size) {
    for (size_t i = 0; i < size; ++i) hash = (hash ^ static_cast<const uint8_t*>(data)[i]) * 1099511628211ull;
  };
  for (const VoronoiPiece& piece : pieces.pieces) {
    add(piece.mesh.vertices_m.data(), piece.mesh.vertices_m.size() * sizeof(Eigen::Vector3d));
    add(piece.mesh.triangles.data(), piece.mesh.triangles.size() * sizeof(piece.mesh.triangles[0]));
    add(piece.triangle_bond.data(), piece.triangle_bond.size() * sizeof(uint32_t));
  }
  for (const VoronoiBond& bond : pieces.bonds) add(bond.centroid_m.data(), sizeof bond.centroid_m);
  return hash;
}

TEST(VoronoiPieces, AreBitEqualForAnyThreadCount) {
  const TriangleMesh mesh = cup_mesh();
  set_thread_count(1);
  const uint64_t bits = bits_of(cut(mesh, 32, 9));
  for (const int threads : {1, 2, 8}) {
    set_thread_count(threads);
    EXPECT_EQ(bits_of(cut(mesh, 32, 9)), bits) << threads;
  }
  set_thread_count(0);
  EXPECT_NE(bits_of(cut(mesh, 32, 10)), bits);
}

TEST(VoronoiPieces, RefuseInvalidMeshesInOneLine) {
  const std::vector<Eigen::Vector3d> seeds{{0, 0, 0}, {0.01, 0, 0}};
  const auto message = [&](const TriangleMesh& mesh, std::span<const Eigen::Vector3d> at) {
    const auto pieces = cut_voronoi_pieces(mesh, at);
    return pieces ? std::string() : pieces.error().message;
  };
  TriangleMesh open = box_mesh({1, 1, 1});
  open.triangles.pop_back();
  EXPECT_NE(message(open, seeds).find("open (3 edges"), std::string::npos) << message(open, seeds);
  TriangleMesh inside_out = box_mesh({1, 1, 1});
  for (auto& triangle : inside_out.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_NE(message(inside_out, seeds).find("inside out"), std::string::npos);
  TriangleMesh lost = box_mesh({1, 1, 1});
  lost.vertices_m[3].x() = NAN;
  EXPECT_NE(message(lost, seeds).find("not finite"), std::string::npos);
  EXPECT_NE(message({}, seeds).find("open"), std::string::npos);
  const TriangleMesh box = box_mesh({1, 1, 1});
  EXPECT_NE(message(box, {}).find("0 seeds"), std::string::npos);
  EXPECT_NE(message(box, std::vector<Eigen::Vector3d>{{0, 0, 0}, {0, 0, 0}}).find("same place"),
            std::string::npos);
  EXPECT_FALSE(fracture_seeds(box, {.count = 65, .impacts_m = {}}));
  EXPECT_FALSE(fracture_seeds({}, {.impacts_m = {}}));
  std::stop_source stop;
  stop.request_stop();
  CutOptions options;
  options.stop = stop.get_token();
  const auto cancelled = cut_voronoi_pieces(box, seeds, options);
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().code, ErrorCode::Unavailable);
}

// Near the impact, 64 seeds are several times as dense as far from it.
TEST(FractureSeeds, AreDenserNearAnImpact) {
  const TriangleMesh box = box_mesh({0.4, 0.1, 0.1});
  const Eigen::Vector3d blow(0.2, 0, 0);
  int near = 0, far = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const auto seeds = fracture_seeds(box, {.count = 64, .seed = seed, .impacts_m = std::span(&blow, 1)});
    ASSERT_TRUE(seeds);
    ASSERT_EQ(seeds->size(), 64u);
    for (const auto& point : *seeds) {
      near += point.x() > 0.15;  // an eighth of the volume each
      far += point.x() < -0.15;
    }
  }
  // The requested density, averaged over each end: 1 + 7 exp(-(d / 0.064)²) is 6.2 at the impact and 1 at the
  // other end.
  EXPECT_GT(near, 3.5 * far);
  EXPECT_LT(near, 9.0 * far);
}

}  // namespace
}  // namespace livegs
