// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// A closed surface as it comes out of a triangulation: triangles over numbered points, and which runs beside
// which along each edge. Half-edge 3 t + k of triangle t goes from its corner k to corner k + 1; a half-edge
// and its twin join the same two points in opposite directions.
struct PairedTriangles {
  std::vector<std::array<uint32_t, 3>> corners;
  std::vector<uint32_t> twins;
};

// An indexed mesh that is manifold as `twins` says it, though the surface may touch itself: a point at which
// several fans meet becomes as many vertices, and where two pairs of triangles would still share both ends of
// an edge, the edge of the later pair is split in the middle. Shape and volume do not change; vertices are
// numbered in order of use.
TriangleMesh assemble_surface(const PairedTriangles& surface,
                              const std::function<Eigen::Vector3d(uint32_t point)>& position);

}  // namespace livegs
