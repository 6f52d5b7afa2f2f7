// SPDX-License-Identifier: GPL-3.0-or-later
// Cheaper states: a body in flight without visible deformation moves as a rigid body, and a still body
// sleeps.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/revision.h"
#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/rigid_proxy.h"
#include "physics/motion/free_rotation.h"
#include "physics/motion/motion_validity.h"

namespace livegs::cells {
namespace {

// A free body with a smaller strain in its worst cell for half of kLastingTime_s is frozen into its shape.
constexpr double kVisibleStrain = 1e-3;
// Distance from its place within which every visible point of a sleeping body stayed for kLastingTime_s; the
// second relative to the longest side, for small bodies. It bounds the speed of
// what stops: 4 mm/s in the mean. Smaller: bodies whose points flutter in contact stay awake. Larger: slow
// motion stops visibly.
constexpr double kStillDistance_m = 2e-3, kStillShare = 0.02;
constexpr double kStationaryFactor = 100.0;  // divides this distance for held and loaded bodies
// Maximum drift of the centre of mass, as a fraction of the body's length, in half a period of its slowest
// vibration. The deflection is then within 1 % of equilibrium for a bending of a thousandth of the length.
constexpr double kMaxStationaryDrift = 3e-6;

}  // namespace

void CellsBody::end_frame(double frame_s) {
  if (asleep()) return;
  if (rest_.rigid) {
    place_rigid();
    whole_ = {centre_m(), orientation_};
    return;
  }
  if (!has_finite_motion() || !limit_energy()) restore_last_valid_state();
  // The origin of a held body stays, so that rounding does not move held nodes.
  Vector3d shift = Vector3d::Zero();
  if (!holding_.held || ledger_.motion.centre_m.norm() > 4.0 * reach_m_)
    shift = ledger_.motion.centre_m.cast<float>().cast<double>();
  origin_m_ += shift;
  ledger_.motion.centre_m -= shift;
  reach_m_ = nodes_.move_all(-shift, ledger_.motion.centre_m);
  orientation_ =
      (rotation_exp(frame_s * ledger_.motion.angular_velocity_rad_s()) * orientation_).normalized();
  ledger_.step_orientation = orientation_;
  whole_ = {centre_m(), orientation_};
  colliders_.margin_m -= 1e-6 * reach_m_;  // rounding of the shift
  bodies_.rigid_margin_m -= 1e-6 * reach_m_;

  update_stuck_contacts(frame_s);
  flow();
  recover_shape(frame_s);
  rest(frame_s);
}

void CellsBody::rest(double frame_s) {
  const bool unstrained = free() && rest_.may_rest && !step_.touching && !rest_.forced && !is_separating() &&
                          loads_.regions.empty() && step_.strain_squared < kVisibleStrain * kVisibleStrain;
  rest_.unstrained_s = unstrained ? rest_.unstrained_s + frame_s : 0.0;
  if (rest_.unstrained_s >= 0.5 * kLastingTime_s && !without(Mechanism::RigidWhenUnstrained)) {
    become_rigid();
    return;
  }
  // Held and loaded bodies are tested by drift as well: they sleep in equilibrium, not while they creep.
  // Bodies resting on others jitter too much for that test.
  const bool measured = holding_.held || !loads_.regions.empty();
  const bool moves = rest_.forced || rest_.driven || is_separating() ||
                     (measured && !without(Mechanism::DriftTest) && !is_stationary(frame_s));
  const double still_m = std::min(kStillDistance_m, kStillShare * size_m().maxCoeff());
  const bool moved = moves || !rest_.supported || has_moved(measured ? still_m / kStationaryFactor : still_m);
  if (rest_.sleep_timer.tick(frame_s, !moved)) sleep();
}

// Whether a visible surface point has left its place by more than `distance_m` since the last time that this
// was so. Motion that comes and goes is not seen, such as that of an edge that opens and closes its contact,
// nor that of nodes of nearly empty cells.
bool CellsBody::has_moved(double distance_m) {
  bool moved = rest_.points_m.size() != surface_.points.size();
  for (size_t i = 0; i < surface_.points.size() && !moved; ++i) {
    const Vector3d point = origin_m_ + nodes_.position_m(surface_.points[i]);
    moved = (point - rest_.points_m[i]).squaredNorm() > distance_m * distance_m;
  }
  if (!moved) return false;
  rest_.points_m.clear();
  for (const NodeSample& sample : surface_.points)
    rest_.points_m.push_back(origin_m_ + nodes_.position_m(sample));
  return true;
}

// Drift test. A slow vibration has zero speed twice per period, for longer than any timer, so the motion
// during half a period decides. The centre of mass is insensitive to rounding.
bool CellsBody::is_stationary(double frame_s) {
  const Vector3d centre = centre_m();
  rest_.stationary_s += frame_s;
  if ((centre - rest_.stationary_at_m).norm() > kMaxStationaryDrift * size_m().maxCoeff()) {
    rest_.stationary_at_m = centre;
    rest_.stationary_s = 0.0;
  }
  return rest_.stationary_s >= M_PI / lowest_rate_rad_s();
}

// Uses the sums of the last step over all nodes: one non-finite node makes them non-finite.
bool CellsBody::has_finite_motion() const {
  return is_valid_position(centre_m()) && std::isfinite(reach_m_) && std::isfinite(step_.kinetic_j) &&
         step_.kinetic_j < 0.5 * mass_kg_ * kMaxValidSpeed_m_s * kMaxValidSpeed_m_s &&
         ledger_.motion.momentum.allFinite() && ledger_.motion.angular_momentum.allFinite();
}

// Resets the body to its rest shape, at rest, at the pose of the last valid frame; a held body at its held
// pose.
void CellsBody::restore_last_valid_state() {
  ++recovery_count_;
  const Vector3d still = Vector3d::Zero();
  const Pose last{whole_.position_m - whole_.orientation * rest_centre_m(), whole_.orientation};
  set_rest_shape(holding_.held ? holding_.world_from_object : last, still, still);
}

bool CellsBody::place(const Pose& world_from_object, const Vector3d& velocity_m_s,
                      const Vector3d& angular_velocity_rad_s) {
  wake();
  if (holding_.held) holding_.world_from_object = world_from_object;
  set_rest_shape(world_from_object, velocity_m_s, angular_velocity_rad_s);
  whole_ = {origin_m_, orientation_};
  return true;
}

Vector3d CellsBody::rest_centre_m() const {
  Vector3d centre = Vector3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i)
    centre += masses_kg_[i] / mass_kg_ * lattice_.node_position_m(i);
  return centre;
}

