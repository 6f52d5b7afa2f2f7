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

// A body cut into the pieces it can break into: its closed mesh intersected with the Voronoi cells of seed
// points (physics.md 3.6). Made once at load, on any thread; the cut is a pure function of mesh and seeds.
//
// The cut is exact: a cell is clipped by the bisector planes to its neighbours, each triangle of the mesh is
// cut along those planes, and the cut faces are closed by the polygons between. Two neighbours share every
// vertex of the face between them, so volumes, masses and areas add up to those of the whole to rounding.

namespace livegs {

// No bond; of a triangle: it lies on the surface of the whole body.
inline constexpr uint32_t kNoBond = ~0u;
inline constexpr size_t kMaxPieces = 256;

// What holds two pieces together: all of the cut faces between them.
struct VoronoiBond {
  uint32_t first = 0, second = 0;  // pieces, first < second
  double area_m2 = 0.0;
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  // unit, from first to second
};

struct VoronoiPiece {
  TriangleMesh mesh;                    // closed, outwards, in the frame of the whole
  std::vector<uint32_t> triangle_bond;  // of each triangle: the bond whose face it lies on, or kNoBond
  MassProperties mass;                  // solid, of 1 kg, about its own centre; volume_m3 is the piece's
};

struct CutOptions {
  // A piece smaller than this part of the whole joins the neighbour it shares the largest area with.
  double smallest_share = 1e-3;
  size_t most_pieces = kMaxPieces;         // beyond it the smallest pieces join their neighbours
  std::stop_token stop;                    // looked at once a cell
  std::atomic<float>* progress = nullptr;  // 0 … 1, may be read by any thread
};

class VoronoiPieces {
 public:
  std::vector<Eigen::Vector3d> seeds_m;  // those whose cell holds a part of the body
  std::vector<VoronoiPiece> pieces;      // in order of seeds
  std::vector<VoronoiBond> bonds;        // sorted by first, then second

  // The piece at this point: the cell of the nearest seed, and, where that holds several parts of the body,
  // the part whose surface is nearest. Exact for points in the body; points outside go with the cell they lie
  // in. Ties go to the lower number. Any thread.
  uint32_t locate(const Eigen::Vector3d& point_m) const;
  // The number in seeds_m of the nearest seed, and the piece for a point that is known to belong to a cell.
  uint32_t cell_at(const Eigen::Vector3d& point_m) const;
  uint32_t locate_in(uint32_t cell, const Eigen::Vector3d& point_m) const;

  // One connected part of the body in one cell. A piece is one part, or several where slivers joined it.
  struct Part {
    uint32_t piece = 0;
    TriangleMesh mesh;  // only where the cell has several parts
  };
  std::vector<std::vector<Part>> cell_parts;  // by cell

  // By cell, the cells it shares a face with in a box three times as wide as the body, sorted.
  std::vector<std::vector<uint32_t>> cell_neighbours;
};

// Cuts `mesh` by the cells of `seeds_m` (1 to 4096, at least a 1e-9th of the diagonal apart).
// Vertices at the same place are welded first; a mesh that is open, inside out or not finite after that is
// refused: a message names what is wrong and the remedy (reconstruct_surface makes a closed one). A hollow
// body is cut as what its mesh says: with an inner wall it is a shell, without one a solid. Parts of the mesh
// that touch nowhere share no bond. Cancelled: ErrorCode::Unavailable. Deterministic for any thread count.
Result<VoronoiPieces> cut_voronoi_pieces(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> seeds_m,
                                         const CutOptions& options = {});

}  // namespace livegs
