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

// What a fragile body can break into, made at load: the pieces of its Voronoi cut, each with its share of the
// mass and its contact shape. Bodies of several pieces are put together from these when it breaks, which is
// cheap.

namespace livegs {

struct BreakablePiece {
  double mass_share = 0.0;                  // of the whole; all sum to 1
  MassProperties mass;                      // of 1 kg, object frame
  std::shared_ptr<const RigidShape> shape;  // about mass.centre_of_mass_m
  // Points of its surface, object frame, by what they lie on: the outside of the whole (kNoBond) or the face
  // of a bond. Each list is spread evenly however far it is read.
  struct SurfacePoints {
    uint32_t bond = kNoBond;
    std::vector<Eigen::Vector3d> points_m;
  };
  std::vector<SurfacePoints> surface;
};

struct BreakablePieces {
  VoronoiPieces cut;
  std::vector<BreakablePiece> pieces;  // as cut.pieces
};

struct BreakableOptions {
  size_t piece_count = 32;  // wanted, 1 to 64
  uint64_t seed = 1;
  std::stop_token stop{};
};

// Cuts a closed mesh (object frame). Mass is spread through the volume, or evenly over the outside of the
// whole where `fill` is a shell and the mesh has no inner wall. Any thread, takes seconds for a fine mesh;
// the same bits for any thread count. Errors name what is wrong with the mesh.
Result<std::shared_ptr<const BreakablePieces>> prepare_pieces(const TriangleMesh& mesh, Fill fill,
                                                              const BreakableOptions& options = {});

// Of 1 kg of some pieces together (ascending numbers, at least one), object frame; volume and area are sums.
MassProperties joined_mass(const BreakablePieces& pieces, std::span<const uint32_t> members);
double joined_share(const BreakablePieces& pieces, std::span<const uint32_t> members);

// The contact shape of some pieces that hold together, about `centre_m`: their outside and the cut faces that
// are open.
RigidShape joined_shape(const BreakablePieces& pieces, std::span<const uint32_t> members,
                        const Eigen::Vector3d& centre_m);

}  // namespace livegs
