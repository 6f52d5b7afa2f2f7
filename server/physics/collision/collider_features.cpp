// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/collider_features.h"

#include <algorithm>
#include <cmath>

#include "physics/collision/contact_candidate.h"
#include "physics/mesh_collider.h"

namespace livegs {
namespace {

void box_features(const BoxShape& box, const Collider& collider, const Eigen::Vector3d& centre, double reach,
                  double spacing, std::vector<ColliderFeature>& features) {
  const Eigen::Vector3d half = 0.5 * box.size_m;
  const Eigen::Vector3d local = collider.world_from_collider.inverse() * centre;
  for (uint64_t corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d point((corner & 1) ? half.x() : -half.x(), (corner & 2) ? half.y() : -half.y(),
                                (corner & 4) ? half.z() : -half.z());
    if ((point - local).norm() <= reach) {
      features.push_back({kCornerFeature + corner, collider.world_from_collider * point, 0.0});
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (uint64_t side = 0; side < 4; ++side) {
      Eigen::Vector3d point = Eigen::Vector3d::Zero();
      point[u] = (side & 1) ? half[u] : -half[u];
      point[v] = (side & 2) ? half[v] : -half[v];
      const double du = point[u] - local[u], dv = point[v] - local[v];
      const double chord2 = reach * reach - du * du - dv * dv;
      if (chord2 < 0.0) continue;
      const double chord = std::sqrt(chord2);
      const double low = std::max(-half[axis], local[axis] - chord),
                   high = std::min(half[axis], local[axis] + chord);
      for (int64_t k = static_cast<int64_t>(std::ceil(low / spacing)); k * spacing <= high; ++k) {
        point[axis] = static_cast<double>(k) * spacing;
        const uint64_t id = kEdgeFeature + (static_cast<uint64_t>(axis) * 4 + side) * (uint64_t{1} << 26) +
                            static_cast<uint64_t>(k + (int64_t{1} << 25));
        features.push_back({id, collider.world_from_collider * point, 0.0});
      }
    }
  }
}

void ridge_features(const FieldShape& shape, const Collider& collider, const Eigen::Vector3d& centre,
                    double reach, std::vector<ColliderFeature>& features) {
  const RidgePoints& ridges = *shape.ridges;
  const Eigen::Vector3d local = collider.world_from_collider.inverse() * centre;
  std::vector<uint32_t> near;
  reach += shape.half_thickness_m;
  ridges.tree.near([&](const Eigen::Vector3d& point) { return (point - local).norm(); }, reach, near);
  for (const uint32_t i : near) {
    const Eigen::Vector3d& point = ridges.points_m[i];
    if ((point - local).norm() > reach) continue;
    features.push_back({kRidgeFeature + i, collider.world_from_collider * point, shape.half_thickness_m});
  }
}

}  // namespace

std::vector<ColliderFeature> collider_features(const Collider& collider, const Eigen::Vector3d& centre_m,
                                               double reach_m, double spacing_m) {
  std::vector<ColliderFeature> features;
  if (const auto* box = std::get_if<BoxShape>(&collider.shape)) {
    box_features(*box, collider, centre_m, reach_m, spacing_m, features);
  } else if (const auto* sphere = std::get_if<SphereShape>(&collider.shape)) {
    features.push_back({kSphereFeature, collider.world_from_collider.position_m, sphere->radius_m});
  } else if (const auto* field = std::get_if<FieldShape>(&collider.shape); field && field->ridges) {
    ridge_features(*field, collider, centre_m, reach_m, features);
  }
  return features;
}

}  // namespace livegs
