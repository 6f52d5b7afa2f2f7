// SPDX-License-Identifier: GPL-3.0-or-later
// Cheaper states: a body in flight without visible deformation moves as a rigid body, and a still body
// sleeps.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/rigid_proxy.h"
#include "physics/motion/free_rotation.h"
#include "physics/motion/motion_validity.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A free body with a smaller strain in its worst cell for kUnstrainedTime_s is frozen into its shape.
constexpr double kVisibleStrain = 1e-3;
constexpr double kUnstrainedTime_s = 0.25;
constexpr double kStationarySpeedFactor = 100.0;  // divides the sleep speed of held and loaded bodies
// Maximum drift of the centre of mass, as a fraction of the body's length, in half a period of its slowest
// vibration. The deflection is then within 1 % of equilibrium for a bending of a thousandth of the length.
constexpr double kMaxStationaryDrift = 3e-6;
// A jittering body counts as still if its points stay within this fraction of its smallest side for
// kJitterTime_s.
constexpr double kMaxJitter = 0.01, kJitterTime_s = 2.0;

}  // namespace

void CellsBody::end_frame(double frame_s) {
  if (asleep()) return;
  if (rigid_) {
    place_rigid();
    whole_ = {centre_m(), orientation_};
    return;
  }
  if (!has_finite_motion() || !limit_energy()) restore_last_valid_state();
  // The origin of a held body stays, so that rounding does not move held nodes.
  Vector3d shift = Vector3d::Zero();
  if (!held_ || motion_.centre_m.norm() > 4.0 * reach_m_)
    shift = motion_.centre_m.cast<float>().cast<double>();
  origin_m_ += shift;
  motion_.centre_m -= shift;
  reach_m_ = nodes_.move_all(-shift, motion_.centre_m);
  orientation_ = (rotation_exp(frame_s * motion_.angular_velocity_rad_s()) * orientation_).normalized();
  step_orientation_ = orientation_;
  whole_ = {centre_m(), orientation_};
  candidate_margin_m_ -= 1e-6 * reach_m_;  // rounding of the shift
  rigid_candidate_margin_m_ -= 1e-6 * reach_m_;

  update_stuck_contacts(frame_s);
  flow();
  recover_shape(frame_s);
  rest(frame_s);
}

void CellsBody::rest(double frame_s) {
  const bool unstrained = free() && may_rest_ && !touching_ && !forced_ && !is_separating() &&
                          region_loads_.empty() && strain_squared_ < kVisibleStrain * kVisibleStrain;
  unstrained_time_s_ = unstrained ? unstrained_time_s_ + frame_s : 0.0;
  if (unstrained_time_s_ >= kUnstrainedTime_s) {
    become_rigid();
    return;
  }
  // Held and loaded bodies are tested by drift as well: they sleep in equilibrium, not while they creep.
  // Bodies resting on others jitter too much for that test.
  const bool measured = held_ || !region_loads_.empty();
  const bool moves = forced_ || driven_ || is_separating() || (measured && !is_stationary(frame_s));
  const double calm = measured ? kStationarySpeedFactor : 1.0;
  double seen_m_s = moves || !supported_ ? 0.0 : fastest_m_s(SleepTimer::kStillSpeed_m_s / calm);
  if (!measured && !moves && supported_ && is_jittering(seen_m_s, frame_s)) seen_m_s = 0.0;
  if (sleep_timer_.tick(frame_s, calm * seen_m_s, supported_, moves)) sleep();
}

// Drift test. A slow vibration has zero speed twice per period, for longer than any timer, so the motion
// during half a period decides. The centre of mass is insensitive to rounding.
bool CellsBody::is_stationary(double frame_s) {
  const Vector3d centre = centre_m();
  stationary_s_ += frame_s;
  if ((centre - stationary_at_m_).norm() > kMaxStationaryDrift * (extent_.max_m - extent_.min_m).maxCoeff()) {
    stationary_at_m_ = centre;
    stationary_s_ = 0.0;
  }
  return stationary_s_ >= M_PI / lowest_rate_rad_s();
}

