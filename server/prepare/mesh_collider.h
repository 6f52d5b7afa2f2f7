// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/triangle_mesh.h"
#include "physics/collider.h"

namespace livegs {

// Both colliders have a distance field of 64 cells along the longest side and ridge points half a cell apart.
// Precondition: at least one triangle has an area.

// Solid collider of a closed mesh, exact at thin walls. Inside-out parts are flipped; parts that face inwards
// inside another part are cavities.
FieldShape mesh_collider(const TriangleMesh& mesh);

// Thin-wall collider of an open mesh (or a room): solid within half the wall thickness on either side of the
// surface. The orientation of the triangles is ignored.
FieldShape wall_collider(const TriangleMesh& mesh);
// Wall thickness, m: 4 mm, or 1/64 of the longest side if that is less. Thinner: fast objects tunnel.
// Thicker: resting objects hover visibly.
double wall_thickness_m(double longest_m);

}  // namespace livegs
