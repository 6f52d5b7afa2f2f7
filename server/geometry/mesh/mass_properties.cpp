// SPDX-License-Identifier: GPL-3.0-or-later
// Sums the exact moments over tetrahedra (origin, a, b, c) or triangles (a, b, c). With s = a + b + c, the
// integral of x xᵀ is
//   over a tetrahedron V/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ), over a triangle A/12 times the same sum.
// These are the integrals of Mirtich 1996 and Eberly 2002 without their polynomials.
#include "geometry/mesh/mass_properties.h"

#include "core/assert.h"
#include "geometry/mesh/mesh_topology.h"

namespace livegs {
namespace {

struct Moments {
  double volume = 0.0, area = 0.0;
  Eigen::Vector3d volume_first = Eigen::Vector3d::Zero(), area_first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d volume_second = Eigen::Matrix3d::Zero(), area_second = Eigen::Matrix3d::Zero();
};

// Relative to the middle of the bounding box, for precision of bodies far from the origin.
Moments moments_about(const TriangleMesh& mesh, const Eigen::Vector3d& middle) {
  Moments total;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices_m[triangle[0]] - middle,
                          b = mesh.vertices_m[triangle[1]] - middle,
                          c = mesh.vertices_m[triangle[2]] - middle;
    const Eigen::Vector3d sum = a + b + c;
    const Eigen::Matrix3d second =
        a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose();
    const double volume = a.dot(b.cross(c)) / 6.0;
    const double area = 0.5 * (b - a).cross(c - a).norm();
    total.volume += volume;
    total.area += area;
    total.volume_first += volume / 4.0 * sum;
    total.area_first += area / 3.0 * sum;
    total.volume_second += volume / 20.0 * second;
    total.area_second += area / 12.0 * second;
  }
  return total;
}

MassProperties from_moments(const Moments& moments, const Eigen::Vector3d& middle, double measure,
                            const Eigen::Vector3d& first, const Eigen::Matrix3d& second) {
  LIVEGS_ASSERT(measure > 0.0);
  const Eigen::Vector3d centre = first / measure;
  const Eigen::Matrix3d spread = second / measure - centre * centre.transpose();
  MassProperties properties;
  properties.volume_m3 = moments.volume;
  properties.area_m2 = moments.area;
  properties.centre_of_mass_m = middle + centre;
  properties.inertia_m2 = spread.trace() * Eigen::Matrix3d::Identity() - spread;
  return properties;
}

}  // namespace

MassProperties solid_mass_properties(const TriangleMesh& mesh) {
  const Eigen::Vector3d middle = mesh_bounds_m(mesh).center();
  const Moments moments = moments_about(mesh, middle);
  return from_moments(moments, middle, moments.volume, moments.volume_first, moments.volume_second);
}

MassProperties shell_mass_properties(const TriangleMesh& mesh) {
  const Eigen::Vector3d middle = mesh_bounds_m(mesh).center();
  const Moments moments = moments_about(mesh, middle);
  return from_moments(moments, middle, moments.area, moments.area_first, moments.area_second);
}

}  // namespace livegs
