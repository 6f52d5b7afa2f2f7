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
  Eigen::Vector3d position_m;  // of the body's origin
};

// The largest gap along any of the separating axes (face normals of both, cross products of edges): negative
// is the least depth of overlap; positive is never more than the distance. Gives up at the first gap above
// `reach_m`.
double polyhedron_gap_m(const PlacedPolyhedron& a, const PlacedPolyhedron& b, double reach_m);

// Where they touch or are within `reach_m` along the axis of least overlap; normals from b towards a. Flat on
// flat gives the corners of the overlap of the two faces (points of the body whose face is the smaller tilted
// one), an edge across an edge one point. A face is taken before an edge, and a's before b's, that is no
// better by more than `tolerance_m`. Ids name the faces, edges and corners: those of a's own points are below
// kForeignFeature.
void polyhedron_contacts(const PlacedPolyhedron& a, const PlacedPolyhedron& b, double reach_m,
                         double tolerance_m, std::vector<ContactCandidate>& candidates);

}  // namespace livegs
