// SPDX-License-Identifier: GPL-3.0-or-later
#include "prepare/prepare_pieces.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/parallel_for.h"
#include "geometry/fracture/fracture_seeds.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/surface/hollow_mesh.h"

namespace livegs {
namespace {

// Resolution of a piece. Preparation time grows with the cube of field_cells. Fragments fit each other
// without gaps, so exact thin walls would cost more time and not improve resting contact.
constexpr ShapeDetail kPieceDetail{.field_cells = 16.0,
                                   .point_spacing = 1.0 / 8.0,
                                   .max_points = 96,
                                   .thin = DistanceField::Thin::ByTheGrid};
constexpr double kSliverPoints =
    4.0;  // of a pattern along the longest side of a face, times the points of the face
// Minimum outer area of a shell's piece, relative to its volume^(2/3). Below it the body is treated as a
// solid.
constexpr double kMinOutsideShare = 0.05;

TriangleMesh triangles_on(const VoronoiPiece& piece, uint32_t bond) {
  TriangleMesh mesh;
  std::map<uint32_t, uint32_t> kept;
  for (size_t t = 0; t < piece.mesh.triangles.size(); ++t) {
    if (piece.triangle_bond[t] != bond) continue;
    std::array<uint32_t, 3> triangle;
    for (int c = 0; c < 3; ++c) {
      const uint32_t from = piece.mesh.triangles[t][c];
      const auto [at, fresh] = kept.try_emplace(from, static_cast<uint32_t>(mesh.vertices_m.size()));
      if (fresh) mesh.vertices_m.push_back(piece.mesh.vertices_m[from]);
      triangle[c] = at->second;
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

// Farthest point sampling (Gonzalez 1985), starting with the point farthest from `centre`. The first point
// wins ties.
std::vector<Eigen::Vector3d> spread(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& centre,
                                    size_t most) {
  std::vector<Eigen::Vector3d> chosen;
  std::vector<double> distance(points.size(), 0.0);
  for (size_t i = 0; i < points.size(); ++i) distance[i] = (points[i] - centre).squaredNorm();
  while (chosen.size() < std::min(most, points.size())) {
    const auto best = static_cast<size_t>(std::ranges::max_element(distance) - distance.begin());
    if (!chosen.empty() && distance[best] <= 0.0) break;
    chosen.push_back(points[best]);
    for (size_t i = 0; i < points.size(); ++i) {
      const double way = (points[i] - points[best]).squaredNorm();
      distance[i] = chosen.size() == 1 ? way : std::min(distance[i], way);
    }
  }
  return chosen;
}

std::vector<BreakablePiece::SurfacePoints> surface_points(const VoronoiPiece& piece) {
  const std::set<uint32_t> bonds(piece.triangle_bond.begin(), piece.triangle_bond.end());
  std::vector<BreakablePiece::SurfacePoints> surface;
  for (const uint32_t bond : bonds) {
    const TriangleMesh face = triangles_on(piece, bond);
    const size_t most = kPieceDetail.max_points / (bond == kNoBond ? 3 : 8);  // 8: of a cut face
    // A sliver has almost no area; its length bounds the number of points.
    const double least = mesh_bounds_m(face).diagonal().norm() / (kSliverPoints * static_cast<double>(most));
    const double spacing =
        std::max(std::sqrt(surface_area_m2(face) / static_cast<double>(most)), least) + 1e-9;
    surface.push_back({bond, spread(contact_points(face, spacing), piece.mass.centre_of_mass_m, most)});
  }
  return surface;
}

// Mass properties of a shell's piece from its outer surface; cut faces have no mass.
MassProperties outside_mass(const VoronoiPiece& piece) {
  const TriangleMesh outside = triangles_on(piece, kNoBond);
  MassProperties mass = shell_mass_properties(outside);
  mass.volume_m3 = piece.mass.volume_m3;
  return mass;
}

bool has_outside(const VoronoiPiece& piece) {
  return surface_area_m2(triangles_on(piece, kNoBond)) >
         kMinOutsideShare * std::pow(piece.mass.volume_m3, 2.0 / 3.0);
}

}  // namespace

Result<std::shared_ptr<const BreakablePieces>> prepare_pieces(const TriangleMesh& mesh, Fill fill,
                                                              const BreakableOptions& options) {
  const auto seeds =
      fracture_seeds(mesh, {.count = options.piece_count, .seed = options.seed, .impacts_m = {}});
  if (!seeds) return seeds.error();
  auto cut = cut_voronoi_pieces(mesh, *seeds, {.stop = options.stop});
  if (!cut) return cut.error();

  auto prepared = std::make_shared<BreakablePieces>();
  prepared->cut = std::move(*cut);
  const std::vector<VoronoiPiece>& pieces = prepared->cut.pieces;
  const bool shell = (fill == Fill::Shell || fill == Fill::OpenShell) && !has_hollow(mesh) &&
                     std::ranges::all_of(pieces, has_outside);
  prepared->pieces.resize(pieces.size());
  parallel_for(pieces.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (options.stop.stop_requested()) return;
      BreakablePiece& piece = prepared->pieces[i];
      piece.mass = shell ? outside_mass(pieces[i]) : pieces[i].mass;
      piece.mass_share = shell ? piece.mass.area_m2 : piece.mass.volume_m3;
      piece.shape = std::make_shared<const RigidShape>(
          mesh_shape(pieces[i].mesh, piece.mass.centre_of_mass_m, kPieceDetail));
      piece.surface = surface_points(pieces[i]);
    }
  });
  if (options.stop.stop_requested()) return Error{ErrorCode::Unavailable, "fracture: cutting was cancelled"};
  double total = 0.0;
  for (const BreakablePiece& piece : prepared->pieces) total += piece.mass_share;
  for (BreakablePiece& piece : prepared->pieces) piece.mass_share /= total;
  return std::shared_ptr<const BreakablePieces>(std::move(prepared));
}

}  // namespace livegs