// Whether only jitter remains. A corner folded under the body can snap back and forth indefinitely while the
// rest is still.
bool CellsBody::is_jittering(double seen_m_s, double frame_s) {
  const bool still = std::max(motion_.velocity_m_s().norm(), deviation_m_s_) < SleepTimer::kStillSpeed_m_s;
  if (!still || (seen_m_s < SleepTimer::kStillSpeed_m_s && jitter_origin_m_.empty())) {
    jitter_origin_m_.clear();
    return false;
  }
  const double most_m = kMaxJitter * (extent_.max_m - extent_.min_m).minCoeff();
  bool near = jitter_origin_m_.size() == surface_.size();
  for (size_t i = 0; near && i < surface_.size(); ++i) {
    near = (origin_m_ + nodes_.position_m(surface_[i]) - jitter_origin_m_[i]).squaredNorm() < most_m * most_m;
  }
  if (near) {
    jitter_time_s_ += frame_s;
  } else {
    jitter_origin_m_.clear();
    for (const NodeSample& sample : surface_)
      jitter_origin_m_.push_back(origin_m_ + nodes_.position_m(sample));
    jitter_time_s_ = 0.0;
  }
  return jitter_time_s_ >= kJitterTime_s;
}

// Uses the sums of the last step over all nodes: one non-finite node makes them non-finite.
bool CellsBody::has_finite_motion() const {
  return is_valid_position(centre_m()) && std::isfinite(reach_m_) && std::isfinite(kinetic_j_) &&
         kinetic_j_ < 0.5 * mass_kg_ * kMaxValidSpeed_m_s * kMaxValidSpeed_m_s &&
         motion_.momentum.allFinite() && motion_.angular_momentum.allFinite();
}

// Resets the body to its rest shape, at rest, at the pose of the last valid frame; a held body at its held
// pose.
void CellsBody::restore_last_valid_state() {
  ++recovery_count_;
  Vector3d rest_centre = Vector3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i)
    rest_centre += masses_kg_[i] / mass_kg_ * lattice_.node_position_m(i);
  orientation_ = held_ ? world_from_object_.orientation : whole_.orientation;
  origin_m_ = held_ ? world_from_object_ * rest_centre : whole_.position_m;
  const Vector3d still = Vector3d::Zero();
  for (size_t i = 0; i < nodes_.count(); ++i) {
    nodes_.set_motion(i, orientation_ * (lattice_.node_position_m(i) - rest_centre), still);
  }
  for (LightNode& light_node : light_nodes_) light_node.parent_m_s = still;
  if (!plastic_parts_.empty()) discard_plastic_flow();
  batches_.set_rotations(orientation_ * extent_.object_from_lattice);
  step_orientation_ = orientation_;
  restart_motion();
  pressed_n_ = carried_n_ = strain_squared_ = bent_squared_ = deviation_m_s_ = spin_rad_s_ = degenerate_s_ =
      0.0;
  strained_ = degenerate_ = recovering_ = false;
  energy_limit_j_.reset();
  contact_total_ = {};
  stuck_contacts_.clear();
  sides_.clear();
  boxes_known_ = false;
}

void CellsBody::sleep() {
  sleep_timer_.sleep();
  jitter_origin_m_.clear();
  elastic_contacts_.clear();  // the motion of others is not counted during sleep
  nodes_.stop();
  motion_.momentum.setZero();
  motion_.angular_momentum.setZero();
  momentum_before_.setZero();
  angular_before_.setZero();
  velocity_correction_.setZero();
  spin_correction_.setZero();
  contact_lag_m_.setZero();
  between_steps_impulse_.setZero();
  deviation_m_s_ = 0.0;
  first_step_ = true;
}

// Fastest visible surface point. Nearly empty cells can have jittering nodes that are not visible. If the
// whole body moves or deforms faster than `still_m_s`, that speed is returned, which is cheap. If all nodes
// are still, so are the points, which are means of nodes.
double CellsBody::fastest_m_s(double still_m_s) const {
  const double mean = std::max(motion_.velocity_m_s().norm(), deviation_m_s_);
  if (mean >= still_m_s) return mean;
  double squared = 0.0;
  for (size_t i = 0; i < nodes_.count(); ++i) squared = std::max(squared, node_velocity(i).squaredNorm());
  if (surface_.empty() || squared < still_m_s * still_m_s) return std::sqrt(squared);
  squared = 0.0;
  for (const NodeSample& sample : surface_) {
    squared = std::max(squared, velocity_of(sample).squaredNorm());
    if (squared >= still_m_s * still_m_s) break;
  }
  return std::sqrt(squared);
}

