// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "physics/elastic_body.h"

// Deformation measures computed from the particles of a body, for any solver.

namespace livegs::study {

struct RestBox {
  Eigen::Vector3d min_m, max_m;
};

// The least-squares deformation gradient from the rest positions of the particles in `box` to their current
// positions. Precondition: they are not coplanar.
Eigen::Matrix3d mean_deformation(const ElasticBody& body, const ParticleSet& rest, const RestBox& box);

// Distance between the means of the outermost particle layers along each object axis, relative to rest.
// Precondition: particles are on planes x, y and z = const, at least two each.
Eigen::Vector3d face_to_face(const ElasticBody& body, const ParticleSet& rest);

// Twist rate about x, rad/m, of the sections x = const, over the particles in `box`. Preconditions: particles
// are on planes x = const, at least two; the twist between neighbouring planes is less than pi.
double twist_rate_rad_m(const ElasticBody& body, const ParticleSet& rest, const RestBox& box);

// Root mean square distance of the particles from their rest shape after the best rigid alignment (Kabsch).
double distance_from_rest_shape_m(const ElasticBody& body, const ParticleSet& rest);

}  // namespace livegs::study
