// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/collision/contact_candidate.h"
#include "physics/collision/convex_polyhedron.h"

// Contact of two convex polyhedra. Pure functions.

namespace livegs {

struct PlacedPolyhedron {
  const ConvexPolyhedron* shape;
  Eigen::Matrix3d rotation;    // world from body
  Eigen::Vector3d position_m;  // world position of the body's origin
};

// Largest gap over the separating axes (face normals of both, cross products of edges). Negative: minus the
// penetration depth. Positive: a lower bound of the distance. Stops at the first gap above `reach_m`.
double polyhedron_gap_m(const PlacedPolyhedron& a, const PlacedPolyhedron& b, double reach_m);

// Contacts within `reach_m` along the axis of least overlap; normals point from b to a. Face on face yields
// the corners of the clipped overlap (points of the incident body), edge on edge yields one point. A face is
// preferred to an edge, and a face of a to one of b, unless the other is better by more than `tolerance_m`.
// Ids encode faces, edges and corners; ids of a's own points are below kForeignFeature.
void polyhedron_contacts(const PlacedPolyhedron& a, const PlacedPolyhedron& b, double reach_m,
                         double tolerance_m, std::vector<ContactCandidate>& candidates);

}  // namespace livegs
