// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "core/result.h"
#include "geometry/fracture/voronoi_pieces.h"
#include "physics/collision/collision_shape.h"
#include "physics/material.h"

// Pieces of a fragile body, computed at load: its Voronoi cut, with mass share and contact shape of each
// piece. Fragments of several pieces are assembled from these at fracture time, which is cheap.

namespace livegs {

struct BreakablePiece {
  double mass_share = 0.0;                  // fraction of the whole; the sum is 1
  MassProperties mass;                      // per kg, object frame
  std::shared_ptr<const RigidShape> shape;  // origin at mass.centre_of_mass_m
  // Surface points, object frame, grouped by face: the outside of the whole (kNoBond) or the face of a bond.
  // Every prefix of a list is evenly spread.
  struct SurfacePoints {
    uint32_t bond = kNoBond;
    std::vector<Eigen::Vector3d> points_m;
  };
  std::vector<SurfacePoints> surface;
};

struct BreakablePieces {
  VoronoiPieces cut;
  std::vector<BreakablePiece> pieces;  // parallel to cut.pieces
};

struct BreakableOptions {
  size_t piece_count = 32;  // requested, 1 to 64
  uint64_t seed = 1;
  std::stop_token stop{};
};

// Cuts a closed mesh (object frame). Mass is distributed over the volume, or evenly over the outer surface if
// `fill` is a shell and the mesh has no inner wall. May be called from any thread; takes seconds for a fine
// mesh. The result does not depend on the thread count. Errors describe the defect of the mesh.
Result<std::shared_ptr<const BreakablePieces>> prepare_pieces(const TriangleMesh& mesh, Fill fill,
                                                              const BreakableOptions& options = {});

// Mass properties per kg of a set of pieces (ascending indices, at least one), object frame. Volume and area
// are sums.
MassProperties joined_mass(const BreakablePieces& pieces, std::span<const uint32_t> members);
double joined_share(const BreakablePieces& pieces, std::span<const uint32_t> members);

// Contact shape of a set of connected pieces, relative to `centre_m`: their outside and the open cut faces.
RigidShape joined_shape(const BreakablePieces& pieces, std::span<const uint32_t> members,
                        const Eigen::Vector3d& centre_m);

}  // namespace livegs
