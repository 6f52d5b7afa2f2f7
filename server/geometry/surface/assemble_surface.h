// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// A closed surface from a triangulation: triangles with point numbers, and the pairing of their half-edges.
// Half-edge 3 t + k of triangle t goes from its corner k to corner k + 1. A half-edge and its twin join the
// same two points in opposite directions.
struct PairedTriangles {
  std::vector<std::array<uint32_t, 3>> corners;
  std::vector<uint32_t> twins;
};

// Builds an indexed mesh that is manifold according to `twins`, even if the surface touches itself. A point
// where several fans meet becomes several vertices. If two pairs of triangles still share both ends of an
// edge, the edge of the later pair is split in the middle. Shape and volume do not change; vertices are
// numbered in order of use.
TriangleMesh assemble_surface(const PairedTriangles& surface,
                              const std::function<Eigen::Vector3d(uint32_t point)>& position);

}  // namespace livegs
