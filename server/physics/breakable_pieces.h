// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geometry/fracture/voronoi_pieces.h"
#include "physics/collision/collision_shape.h"

// Pieces of a fragile body, computed at load (server/prepare): its Voronoi cut, with mass share and contact
// shape of each piece. Fragments of several pieces are assembled from these at fracture time, which is cheap.

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

// Mass properties per kg of a set of pieces (ascending indices, at least one), object frame. Volume and area
// are sums.
MassProperties joined_mass(const BreakablePieces& pieces, std::span<const uint32_t> members);
double joined_share(const BreakablePieces& pieces, std::span<const uint32_t> members);

// Contact shape of a set of connected pieces, relative to `centre_m`: their outside and the open cut faces.
RigidShape joined_shape(const BreakablePieces& pieces, std::span<const uint32_t> members,
                        const Eigen::Vector3d& centre_m);

}  // namespace livegs
