// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

// Contact between elastic bodies during their steps and other moving bodies. Rows with accumulated impulses
// are solved together by projected Gauss-Seidel (Erleben 2007, Velocity-based shock propagation, section 2),
// so that all contact points share the load. The rows of two bodies are swept several times in a row; pairs
// without a common body are swept on several threads, with the same result for any number. Double precision.

namespace livegs {

struct RigidProxy;

// A material point as nodes and weights.
struct NodeSample {
  uint32_t nodes[8];
  float weights[8];
};

// A material point of one side: weighted nodes of an elastic body, or an arm from the centre of mass of a
// rigid body.
struct ContactAnchor {
  NodeSample sample{};
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();
  // Part of the displacement that is not linear in the velocities.
  Eigen::Vector3d base_m = Eigen::Vector3d::Zero();
};

// The nodes of an anchor during a step. The displacement of the anchor is
//   base_m + sum of weights (NodeSample) times corrections,
// and an impulse adds `pulls` times the impulse to the corrections of the nodes.
struct AnchorNodes {
  float* corrections = nullptr;  // four floats a node: x, y, z, unused; aligned to 16 bytes
  std::array<float, 8> pulls{};  // m/(N s)
  Eigen::Vector3d base_m = Eigen::Vector3d::Zero();
};

// The impulse of a row on one of its sides.
struct ContactImpulse {
  Eigen::Vector3d point_m;      // world
  Eigen::Vector3d impulse_n_s;  // normal and friction
  Eigen::Vector3d push_n_s;     // normal part
  uint64_t from_body_id = 0;    // of the other side
};

// Different participants may be used on different threads, each on one thread at a time.
class ContactParticipant {
 public:
  virtual ~ContactParticipant() = default;
  // Null corrections: there is no such form, and the functions below are called for each change.
  virtual AnchorNodes nodes_of(const ContactAnchor& anchor) const { return (void)anchor, AnchorNodes(); }
  // Called once per row and step, with the impulse that was added to the corrections of nodes_of.
  virtual void count_impulse(const Eigen::Vector3d& point_m, const Eigen::Vector3d& impulse_n_s) {
    (void)point_m, (void)impulse_n_s;
  }
  // Displacement of the anchor within the step per unit impulse, m/(N s).
  virtual Eigen::Matrix3d response(const ContactAnchor& anchor) const = 0;
  // Displacement in the step, including the impulses applied so far.
  virtual Eigen::Vector3d displacement_m(const ContactAnchor& anchor) const = 0;
  // Applies an impulse at the world point `point_m`, the position of the anchor.
  virtual void apply_impulse(const ContactAnchor& anchor, const Eigen::Vector3d& point_m,
                             const Eigen::Vector3d& impulse_n_s) = 0;
  // Called once per row and step with the total impulse.
  virtual void record_impulse(const ContactAnchor& anchor, const ContactImpulse& impulse) = 0;
};

// Maximum separation speed of overlaps of elastic bodies that exist at the start of a step, relative to
// sqrt(g L) with standard gravity and the reach L of the smaller body. Half its square, a quarter of a per
// cent, is the energy over m g L of a body at this speed. Larger: limp bodies that press on each other's
// edges are thrown up. Smaller: bodies that start within each other separate slowly.
inline constexpr double kMaxSeparationFroude = 0.07;
inline double separation_limit_m_s(double reach_m) {
  return kMaxSeparationFroude * std::sqrt(9.81 * reach_m);
}
// The same with colliders and rigid bodies, and between bodies of `livegs_v1`, m/s. Larger: bodies are thrown
// out. Smaller: limp bodies that a hand drags along a floor stay below it, balls do not come to rest in a
// dent.
inline constexpr double kMaxRigidSeparation_m_s = 0.5;

// Maximum gap of a row, in particle edges. Open gaps are included because a neighbouring impulse can close
// them.
inline constexpr double kRowMargin = 0.02;
// Interaction range of a surface element, in particle edges.
inline constexpr double kElementReach = 1.5;

// `a` receives +impulse, `b` the opposite at the same world point.
struct ContactConstraint {
  ContactParticipant* a = nullptr;
  ContactParticipant* b = nullptr;
  ContactAnchor anchor_a, anchor_b;
  Eigen::Vector3d point_m;  // world
  Eigen::Vector3d normal;   // unit, world, from b towards a
  double gap_m = 0.0;       // at the end of the step without contact impulses; negative: overlap
  double friction = 0.0;
  double max_separation_m_s = kMaxRigidSeparation_m_s;  // of an overlap at the start of the step
  uint64_t body_id = 0;                                 // of a, the body that listed the row
  uint64_t other_body_id = 0;                           // of b
  RigidProxy* rigid = nullptr;                          // b, if it is a rigid body
  uint32_t point = UINT32_MAX;  // of the body that listed the row; UINT32_MAX: a point of the other body

  // Before the solve: that of the last step, from which the solve starts. After it: of this step.
  double normal_impulse_n_s = 0.0;  // >= 0
  Eigen::Vector3d friction_impulse_n_s = Eigen::Vector3d::Zero();
};

// Brings the gaps of rows to zero or above at the end of the step of `step_s`; those of rows that pushed in
// the last step over a few steps (kProximalWeight). Friction opposes the relative displacement since the
// start of the step, within Coulomb's cone. There is no restitution: rebound follows from the material.
void solve_contacts(std::span<ContactConstraint* const> rows, double step_s);

}  // namespace livegs
