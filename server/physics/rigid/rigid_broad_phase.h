// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/rigid/rigid_body.h"

namespace livegs {

// Which rigid bodies may touch: boxes around them, wider than the bodies by a margin and by some ticks'
// motion, sorted along one axis. The pairs stay good until a body leaves its box, so that they are looked for
// only now and then. Pairs of two sleepers are left out. One thread.
class RigidBroadPhase {
 public:
  // Fills body.near of every body: the partners it owns (a ball before a mesh, then the lower id), ascending.
  // Does nothing while all bodies are where they were expected. `bodies` in ascending id.
  void update(std::span<RigidBody* const> bodies, double gravity_m_s2, double duration_s);
  // Bodies were added, removed, woken or sent to sleep.
  void invalidate() { known_ = false; }

 private:
  struct Box {
    Eigen::Vector3d low, high;
    RigidBody* body = nullptr;
  };
  void find_pairs();

  bool known_ = false;
  std::vector<Box> boxes_;       // of `bodies`, in their order
  std::vector<uint32_t> order_;  // of boxes_, by their low end along axis_
  int axis_ = 0;
};

// The first of a pair, whose manifolds theirs are.
bool owns_pair(const RigidBody& a, const RigidBody& b);

}  // namespace livegs
