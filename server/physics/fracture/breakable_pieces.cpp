// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/breakable_pieces.h"

#include <algorithm>
#include <cmath>

#include "geometry/field/point_grid.h"

namespace livegs {

double joined_share(const BreakablePieces& pieces, std::span<const uint32_t> members) {
  double share = 0.0;
  for (const uint32_t member : members) share += pieces.pieces[member].mass_share;
  return share;
}

MassProperties joined_mass(const BreakablePieces& pieces, std::span<const uint32_t> members) {
  MassProperties joined;
  joined.inertia_m2.setZero();
  const double share = joined_share(pieces, members);
  for (const uint32_t member : members) {
    const BreakablePiece& piece = pieces.pieces[member];
    joined.volume_m3 += piece.mass.volume_m3;
    joined.area_m2 += piece.mass.area_m2;
    joined.centre_of_mass_m += piece.mass_share / share * piece.mass.centre_of_mass_m;
  }
  for (const uint32_t member : members) {
    const BreakablePiece& piece = pieces.pieces[member];
    const Eigen::Vector3d arm = piece.mass.centre_of_mass_m - joined.centre_of_mass_m;
    joined.inertia_m2 +=
        piece.mass_share / share *
        (piece.mass.inertia_m2 + arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
  }
  return joined;
}

RigidShape joined_shape(const BreakablePieces& pieces, std::span<const uint32_t> members,
                        const Eigen::Vector3d& centre_m) {
  if (members.size() == 1) return *pieces.pieces[members[0]].shape;
  RigidShape shape;
  shape.min_m.setConstant(INFINITY);
  shape.max_m.setConstant(-INFINITY);
  const auto within = [&](uint32_t bond) {
    return bond != kNoBond && std::ranges::binary_search(members, pieces.cut.bonds[bond].first) &&
           std::ranges::binary_search(members, pieces.cut.bonds[bond].second);
  };
  for (const uint32_t member : members) {
    const BreakablePiece& piece = pieces.pieces[member];
    const VoronoiPiece& cut = pieces.cut.pieces[member];
    const Eigen::Vector3d offset = piece.mass.centre_of_mass_m - centre_m;
    shape.parts.push_back({piece.shape, offset});
    const auto first = static_cast<uint32_t>(shape.mesh.vertices_m.size());
    for (const Eigen::Vector3d& vertex : cut.mesh.vertices_m)
      shape.mesh.vertices_m.push_back(vertex - centre_m);
    for (size_t t = 0; t < cut.mesh.triangles.size(); ++t) {
      if (within(cut.triangle_bond[t])) continue;
      const auto& [a, b, c] = cut.mesh.triangles[t];
      shape.mesh.triangles.push_back({first + a, first + b, first + c});
    }
    shape.min_m = shape.min_m.cwiseMin(offset + piece.shape->min_m);
    shape.max_m = shape.max_m.cwiseMax(offset + piece.shape->max_m);
  }
  for (const Eigen::Vector3d& vertex : shape.mesh.vertices_m) {
    shape.bounding_radius_m = std::max(shape.bounding_radius_m, vertex.norm());
  }
  // Takes a prefix of each list within the limit of contact points. A corner of several faces is taken once.
  shape.contact_spacing_m = kContactPointSpacing * (shape.max_m - shape.min_m).maxCoeff();
  PointGrid taken({shape.min_m, shape.max_m}, shape.contact_spacing_m);
  const size_t most = std::max<size_t>(1, kMaxContactPoints / members.size());
  for (const uint32_t member : members) {
    size_t left = most;
    for (const BreakablePiece::SurfacePoints& face : pieces.pieces[member].surface) {
      if (within(face.bond)) continue;
      const size_t share = face.bond == kNoBond ? most * 3 / 4 + 1 : most / 4 + 1;
      const size_t count = std::min({left, share, face.points_m.size()});
      for (size_t i = 0; i < count; ++i) {
        const Eigen::Vector3d point = face.points_m[i] - centre_m;
        if (taken.has_neighbour_within(point, 1e-3 * shape.contact_spacing_m)) continue;
        taken.insert(point);
        shape.contact_points_m.push_back(point);
      }
      left -= count;
    }
  }
  shape.contact_tree = BoundingSphereTree(shape.contact_points_m);
  shape.inner_radius_m = inner_radius_m(shape);
  return shape;
}

}  // namespace livegs
