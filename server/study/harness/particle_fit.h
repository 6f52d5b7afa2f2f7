// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "physics/elastic_body.h"

// What the particles of a body say about its deformation, whatever solver moves them.

namespace livegs::study {

struct RestBox {
  Eigen::Vector3d min_m, max_m;
};

// The deformation gradient that maps the rest positions of the particles in `box` to where they are now with
// the least squared error. Precondition: they do not lie in a plane.
Eigen::Matrix3d mean_deformation(const ElasticBody& body, const ParticleSet& rest, const RestBox& box);

// How far the outermost layers of particles along each object axis are apart, between their means, over how
// far they were. Precondition: particles lie on planes x, y and z = const, two at least.
Eigen::Vector3d face_to_face(const ElasticBody& body, const ParticleSet& rest);

// How fast the sections x = const turn about x along the body, in rad/m, over the particles in `box`.
// Preconditions: particles lie on planes x = const, two at least; sections turn less than pi from plane to
// plane.
double twist_rate_rad_m(const ElasticBody& body, const ParticleSet& rest, const RestBox& box);

// Root mean square distance of the particles from their rest shape in its best position (Kabsch).
double distance_from_rest_shape_m(const ElasticBody& body, const ParticleSet& rest);

}  // namespace livegs::study
