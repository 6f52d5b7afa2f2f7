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
// the current contact of a ball and the one ahead of it.
inline constexpr double kSameDirectionCosine = 0.866;

// Feature ids below this are points of the first body's mesh.
inline constexpr uint64_t kForeignFeature = uint64_t{1} << 32;
inline constexpr uint64_t kBallFeature = kForeignFeature;
inline constexpr uint64_t kAheadFeature = kBallFeature + 1;  // a ball where it will be
// Points of a round side: at one end, at the other, between.
inline constexpr uint64_t kRoundFeature = kForeignFeature + 16;
inline constexpr uint64_t kCoreFeature = uint64_t{1} << 30;  // added to the ids of a core's ball
inline constexpr uint64_t kEdgePair = kForeignFeature + (uint64_t{1} << 30);
// The index of the other body's contact point is added.
inline constexpr uint64_t kOtherPoint = kForeignFeature + (uint64_t{1} << 31);
// Features of a collider.
inline constexpr uint64_t kCornerFeature = uint64_t{2} << 32;
inline constexpr uint64_t kEdgeFeature = uint64_t{3} << 32;
inline constexpr uint64_t kSphereFeature = uint64_t{4} << 32;
inline constexpr uint64_t kRidgeFeature = uint64_t{5} << 32;

}  // namespace livegs
