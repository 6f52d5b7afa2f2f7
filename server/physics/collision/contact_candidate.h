// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace livegs {

// A pair of close surface points, before reduction to contact manifolds.
struct ContactCandidate {
  uint64_t feature_id = 0;  // stable for the same features across substeps
  Eigen::Vector3d point_m;  // world frame
  Eigen::Vector3d normal;   // unit, world frame, from the other body towards the first
  double separation_m = 0;  // negative when overlapping
};

// Contact margin, as a fraction of the smaller bounding radius: closer surfaces are in contact at any speed.
// Larger: more contacts are kept. Smaller: contacts of resting bodies flicker.
inline constexpr double kContactMargin = 0.01;

// Cosine of 30 degrees, the angle within which two normals count as one direction: contacts of one manifold,
// the current contact of a ball and the one ahead of it, faces of a mesh without a ridge between them.
inline constexpr double kSameDirectionCosine = 0.866;
// Cosine of 60 degrees, the angle beyond which two normals are on different faces or sides: of a thin sheet,
// the end and the side of a cylinder, a support and a wall.
inline constexpr double kSameSideCosine = 0.5;

// Ranges of feature ids. Ids below kForeignFeature are points of the first body's mesh.
enum Feature : uint64_t {
  kCoreFeature = uint64_t{1} << 30,  // added to the ids of a core's ball
  kForeignFeature = uint64_t{1} << 32,
  kBallFeature = kForeignFeature,
  kAheadFeature,                         // a ball where it will be
  kRoundFeature = kForeignFeature + 16,  // points of a round side: at one end, at the other, between
  kEdgePair = kForeignFeature + (uint64_t{1} << 30),
  kOtherPoint = kForeignFeature + (uint64_t{1} << 31),  // plus the index of the other body's contact point
  // Of a collider.
  kCornerFeature = uint64_t{2} << 32,
  kEdgeFeature = uint64_t{3} << 32,
  kSphereFeature = uint64_t{4} << 32,
  kRidgeFeature = uint64_t{5} << 32,
};

}  // namespace livegs
