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

// Contact margin, as a fraction of the smaller bounding radius: closer surfaces are in contact at any speed,
// and a contact point that far from a box of friction still belongs to it. Larger: more contacts are kept.
// Smaller: contacts of resting bodies flicker.
inline constexpr double kContactMargin = 0.01;

// Cosine of 30 degrees, the angle within which two normals count as one direction: contacts of one manifold,
// a contact ahead of a ball that is the current one, faces that meet without a ridge.
inline constexpr double kSameDirectionCosine = 0.866;

// Feature ids below this are points of the first body's mesh (from 2^30 on: the same of its core). Above it,
// as offsets: 0 a ball, 1 a ball ahead of its motion, 16 to 18 points of a round side, 2^30 a pair of edges,
// 2^31 points of the other body. From 2^33 on: corners, edges (3 2^32), sphere (2^34) and ridges (5 2^32) of
// a collider.
inline constexpr uint64_t kForeignFeature = uint64_t{1} << 32;

}  // namespace livegs
