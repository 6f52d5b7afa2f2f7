// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/rigid_body.h"

// Ball joints and hinges between rigid bodies, or of one to the world.
//
// Bodies that are joined form a group, and the rows of a group are solved together: the blocks J M^-1 J^T of
// joints that share a body, in an order that keeps them near the diagonal, factorised once before the push
// and once before the relax pass. A sweep is one Newton step. So a chain holds whatever the ratio of its
// masses.
//
// In time it is RATTLE (Andersen 1983): the push finds the impulse, along the rows at the start of the
// substep, with which the joint is closed at its end, where the bodies will be; the relax pass takes out the
// velocity across the rows there. Second order and without loss of energy. What error is left, from contacts
// that push the other way, is taken back softly, as with contacts.
//
// In a closed loop rows may say the same twice, or nearly, when bodies lie in a line: there every row gives a
// little, and the impulses stay bounded. Joints do no work: a group is slowed where it has more energy than
// what else acted gave it.

namespace livegs {

struct RigidJoint {
  uint64_t id = 0;
  RigidBody* a = nullptr;
  RigidBody* b = nullptr;  // nullptr: the world
  bool hinge = false;      // otherwise a ball joint
  // From the centres of mass in the bodies' own axes; of the world: a point and a direction. Axes are unit
  // vectors.
  Eigen::Vector3d anchor_a_m = Eigen::Vector3d::Zero(), anchor_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_a = Eigen::Vector3d::UnitX(), axis_b = Eigen::Vector3d::UnitX();

  // What it gave body a in the last substep, world axes; b got the opposite. The next substep starts from it.
  struct Impulse {
    Eigen::Vector3d point_n_s = Eigen::Vector3d::Zero();
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();  // N m s, across the hinge's axis
  };
  Impulse push, relax;
  Eigen::Vector3d load_n_s = Eigen::Vector3d::Zero();  // until the relax pass
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();   // on a, over the last substep

  int row_count() const { return hinge ? 5 : 3; }
  Eigen::Vector3d world_anchor_a() const { return a->world_from_body * anchor_a_m; }
  Eigen::Vector3d world_anchor_b() const {
    return b ? Eigen::Vector3d(b->world_from_body * anchor_b_m) : anchor_b_m;
  }
  Eigen::Vector3d world_axis_a() const { return a->world_from_body.orientation * axis_a; }
  Eigen::Vector3d world_axis_b() const {
    return b ? Eigen::Vector3d(b->world_from_body.orientation * axis_b) : axis_b;
  }
};

// Bodies that hang together by joints, and their joints. They belong to one island, sleep and wake together,
// and one thread at a time works on them.
class JointGroup {
 public:
  explicit JointGroup(std::vector<RigidJoint> joints);  // not empty

  const std::vector<RigidJoint>& joints() const { return joints_; }
  const std::vector<RigidBody*>& bodies() const { return bodies_; }  // ascending body_id, without the world

  bool asleep() const;
  void wake_together();  // if some are awake, all are
  bool share_joint(const RigidBody& a, const RigidBody& b) const;

  // The parts of one substep, in the order of use: begin before contacts act, prepare and solve (some
  // sweeps), move, prepare and solve again as the relax pass, end.
  void begin();
  void prepare(ContactPhase phase);  // at the present poses; starts with the impulses of the substep before
  void solve(ContactPhase phase, double substep_s);
  void move(double substep_s);  // of its bodies
  void end(double substep_s);   // when contacts are done too: sees to it that joints did no work
  void reset_impulses();        // what it starts the next substep from

