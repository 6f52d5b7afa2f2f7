// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collider.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

using Eigen::Vector3d;

// The following functions work in the collider's frame.

SurfaceSample sample(const PlaneShape&, const Vector3d& point) { return {point.y(), Vector3d::UnitY()}; }

SurfaceSample sample(const SphereShape& sphere, const Vector3d& point) {
  const double radius = point.norm();
  // At the centre the normal is undefined; use a fixed direction.
  const Vector3d normal = radius > 0.0 ? Vector3d(point / radius) : Vector3d::UnitY();
  return {radius - sphere.radius_m, normal};
}

SurfaceSample sample(const BoxShape& box, const Vector3d& point) {
  const Vector3d beyond = point.cwiseAbs() - 0.5 * box.size_m;  // along each axis; negative inside
  Eigen::Index axis;
  const double depth = beyond.maxCoeff(&axis);
  if (depth <= 0.0) return {depth, Vector3d::Unit(axis) * (point[axis] < 0.0 ? -1.0 : 1.0)};
  Vector3d away = beyond.cwiseMax(0.0);
  const double distance = away.norm();
  for (int d = 0; d < 3; ++d) {
    if (point[d] < 0.0) away[d] = -away[d];
  }
  return {distance, away / distance};
}

SurfaceSample sample(const FieldShape& shape, const Vector3d& point) {
  const DistanceField::Sample found = shape.field->sample(point);
  // Near a sheet its triangles are sampled, because the grid rounds off bends and borders. Nodes of the cells
  // that the sheet crosses are up to 1.73 cells away.
  if (shape.sheet && found.distance_m < 2.0 * shape.field->cell_m()) {
    const TriangleTree::Nearest nearest = shape.sheet->nearest(point);
    const Vector3d away = point - nearest.foot_m;
    const bool outside = nearest.distance_m > 1e-6 * shape.field->cell_m();
    return {nearest.distance_m - shape.half_thickness_m,
            outside ? Vector3d(away / nearest.distance_m) : nearest.normal};
  }
  const double length = found.gradient.norm();
  // The gradient of an interpolated field vanishes on the medial axis.
  return {found.distance_m - shape.half_thickness_m,
          length > 1e-9 ? Vector3d(found.gradient / length) : Vector3d::UnitY()};
}

}  // namespace

ColliderProbe::ColliderProbe(const Collider& collider)
    : collider_(collider),
      world_from_collider_(collider.world_from_collider.orientation.toRotationMatrix()),
      up_(world_from_collider_.col(1)),
      plane_(std::holds_alternative<PlaneShape>(collider.shape)) {}

SurfaceSample ColliderProbe::sample_shape(const Vector3d& point_m) const {
  const Vector3d local =
      world_from_collider_.transpose() * (point_m - collider_.world_from_collider.position_m);
  SurfaceSample found =
      std::visit([&](const auto& shape) { return livegs::sample(shape, local); }, collider_.shape);
  found.normal = world_from_collider_ * found.normal;
  return found;
}

SurfaceSample sample_surface(const Collider& collider, const Vector3d& point_m) {
  return ColliderProbe(collider).sample(point_m);
}

double min_thickness_m(const FieldShape& shape) {
  return shape.sheet ? 2.0 * shape.half_thickness_m : shape.field->thinnest_m();
}

double mixed_friction(double a, double b) { return std::sqrt(std::max(0.0, a) * std::max(0.0, b)); }

double mixed_restitution(double a, double b) { return std::max(a, b); }

}  // namespace livegs
