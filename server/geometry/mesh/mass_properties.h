// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Mass properties for a total mass of 1 kg; multiply the inertia by the mass. Eberly 2002, Polyhedral mass
// properties.
struct MassProperties {
  double volume_m3 = 0.0;  // enclosed volume
  double area_m2 = 0.0;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
  // About the centre of mass, object axes, per kilogram.
  Eigen::Matrix3d inertia_m2 = Eigen::Matrix3d::Identity();
};

// Properties of a solid of uniform density. Precondition: a closed mesh with positive volume.
MassProperties solid_mass_properties(const TriangleMesh& mesh);

// Properties of a shell of negligible thickness with uniform mass per area.
MassProperties shell_mass_properties(const TriangleMesh& mesh);

}  // namespace livegs
