// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "geometry/triangle_mesh.h"

// Closed meshes of the shapes of scene files, centred at the origin, axis along +Y, outward-facing. Lengths
// in metres, positive. Round shapes are inscribed: their vertices lie on the true surface, so the mesh volume
// is slightly smaller (1.3 % for a sphere of 3 subdivisions).

namespace livegs {

// size_m: full edge lengths. Eight vertices, twelve triangles.
TriangleMesh box_mesh(const Eigen::Vector3d& size_m);

// An icosahedron with `subdivisions` (0 to 7) splits of each triangle into four: 20 * 4^subdivisions
// triangles.
TriangleMesh sphere_mesh(double radius_m, int subdivisions);

// height_m: between the flat ends. segments: around the axis, at least 3.
TriangleMesh cylinder_mesh(double radius_m, double height_m, int segments = 32);

// height_m: between the centres of the caps; the total length is height_m + 2 radius_m. segments: even.
TriangleMesh capsule_mesh(double radius_m, double height_m, int segments = 32);

}  // namespace livegs
