// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "geometry/triangle_mesh.h"

// Closed meshes of the shapes a scene may name, centred at the origin, axis along +Y, outwards. Lengths in
// metres, all positive. Round shapes are inscribed: their vertices lie on the true surface, so a mesh holds
// slightly less than the shape (a sphere of 3 subdivisions 1.3 % less).

namespace livegs {

// size_m: full edge lengths. Eight vertices, twelve triangles.
TriangleMesh box_mesh(const Eigen::Vector3d& size_m);

// An icosahedron whose triangles are split in four `subdivisions` times (0 to 7): 20 * 4^subdivisions
// triangles.
TriangleMesh sphere_mesh(double radius_m, int subdivisions);

// height_m: between the two flat ends. segments: around the axis, at least 3.
TriangleMesh cylinder_mesh(double radius_m, double height_m, int segments = 32);

// height_m: between the centres of the caps, so that the whole is height_m + 2 radius_m long; segments even.
TriangleMesh capsule_mesh(double radius_m, double height_m, int segments = 32);

}  // namespace livegs