void CellsBody::set_rest_shape(const Pose& world_from_object, const Vector3d& velocity_m_s,
                               const Vector3d& angular_velocity_rad_s) {
  const Vector3d rest_centre = rest_centre_m();
  orientation_ = world_from_object.orientation;
  origin_m_ = world_from_object * rest_centre;
  for (size_t i = 0; i < nodes_.count(); ++i) {
    const Vector3d arm = orientation_ * (lattice_.node_position_m(i) - rest_centre);
    nodes_.set_motion(i, arm, velocity_m_s + angular_velocity_rad_s.cross(arm));
  }
  if (!plastic_.parts.empty()) discard_plastic_flow();
  batches_.set_rotations(orientation_ * extent_.object_from_lattice);
  ledger_.step_orientation = orientation_;
  step_.strained = recovery_.degenerate = recovery_.recovering = false;  // before the inertia is measured
  restart_motion();
  loads_.pressed_n = loads_.carried_n = step_.strain_squared = step_.bent_squared = step_.deviation_m_s =
      step_.spin_rad_s = recovery_.degenerate_s = 0.0;
  limiter_.limit_j.reset();
  loads_.contact_total = {};
  bodies_.stuck.clear();
  surface_.boxes_known = false;
}

void CellsBody::sleep() {
  rest_.sleep_timer.sleep();
  rest_.points_m.clear();
  nodes_.stop();
  ledger_.motion.momentum.setZero();
  ledger_.motion.angular_momentum.setZero();
  ledger_.restart();
  step_.deviation_m_s = 0.0;
  step_.first = true;
}

