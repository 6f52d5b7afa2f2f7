// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/rigid_islands.h"

namespace livegs {

// The contacts of an island in batches of four, for the sweeps of the solver (Catto 2024, Solver2D: soft
// step). The contacts of a batch share no awake body, and contacts that share one keep their order in the
// island. The result is therefore that of one contact after the other.
//
// Velocities, poses and impulses are copies: load_ and store_ exchange them with the bodies and manifolds.
// One thread. The island must outlive the object; its lists must not change.
class ContactLanes {
 public:
  // Reads the manifolds. `step_s`: duration of a solver step.
  ContactLanes(const RigidIsland& island, double step_s);
  ~ContactLanes();

  void load_poses();   // and masses
  void load_motion();  // velocities; the batches must not hold unstored motion
  // Velocities, and the angular momentum of the impulses since the last call.
  void store_motion();
  void store_points() const;    // impulses, as RigidBody::move reads them, and separations
  void store_friction() const;  // and arms, as record_impulses reads them

  // Phases of a solver step, in order.

  // Effective masses for the loaded poses.
  void prepare();
  // Whether a point closes fast enough for an impact in this step (begin_impact).
  bool any_impact() const;
  void warm_start();
  void sweep(ContactPhase phase);
  // Separations after the bodies have moved.
  void update_separations();

 private:
  struct Batch;
  struct Motion;
  struct BodyPose;

  static std::vector<Batch>& spare_batches();
  void schedule();
  void read_manifolds();
  template <typename Each>
  void for_contacts(const Each& each) const;  // each(contact, batch, lane)
  void count_momentum();

  const RigidIsland& island_;
  double step_s_;
  ContactSoftness soft_;
  std::vector<RigidBody*> bodies_;  // slot 0: static bodies, null
  std::vector<Motion> motion_;
  std::vector<BodyPose> poses_;
  std::vector<Batch> batches_;
};

}  // namespace livegs
