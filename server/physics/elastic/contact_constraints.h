// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "physics/lattice/node_sample.h"

// Contact between elastic bodies in the middle of their steps and what else moves: rows with accumulated
// impulses, solved together by projected Gauss-Seidel (Erleben 2007, Velocity-based shock propagation,
// section 2), so that the points under a heavy or a light body share its weight. In double; one thread.

namespace livegs {

struct RigidProxy;

// A material point of one side: nodes with weights of an elastic body, an arm from the centre of mass of a
// rigid one.
struct ContactAnchor {
  NodeSample sample{};
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d base_m =
      Eigen::Vector3d::Zero();  // of its way, what does not follow from velocities linearly
};

class ContactParticipant {
 public:
  virtual ~ContactParticipant() = default;
  // How far the anchor goes within the step for an impulse there, m per N s.
  virtual Eigen::Matrix3d response(const ContactAnchor& anchor) const = 0;
  // How far it goes in the step as far as is known now, with the impulses given so far.
  virtual Eigen::Vector3d displacement_m(const ContactAnchor& anchor) const = 0;
  // An impulse at the world point `point_m`, where the anchor is.
  virtual void apply_impulse(const ContactAnchor& anchor, const Eigen::Vector3d& point_m,
                             const Eigen::Vector3d& impulse_n_s) = 0;
  // Once a row and step: the sum of what was given.
  virtual void record_impulse(const ContactAnchor& anchor, const Eigen::Vector3d& point_m,
                              const Eigen::Vector3d& impulse_n_s) = 0;
};

// Overlaps at the start of the step part no faster than this, so that what starts inside something is not
// shot out.
inline constexpr double kContactPushSpeed_m_s = 0.5;

// `a` gets +impulse, `b` exactly the opposite at the same world point.
struct ContactConstraint {
  ContactParticipant* a = nullptr;
  ContactParticipant* b = nullptr;
  ContactAnchor anchor_a, anchor_b;
  Eigen::Vector3d point_m;  // world
  Eigen::Vector3d normal;   // unit, world, from b towards a
  double gap_m = 0.0;       // at the end of the step if nothing acts; negative when overlapping
  double friction = 0.0;
  double push_m_s = kContactPushSpeed_m_s;  // overlaps at the start of the step part no faster than this
  uint64_t other_body_id = 0;               // whom the body meets that listed it
  RigidProxy* rigid = nullptr;              // b, where it is one

  // Set by solve_contacts.
  Eigen::Vector3d displacement_before_m;  // of a relative to b
  double normal_response = 0.0, tangent_response = 0.0;
  double normal_impulse_n_s = 0.0;  // >= 0
  Eigen::Vector3d friction_impulse_n_s = Eigen::Vector3d::Zero();
  double least_gap_m = 0.0;
};

// Takes every row's gap to zero or more at the end of the step of `step_s`; friction keeps the points
// together since the start of the step, within Coulomb's cone. There is no restitution: how a soft body
// bounces is up to its material.
void solve_contacts(std::vector<ContactConstraint>& rows, double step_s);

}  // namespace livegs