void CellsBody::become_rigid() {
  RigidMotion rigid;
  rigid.world_from_body.position_m = origin_m_ + ledger_.motion.centre_m;
  for (size_t i = 0; i < nodes_.count(); ++i) {
    rigid.shape_m.push_back((nodes_.position_m(i) - ledger_.motion.centre_m).cast<float>());
  }
  // A single line of particles has no inertia about itself and stays elastic.
  if (!(ledger_.motion.inertia.determinant() > 0.0)) return;
  rigid.axes = principal_axes(ledger_.motion.inertia);
  rigid.inverse_inertia = ledger_.motion.inertia.inverse();
  rest_.rigid = std::move(rigid);
}

// One world substep as a rigid body. False if something is near; the body is then elastic again.
bool CellsBody::rigid_substep(const SubstepContext& context) {
  const double h = context.duration_s;
  const Vector3d velocity = ledger_.motion.velocity_m_s();
  const Vector3d centre = rest_.rigid->world_from_body.position_m;
  // Becomes elastic one frame before a contact is possible.
  const double reach = reach_m_ + extent_.box_edge_m + 2.0 / accuracy_.rate_hz * velocity.norm();
  bool near = !context.forces.empty() || !context.others.empty();
  for (const Collider& collider : context.colliders) near = near || reaches(collider, centre, reach);
  for (const RigidProxy* body : context.bodies) {
    const double distance = body->shape->sample(body->start.inverse() * centre).distance_m;
    near = near || distance < reach + 2.0 / accuracy_.rate_hz * body->fastest_m_s();
  }
  if (near) {
    become_elastic();
    return false;
  }
  rest_.rigid->world_from_body.position_m += h * velocity + 0.5 * h * h * context.gravity_m_s2;
  rest_.rigid->world_from_body.orientation = rotate_freely(
      rest_.rigid->world_from_body.orientation, rest_.rigid->axes, ledger_.motion.angular_momentum, h);
  ledger_.motion.momentum += h * mass_kg_ * context.gravity_m_s2;
  ledger_.motion.inertia =
      rotated_tensor(rest_.rigid->world_from_body.orientation, rest_.rigid->inverse_inertia).inverse();
  rest_.supported = context.gravity_m_s2.squaredNorm() == 0.0;
  return true;
}

// Sets the nodes from the rigid motion.
void CellsBody::place_rigid() {
  origin_m_ = rest_.rigid->world_from_body.position_m;
  ledger_.motion.centre_m.setZero();
  const Matrix3d turn = rest_.rigid->world_from_body.orientation.toRotationMatrix();
  const Vector3d velocity = ledger_.motion.velocity_m_s(), spin = ledger_.motion.angular_velocity_rad_s();
  for (size_t i = 0; i < nodes_.count(); ++i) {
    const Vector3d r = turn * rest_.rigid->shape_m[i].cast<double>();
    nodes_.set_motion(i, r, velocity + spin.cross(r));
  }
  orientation_ = centre_pose().orientation;
  ledger_.step_orientation = orientation_;
}

void CellsBody::become_elastic() {
  if (!rest_.rigid) return;
  place_rigid();
  ledger_.node_inertia = node_motion().inertia;
  rest_.rigid.reset();
  // The rotations of the sweep are out of date. The strain is negligible, so all are set to the body's
  // rotation.
  batches_.set_rotations(orientation_ * extent_.object_from_lattice);
  ledger_.restart();
  rest_.unstrained_s = 0.0;
  colliders_.margin_m = 0.0;
  bodies_.revision = new_revision();
  step_.first = true;
}

}  // namespace livegs::cells
