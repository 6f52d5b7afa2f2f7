// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Of a body of total mass 1 kg: multiply the inertia by the mass. Eberly 2002, Polyhedral mass properties.
struct MassProperties {
  double volume_m3 = 0.0;  // enclosed
  double area_m2 = 0.0;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_m2 = Eigen::Matrix3d::Identity();  // about the centre of mass, object axes
};

// Mass spread evenly through the enclosed volume. Precondition: a closed mesh with positive volume.
MassProperties solid_mass_properties(const TriangleMesh& mesh);

// Mass spread evenly over the surface: a shell of negligible thickness.
MassProperties shell_mass_properties(const TriangleMesh& mesh);

}  // namespace livegs
