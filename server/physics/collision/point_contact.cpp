// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/point_contact.h"

#include <algorithm>
#include <cmath>

#include "physics/collision/conservative_advancement.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// Thickness that a point can tunnel through, m.
double thickness_m(const Collider& collider) {
  if (const auto* box = std::get_if<BoxShape>(&collider.shape)) return box->size_m.minCoeff();
  if (const auto* sphere = std::get_if<SphereShape>(&collider.shape)) return 2.0 * sphere->radius_m;
  if (const auto* field = std::get_if<FieldShape>(&collider.shape)) return min_thickness_m(*field);
  return INFINITY;
}

}  // namespace

Vector3d contact_correction(const Vector3d& normal, double depth_m, const Vector3d& moved_m,
                            double friction) {
  const Vector3d slid = moved_m - normal * normal.dot(moved_m);
  const double displacement = slid.norm(), hold = friction * depth_m;
  const double part = displacement > hold ? hold / displacement : 1.0;
  return depth_m * normal - part * slid;
}

SurfaceSample swept_surface(const ColliderProbe& collider, const Vector3d& from_m, const Vector3d& to_m) {
  const SurfaceSample at = collider.sample(to_m);
  const double thickness = thickness_m(collider.collider());
  const Vector3d displacement = to_m - from_m;
  if (!(displacement.norm() > kMaxUnsweptPart * thickness)) return at;
  const auto sample = [&](const Vector3d& point) { return collider.sample(point); };
  const auto hit = cast_sphere(sample, from_m, displacement, 0.0, 0.01 * thickness);
  if (!hit) return at;
  return {hit->separation_m + hit->normal.dot(displacement), hit->normal};
}

bool reaches(const Collider& collider, const Vector3d& centre_m, double radius_m) {
  const auto* field = std::get_if<FieldShape>(&collider.shape);
  const double margin = field ? 2.0 * field->field->cell_m() : 0.0;
  return sample_surface(collider, centre_m).distance_m <= radius_m + margin;
}

void reachable_colliders(std::span<const Collider> colliders, const Vector3d& centre_m, double reach_m,
                         std::vector<const Collider*>& reachable) {
  reachable.clear();
  for (const Collider& collider : colliders) {
    if (reaches(collider, centre_m, reach_m)) reachable.push_back(&collider);
  }
}

}  // namespace livegs
