// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/rigid_body.h"

// Ball joints and hinges between rigid bodies, or of one body to the world.
//
// All rows of a group of jointed bodies are solved together: J M^-1 J^T, in a bandwidth-reducing order,
// factorised once before the push and once before the relax pass. A sweep is one Newton step. Chains are
// therefore stiff at any mass ratio.
//
// Time integration is RATTLE (Andersen 1983), second order, without energy loss: the push finds the impulse,
// along the rows at the start of the substep, that closes the joint at its end; the relax pass removes the
// velocity across the rows there. Remaining errors are corrected softly as for contacts.
//
// Rows of a closed loop may be linearly dependent; they are softened slightly, which bounds the impulses.
// Joints do no work: a group is slowed down if its energy exceeds the work of other forces.

namespace livegs {

struct RigidJoint {
  uint64_t id = 0;
  RigidBody* a = nullptr;
  RigidBody* b = nullptr;  // nullptr: the world
  bool hinge = false;      // otherwise a ball joint
  // Anchors from the centres of mass in body axes; of the world, a point and a direction. Axes are unit
  // vectors.
  Eigen::Vector3d anchor_a_m = Eigen::Vector3d::Zero(), anchor_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_a = Eigen::Vector3d::UnitX(), axis_b = Eigen::Vector3d::UnitX();

  // Impulses on body a in the last substep, world axes; b received the opposite. Used for warm starting.
  struct Impulse {
    Eigen::Vector3d point_n_s = Eigen::Vector3d::Zero();
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();  // N m s, perpendicular to the hinge axis
    Impulse operator*(double factor) const { return {point_n_s * factor, turn * factor}; }
  };
  Impulse push, relax;
  Impulse resting;                                     // `relax`, kept during a round of impacts
  Eigen::Vector3d load_n_s = Eigen::Vector3d::Zero();  // of the push, before the relax pass
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();   // on a, mean over the last substep

  int row_count() const { return hinge ? 5 : 3; }
  Eigen::Vector3d world_anchor_a() const { return a->world_from_body * anchor_a_m; }
  Eigen::Vector3d world_anchor_b() const {
    return b ? Eigen::Vector3d(b->world_from_body * anchor_b_m) : anchor_b_m;
  }
  // Adds an impulse on a, and its opposite on b, to the records of bodies that can break.
  void record(const Eigen::Vector3d& impulse_n_s, ImpulseKind kind, double remaining_s) const {
    a->record_joint(impulse_n_s, world_anchor_a(), kind, remaining_s);
    if (b) b->record_joint(-impulse_n_s, world_anchor_b(), kind, remaining_s);
  }
  Eigen::Vector3d turning_rad_s() const {  // of a relative to b
    return b ? Eigen::Vector3d(a->angular_velocity_rad_s - b->angular_velocity_rad_s)
             : a->angular_velocity_rad_s;
  }
  Eigen::Vector3d world_axis_a() const { return a->world_from_body.orientation * axis_a; }
  Eigen::Vector3d world_axis_b() const {
    return b ? Eigen::Vector3d(b->world_from_body.orientation * axis_b) : axis_b;
  }
};

// A connected set of jointed bodies and their joints. The bodies belong to one island, sleep and wake
// together, and are processed by one thread at a time.
class JointGroup {
 public:
  explicit JointGroup(std::vector<RigidJoint> joints);  // not empty

  const std::vector<RigidJoint>& joints() const { return joints_; }
  const std::vector<RigidBody*>& bodies() const { return bodies_; }  // ascending body_id, without the world

  bool asleep() const;
  void wake_together();  // wakes all if any is awake
  bool share_joint(const RigidBody& a, const RigidBody& b) const;

  // Phases of one substep, in order: begin before contacts act, prepare and solve (several sweeps), move,
  // prepare and solve again as the relax pass, end.
  void begin();
  void prepare(ContactPhase phase);  // for the current poses; applies the previous impulses
  void solve(ContactPhase phase, double substep_s);
  void move(double substep_s);  // integrates the poses of its bodies
  void end(double substep_s);   // after contacts; removes energy created by joints
  void reset_impulses();        // clears the warm start
  // A round of impacts (impact_phase.h), before begin; solve_impact after each sweep over the contacts.
  // end_impact adds the impulses, times `factor`, to the records of bodies that can break.
  void begin_impact();
  void solve_impact();
  void end_impact(double factor, double remaining_s);

