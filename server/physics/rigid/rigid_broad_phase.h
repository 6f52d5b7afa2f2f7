// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/rigid/rigid_body.h"

namespace livegs {

// Sweep and prune over bounding boxes, enlarged by a margin and by the motion of some substeps. Pairs stay
// valid until a body leaves its box, so they are rarely recomputed. Pairs of two sleeping bodies are omitted.
// Not thread-safe.
class RigidBroadPhase {
 public:
  // Fills body.near of every body with the partners it owns, ascending. The owner is a ball before a mesh,
  // then the lower id. Does nothing while all bodies are within their boxes. `bodies` is in ascending id.
  void update(std::span<RigidBody* const> bodies, double gravity_m_s2, double duration_s);
  // Call after bodies were added, removed, woken or put to sleep.
  void invalidate() { known_ = false; }

 private:
  void find_pairs(std::span<RigidBody* const> bodies);

  bool known_ = false;
  std::vector<Eigen::AlignedBox3d> boxes_;  // parallel to `bodies`
  std::vector<uint32_t> order_;             // indices of boxes_, sorted by the lower end along axis_
  int axis_ = 0;
};

// Whether `a` owns the pair and stores its manifolds.
bool owns_pair(const RigidBody& a, const RigidBody& b);

}  // namespace livegs
