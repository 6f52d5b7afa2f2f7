// SPDX-License-Identifier: GPL-3.0-or-later
// Möller, Trumbore 1997, Fast minimum storage ray/triangle intersection.
#include "physics/rigid/rigid_ray_cast.h"

#include <cmath>

namespace livegs {
namespace {

std::optional<double> sphere_distance(const Eigen::Vector3d& from_centre, const Eigen::Vector3d& direction,
                                      double radius) {
  const double along = from_centre.dot(direction);
  const double square = along * along - from_centre.squaredNorm() + radius * radius;
  if (square < 0.0) return std::nullopt;
  const double distance = -along - std::sqrt(square);
  return distance >= 0.0 ? std::optional(distance) : std::nullopt;
}

}  // namespace

std::optional<double> ray_cast(const RigidBody& body, const Eigen::Vector3d& origin_m,
                               const Eigen::Vector3d& direction) {
  const Eigen::Vector3d from_centre = origin_m - body.world_from_body.position_m;
  if (body.shape.is_ball()) return sphere_distance(from_centre, direction, body.shape.sphere_radius_m);
  const double radius = body.shape.bounding_radius_m;
  if (from_centre.cross(direction).norm() > radius || from_centre.dot(direction) > radius)
    return std::nullopt;

  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  const Eigen::Vector3d origin = body_from_world * from_centre, ray = body_from_world * direction;
  std::optional<double> nearest;
  for (const auto& triangle : body.shape.mesh.triangles) {
    const Eigen::Vector3d& corner = body.shape.mesh.vertices_m[triangle[0]];
    const Eigen::Vector3d ab = body.shape.mesh.vertices_m[triangle[1]] - corner;
    const Eigen::Vector3d ac = body.shape.mesh.vertices_m[triangle[2]] - corner;
    const Eigen::Vector3d p = ray.cross(ac);
    const double determinant = ab.dot(p);
    if (determinant <= 0.0) continue;  // parallel or back-facing
    const Eigen::Vector3d t = origin - corner;
    const double u = t.dot(p);
    if (u < 0.0 || u > determinant) continue;
    const Eigen::Vector3d q = t.cross(ab);
    const double v = ray.dot(q);
    if (v < 0.0 || u + v > determinant) continue;
    const double distance = ac.dot(q) / determinant;
    if (distance >= 0.0 && (!nearest || distance < *nearest)) nearest = distance;
  }
  return nearest;
}

}  // namespace livegs
