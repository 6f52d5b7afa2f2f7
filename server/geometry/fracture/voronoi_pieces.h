// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/result.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/triangle_mesh.h"

// Cuts a body into the pieces that it can break into: the intersections of its closed mesh with the Voronoi
// cells of seed points. Runs once at load, on any thread. The result depends only on mesh and seeds.
//
// The cut is exact. A cell is clipped by the bisector planes to its neighbours, the triangles of the mesh are
// cut along those planes, and polygons close the cut faces. Neighbours share all vertices of the face between
// them, so volumes, masses and areas add up to the whole, up to rounding.

namespace livegs {

// No bond: the triangle lies on the surface of the whole body.
inline constexpr uint32_t kNoBond = ~0u;
inline constexpr size_t kMaxPieces = 256;

// The bond between two pieces: all cut faces between them.
struct VoronoiBond {
  uint32_t first = 0, second = 0;  // indices of pieces, first < second
  double area_m2 = 0.0;
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  // unit, from first to second
};

struct VoronoiPiece {
  TriangleMesh mesh;                    // closed, outward-facing, in the frame of the whole
  std::vector<uint32_t> triangle_bond;  // per triangle: the bond of its face, or kNoBond
  MassProperties mass;  // solid, 1 kg, about its own centre; volume_m3 is the volume of the piece
};

struct CutOptions {
  // A piece smaller than this fraction of the whole is merged with the neighbour with the largest shared
  // area.
  double smallest_share = 1e-3;
  size_t most_pieces = kMaxPieces;         // above it the smallest pieces are merged with neighbours
  std::stop_token stop;                    // checked once per cell
  std::atomic<float>* progress = nullptr;  // 0 … 1; any thread may read it
};

class VoronoiPieces {
 public:
  std::vector<Eigen::Vector3d> seeds_m;  // seeds whose cell contains a part of the body
  std::vector<VoronoiPiece> pieces;      // sorted by seed
  std::vector<VoronoiBond> bonds;        // sorted by first, then second

  // Returns the piece at a point: the cell of the nearest seed and, if that contains several parts of the
  // body, the part with the nearest surface. Exact for points in the body; points outside belong to the cell
  // that they lie in. Ties go to the lower number. Any thread.
  uint32_t locate(const Eigen::Vector3d& point_m) const;
  // Return the index in seeds_m of the nearest seed, and the piece of a point in a known cell.
  uint32_t cell_at(const Eigen::Vector3d& point_m) const;
  uint32_t locate_in(uint32_t cell, const Eigen::Vector3d& point_m) const;

  // A connected part of the body in one cell. A piece is one part, or several after slivers were merged.
  struct Part {
    uint32_t piece = 0;
    TriangleMesh mesh;  // set only if the cell has several parts
  };
  std::vector<std::vector<Part>> cell_parts;  // by cell

  // For each cell, the cells with a shared face in a box three times as wide as the body, sorted.
  std::vector<std::vector<uint32_t>> cell_neighbours;
};

// Cuts `mesh` by the cells of `seeds_m` (1 to 4096, at least a 1e-9th of the diagonal apart).
// - Vertices at the same position are welded first. A mesh that is then open, inside out or not finite is
// refused
//   with the reason and the remedy (reconstruct_surface makes a closed mesh).
// - A mesh with an inner wall is a shell, without one a solid.
// - Parts of the mesh that do not touch share no bond.
// If cancelled, returns ErrorCode::Unavailable. Deterministic for any thread count.
Result<VoronoiPieces> cut_voronoi_pieces(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> seeds_m,
                                         const CutOptions& options = {});

}  // namespace livegs