 private:
  // Curvature of the paths of joint points and axes: difference between the mean and the current velocity of
  // a substep, per second.
  struct CurvatureCorrection {
    Eigen::Vector3d gap_m_s2 = Eigen::Vector3d::Zero();
    Eigen::Vector2d tilt_rad_s2 = Eigen::Vector2d::Zero();  // perpendicular to the axis
  };
  struct Rows {
    size_t a = 0;             // index into bodies_
    std::optional<size_t> b;  // likewise; nullopt: the world
    int first = 0;            // first row in the system
    Eigen::Vector3d arm_a_m = Eigen::Vector3d::Zero(), arm_b_m = Eigen::Vector3d::Zero();
    // Jacobians with respect to angular velocities.
    Eigen::Matrix<double, 5, 3> turn_a = Eigen::Matrix<double, 5, 3>::Zero(), turn_b = turn_a;
    // World frame: the two directions perpendicular to a hinge axis.
    Eigen::Matrix<double, 3, 2> across = Eigen::Matrix<double, 3, 2>::Zero();
    Eigen::Vector3d start_gap_m = Eigen::Vector3d::Zero();
    double correction_m_s = 0.0;                    // correction speed of the gap in the push
    CurvatureCorrection curvature, next_curvature;  // used in this substep; last measurement
    Eigen::Vector2d start_tilt = Eigen::Vector2d::Zero();
  };

  void order_joints();
  void note_nodes();
  void factorise();
  void substitute(Eigen::VectorXd& rows) const;
  void apply(const RigidJoint& joint, const Rows& rows, const RigidJoint::Impulse& impulse);
  void warm_start(ContactPhase phase);
  bool measure_curvature(double substep_s);  // whether another sweep would help
  void solve_residual(ContactPhase phase);
  void push_residual(double substep_s);
  void relax_residual();

  int small_steps(double substep_s);
  static void scale_mass(RigidBody& body, double factor);

  struct Impulses {
    Eigen::Vector3d push_n_s = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();  // N s, N m s
  };
  void note_others();
  double limit_kinetic_energy(const std::vector<RigidMotion>& starts, const std::vector<Impulses>& others,
                              double allowance_j);
  void limit_push();
  void move_in_small_steps(double substep_s, int steps);

  std::vector<double> mass_factors_;  // parallel to bodies_: mass scale during small steps

  std::vector<RigidJoint> joints_;
  std::vector<RigidBody*> bodies_;
  // Pairs in a joint or a node of joints, ascending.
  std::vector<std::pair<const RigidBody*, const RigidBody*>> joined_pairs_;
  std::vector<Rows> rows_;  // one per joint
  // Lower triangle in row-wise envelope storage: L of L D L^T, and 1 / D.
  std::vector<size_t> envelope_;  // start of row r in factor_; one more than rows
  std::vector<int> begin_;        // first column of row r
  std::vector<double> factor_;
  std::vector<double> inverse_pivot_;
  double softness_ = 0.0;                  // compliance of a row, relative to its own response
  Eigen::VectorXd residual_, compliance_;  // compliance_: speed per impulse of a softened row
  bool in_small_steps_ = false;
  bool curvature_converges_ = true;
  // Change of gaps and tilts between the last two measurements in this phase.
  std::optional<std::array<double, 2>> curvature_change_;
  // Parallel to bodies_: predicted orientation at the end of the substep.
  std::vector<Eigen::Quaterniond> ends_;
  // Parallel to bodies_: motion at the start of the substep and at the last note_others(); impulses of joints
  // since then; impulses of everything else in the substep.
  std::vector<RigidMotion> starts_, before_;
  std::vector<Impulses> given_, others_;
  // Apparent work of the joints that the group still has; decaying peak of its kinetic energy.
  double work_j_ = 0.0, peak_kinetic_j_ = 0.0;
};

// Groups whose first body is in `bodies`.
std::vector<JointGroup*> joint_groups(std::span<RigidBody* const> bodies);

// Whether a joint connects the bodies or they meet in a node of joints; contacts between them are disabled.
bool joined(const RigidBody& a, const RigidBody& b);

}  // namespace livegs