void CellsBody::become_rigid() {
  RigidMotion rigid;
  rigid.world_from_body.position_m = origin_m_ + motion_.centre_m;
  for (size_t i = 0; i < nodes_.count(); ++i) {
    rigid.shape_m.push_back((nodes_.position_m(i) - motion_.centre_m).cast<float>());
  }
  // A single line of particles has no inertia about itself and stays elastic.
  if (!(motion_.inertia.determinant() > 0.0)) return;
  rigid.axes = principal_axes(motion_.inertia);
  rigid.inverse_inertia = motion_.inertia.inverse();
  rigid_ = std::move(rigid);
}

// One world substep as a rigid body. False if something is near; the body is then elastic again.
bool CellsBody::rigid_substep(const SubstepContext& context) {
  const double h = context.duration_s;
  const Vector3d velocity = motion_.velocity_m_s();
  const Vector3d centre = rigid_->world_from_body.position_m;
  // Becomes elastic one frame before a contact is possible.
  const double reach = reach_m_ + extent_.box_edge_m + 2.0 / rate_hz_ * velocity.norm();
  bool near = !context.forces.empty() || !context.others.empty();
  for (const Collider& collider : context.colliders) near = near || reaches(collider, centre, reach);
  for (const RigidProxy* body : context.bodies) {
    const double distance = body->shape->sample(body->start.inverse() * centre).distance_m;
    near = near || distance < reach + 2.0 / rate_hz_ * body->fastest_m_s();
  }
  if (near) {
    become_elastic();
    return false;
  }
  rigid_->world_from_body.position_m += h * velocity + 0.5 * h * h * context.gravity_m_s2;
  rigid_->world_from_body.orientation =
      rotate_freely(rigid_->world_from_body.orientation, rigid_->axes, motion_.angular_momentum, h);
  motion_.momentum += h * mass_kg_ * context.gravity_m_s2;
  motion_.inertia = rotated_tensor(rigid_->world_from_body.orientation, rigid_->inverse_inertia).inverse();
  supported_ = context.gravity_m_s2.squaredNorm() == 0.0;
  return true;
}

// Sets the nodes from the rigid motion.
void CellsBody::place_rigid() {
  origin_m_ = rigid_->world_from_body.position_m;
  motion_.centre_m.setZero();
  const Matrix3d turn = rigid_->world_from_body.orientation.toRotationMatrix();
  const Vector3d velocity = motion_.velocity_m_s(), spin = motion_.angular_velocity_rad_s();
  for (size_t i = 0; i < nodes_.count(); ++i) {
    const Vector3d r = turn * rigid_->shape_m[i].cast<double>();
    nodes_.set_motion(i, r, velocity + spin.cross(r));
  }
  orientation_ = centre_pose().orientation;
  step_orientation_ = orientation_;
}

void CellsBody::become_elastic() {
  if (!rigid_) return;
  place_rigid();
  std::vector<Vector3d> positions(nodes_.count());
  const std::vector<Vector3d> still(positions.size(), Vector3d::Zero());
  for (size_t i = 0; i < positions.size(); ++i) positions[i] = nodes_.position_m(i);
  node_inertia_ = body_momentum(positions, still, masses_kg_).inertia;
  rigid_.reset();
  // The rotations of the sweep are out of date. The strain is negligible, so all are set to the body's
  // rotation.
  batches_.set_rotations(orientation_ * extent_.object_from_lattice);
  momentum_before_ = motion_.momentum;
  angular_before_ = motion_.angular_momentum;
  velocity_correction_.setZero();
  spin_correction_.setZero();
  contact_lag_m_.setZero();
  between_steps_impulse_.setZero();
  unstrained_time_s_ = 0.0;
  candidate_margin_m_ = rigid_candidate_margin_m_ = 0.0;
  ++restarts_;
  first_step_ = true;
}

}  // namespace livegs