 private:
  // How ways of the joint's points and axes bend: by how much mean velocities of a substep differ from the
  // present ones, for each second of it.
  struct CurvatureCorrection {
    Eigen::Vector3d gap_m_s2 = Eigen::Vector3d::Zero();
    Eigen::Vector2d tilt_rad_s2 = Eigen::Vector2d::Zero();  // across the axis
  };
  struct Rows {
    size_t a = 0, b = 0;  // indices into bodies_; b: kWorld
    int first = 0;        // of its rows in the system
    Eigen::Vector3d arm_a_m = Eigen::Vector3d::Zero(), arm_b_m = Eigen::Vector3d::Zero();
    // How the rows see angular velocities.
    Eigen::Matrix<double, 5, 3> turn_a = Eigen::Matrix<double, 5, 3>::Zero(), turn_b = turn_a;
    // World: the two directions across a hinge's axis.
    Eigen::Matrix<double, 3, 2> across = Eigen::Matrix<double, 3, 2>::Zero();
    Eigen::Vector3d start_gap_m = Eigen::Vector3d::Zero();
    double correction_m_s = 0.0;                    // how fast the push takes the gap back
    CurvatureCorrection curvature, next_curvature;  // what this substep reckons with; the last measure
    Eigen::Vector2d start_tilt = Eigen::Vector2d::Zero();
  };
  static constexpr size_t kWorld = ~size_t{0};

  void order_joints();
  void note_nodes();
  void factorise();
  void substitute(Eigen::VectorXd& rows) const;
  void apply(const RigidJoint& joint, const Rows& rows, const RigidJoint::Impulse& impulse);
  void warm_start(ContactPhase phase);
  bool measure_curvature(double substep_s);  // whether another sweep is worth it
  void solve_residual(ContactPhase phase);
  void push_residual(double substep_s);
  void relax_residual();

  int small_steps(double substep_s);
  static void scale_mass(RigidBody& body, double factor);

  struct Motion {
    Eigen::Vector3d velocity_m_s, angular_momentum, spin_rad_s, position_m;
  };
  struct Impulses {
    Eigen::Vector3d push_n_s = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();  // N s, N m s
  };
  static Motion motion_of(const RigidBody& body);
  static double kinetic_j(const Motion& motion, const RigidBody& body);
  void note_others();
  double limit_kinetic_energy(const std::vector<Motion>& starts, const std::vector<Impulses>& others,
                              double allowance_j);
  void limit_push();
  void move_in_small_steps(double substep_s, int steps);

  std::vector<double> mass_factors_;  // of bodies_: by how much each is heavier during small steps
  static constexpr double kNotMeasured = -1.0;

  std::vector<RigidJoint> joints_;
  std::vector<RigidBody*> bodies_;
  std::vector<std::pair<const RigidBody*, const RigidBody*>>
      joined_pairs_;        // in a joint or a node of joints, ascending
  std::vector<Rows> rows_;  // one a joint
  // Lower triangle row by row from the first entry that is not zero: L of L D L^T, and 1 / D.
  std::vector<size_t> envelope_;  // where row r begins in factor_; one more than rows
  std::vector<int> begin_;        // first column of row r
  std::vector<double> factor_;
  std::vector<double> inverse_pivot_;
  double softness_ = 0.0;                  // what a row gives of its own response
  Eigen::VectorXd residual_, compliance_;  // compliance_: speed that a row gives way by for an impulse
  bool in_small_steps_ = false;
  bool curvature_converges_ = true;
  std::array<double, 2> curvature_change_{kNotMeasured,
                                          kNotMeasured};  // of gaps and tilts, between the last two measures
  std::vector<Eigen::Quaterniond> ends_;  // of bodies_: at the end of the substep, as they turn now
  // Of bodies_: at the start of the substep and since what other than joints is noted; what its joints gave
  // since then; what all else gave in the substep.
  std::vector<Motion> starts_, before_;
  std::vector<Impulses> given_, others_;
  // What its joints seem to have done and the group still has; its kinetic energy, forgotten slowly.
  double work_j_ = 0.0, peak_kinetic_j_ = 0.0;
};

// The groups of which the first body is among `bodies`.
std::vector<JointGroup*> joint_groups(std::span<RigidBody* const> bodies);

// No contact is looked for between bodies that a joint connects, or that meet in a node of joints.
bool joined(const RigidBody& a, const RigidBody& b);

}  // namespace livegs
