// SPDX-License-Identifier: GPL-3.0-or-later
// The substep of the `cells` solver.
//
// BDF2 with position corrections d: h_e = 2h/3,
//   v^ = (4 v - v_)/3 + h_e a,   y = x + (x - x_)/3 + h_e v^,   x' = y + d,   v' = v^ + d/h_e.
//
// Momentum ledger: momentum and angular momentum of the whole body are integrated separately, from impulses
// and in double precision: P' = P + h F + sum of contact impulses. Momentum exchange with other bodies is
// therefore exact within a substep, and spin does not leak into elastic modes. The difference to the momentum
// of the nodes is added to the nodes at the next prediction.
//
// Contact impulses on nodes are excluded from the difference v - v_. Otherwise BDF2 would continue them by
// thirds, to one and a half times the impulse.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "physics/elastic/cells/cells_body.h"
#include "physics/motion/free_rotation.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Beyond this strain a body takes first-order steps, which dissipate energy; BDF2 would amplify the motion.
constexpr double kFirstOrderStrainSquared = 0.25;  // |S - I|²
constexpr double kFirstOrderVolumeRatio = 0.2;     // det F
// Time in which the inertia of the material returns after such a strain. Shorter: a limp body that is
// strained again and again gains energy from the changes.
constexpr double kMomentMapReturn_s = 0.5;
// A body in contact also takes first-order steps while its shape changes slowly: RMS speed below this
// fraction of sqrt(g L), with L the smallest side (the speed after a fall of L/200). Pointwise contact causes
// noise, which BDF2 damps too little.
constexpr double kMaxSlowSpeedRatio = 0.1;
// A body loaded by more than this multiple of its weight does not alternate the direction of its sweep. The
// difference between the two directions grows with the load and would excite a vibration under heavy loads.
constexpr double kMaxAlternatingLoad = 4.0;

// Grip strength fades from full at the first cell stretch to zero at the second.
constexpr double kGripFadeStart = 2.0, kGripFadeEnd = 4.0;

// Impact speed that triggers impact steps, relative to the wave speed. Larger values let landing bodies gain
// energy.
constexpr double kImpactSpeedRatio = 0.03;
constexpr double kImpactFrames = 2.0;

// Time constant of the carried load; spans several bounces.
constexpr double kCarriedLoadTime_s = 0.25;

// Fraction per step of a light node's motion relative to its parent that is removed.
constexpr double kLightNodeDamping = 0.25;

// Maximum length of a world substep, in scene substeps; about 1 s at 90 Hz and 64 substeps.
constexpr double kMaxSceneSubsteps = 6000.0;

NodeLanes lanes_of(const Vector3d& v) {
  return NodeLanes{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), 0.0f};
}

Vector3d vector_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

}  // namespace

int CellsBody::begin_substep(const SubstepContext& context) {
  boxes_known_ = false;
  forced_ = false;
  driven_ = driven(context.start_s, context.start_s + context.duration_s);
  for (const PointForce& force : context.forces)
    forced_ = forced_ || force.spring || force.force_n.squaredNorm() > 0.0;
  if (asleep()) {
    const bool touched = forced_ || driven_ || may_touch_awake(context);
    if (!touched) return 0;
    wake();
  }
  if (rigid_ && rigid_substep(context)) return 0;
  // A substep longer than the scene's is split, never stretched, because the stiffness was chosen for the
  // scene's.
  const double longer = std::ceil(context.duration_s * rate_hz_ * scene_substeps_ - 1e-6);
  gather_point_loads(context);
  const int steps =
      resolution_.substeps / scene_substeps_ * static_cast<int>(std::clamp(longer, 1.0, kMaxSceneSubsteps));
  return in_impact(context) ? steps * resolution_.impact_substeps : steps;
}

// Impact detection. The body's own steps are too long for a shock: with one sweep each, the cells in front of
// it invert and gain energy. An impact is a fast deformation in contact, or a fast approach. Impact steps
// last kImpactFrames, by which time most of the shock is vibration. They are not used for bodies in a hand,
// or next to other elastic bodies: all of these would take the same steps, and they yield anyway.
bool CellsBody::in_impact(const SubstepContext& context) {
  if (!context.others.empty() || forced_) return false;
  const bool comes = !touching_ && !(candidates_.empty() && rigid_candidates_.empty());
  const double speed_m_s = touching_ ? deviation_m_s_
                           : comes   ? motion_.velocity_m_s().norm() + deviation_m_s_
                                     : 0.0;
  if (speed_m_s > kImpactSpeedRatio * resolution_.wave_speed_m_s(rate_hz_))
    impact_until_s_ = context.start_s + kImpactFrames / rate_hz_;
  return context.start_s < impact_until_s_;
}

void CellsBody::end_substep(const SubstepContext& context) {
  gravity_ = context.gravity_m_s2;
  gravity_m_s2_ = gravity_.norm();
  supported_ = touching_ || held_ || context.gravity_m_s2.squaredNorm() == 0.0;
}

// Collects the point forces of the scene and the tractions of regions.
void CellsBody::gather_point_loads(const SubstepContext& context) {
  point_loads_ = region_loads_;
  for (const PointForce& force : context.forces) {
    point_loads_.push_back({sample_at(lattice_.embed(force.point_m)), force.force_n, force.spring});
  }
}

// Implicit springs. The spring force at the end of a step depends on the force itself through the mobility w
// of its point. The update is therefore scaled by 1 / (1 + w h (k h + c)). This is stable for any stiffness,
// and at rest the force is stiffness times stretch.
void CellsBody::solve_springs(const SubstepPart& part) {
  const double h = part.duration_s;
  for (Load& load : point_loads_) {
    if (!load.spring) continue;
    PointSpring& spring = *load.spring;
    if (!spring.force_n.allFinite()) spring.force_n.setZero();  // non-finite after a reset of the body
    const double w = mobility(load.sample), k = spring.stiffness_n_m;
    // Limits the damping to the value that the point's mass can bear without jitter.
    const double c = w > 0.0 ? std::min(spring.damping_n_s_m, 1.0 / (w * h)) : spring.damping_n_s_m;
    const Vector3d slower = spring.target_velocity_m_s - velocity_of(load.sample);
    const Vector3d stretch = spring.target_m + part.began_s * spring.target_velocity_m_s - origin_m_ -
                             nodes_.position_m(load.sample);
    spring.force_n +=
        (k * (stretch + h * slower) + c * slower - spring.force_n) / (1.0 + w * h * (k * h + c));
    const double size = spring.force_n.norm(), most_n = spring.max_force_n * grip_factor(load.sample);
    if (size > most_n) spring.force_n *= most_n / size;
    load.force_n = spring.force_n;
  }
}

// Grip strength, by the largest stretch of the cell that a hand holds. Unlimited pulling would stretch thin
// parts without bound and add large amounts of energy.
double CellsBody::grip_factor(const NodeSample& sample) const {
  Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
  for (int c = 0; c < 8; ++c) {
    const Vector3d sign(c & 1 ? 1.0 : -1.0, c & 2 ? 1.0 : -1.0, c & 4 ? 1.0 : -1.0);
    f += nodes_.position_m(sample.nodes[c]) * sign.transpose();
  }
  f *= 0.25 / lattice_.cell_width_m;
  const double squared =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(f.transpose() * f, Eigen::EigenvaluesOnly)
          .eigenvalues()[2];
  return std::clamp((kGripFadeEnd - std::sqrt(squared)) / (kGripFadeEnd - kGripFadeStart), 0.0, 1.0);
}

void CellsBody::begin_step(const SubstepPart& part, const SubstepContext& context) {
  const double h = part.duration_s, time_s = context.start_s + part.began_s + h;
  // Neighbours can impose another step length. The previous step is then not a valid basis for BDF2.
  const bool even = std::abs(h - last_step_s_) <= 1e-9 * h;
  last_step_s_ = h;
  const double smallest_m = (extent_.max_m - extent_.min_m).minCoeff();
  is_slow_ =
      touching_ && deviation_m_s_ < kMaxSlowSpeedRatio * std::sqrt(context.gravity_m_s2.norm() * smallest_m);
  second_order_ = options_.second_order && even && !first_step_ && !strained_ && !is_slow_;
  // The result of a sweep from zero multipliers depends slightly on its order. A landing body alternates the
  // order, because a fixed one would cause a sideways drift. A slow body keeps one order in order to come to
  // rest, and so does a free one, because nearly empty cells would vibrate.
  const bool pressed = carried_n_ > kMaxAlternatingLoad * mass_kg_ * context.gravity_m_s2.norm();
  backward_ = touching_ && !is_slow_ && !pressed && !backward_;
  for (Load& load : point_loads_) load.from_m = nodes_.position_m(load.sample);
  solve_springs(part);
  predict(h, context);
  if (moved_) move_regions(time_s, h);

  GaussSeidelArrays sweep;
  sweep.predicted = nodes_.predicted();
  sweep.corrections = nodes_.corrections();
  sweep.full = batches_.full.data();
  sweep.cut = batches_.cut.data();
  sweep.thin = batches_.thin.data();
  sweep.plastic = plastic_.empty() ? nullptr : plastic_.data();
  sweep.thin_plastic = plastic_parts_.empty() ? nullptr : thin_plastic_.data();
  const GaussSeidelGains& gains = gains_of(h, second_order_);
  sweep.gains = gains.cut.data();
  sweep.thin_gains = gains.thin.data();
  sweep.full_gains = gains.full;
  sweep.inverse_four_widths = static_cast<float>(0.25 / lattice_.cell_width_m);
  sweep.backward = backward_;
  sweep.paired = batches_.paired;
  const GaussSeidelReport report = gauss_seidel_pass(sweep, batches_.colours);
  strain_squared_ = report.strain_squared;
  bent_squared_ = report.bent_squared;
  strained_ =
      report.strain_squared > kFirstOrderStrainSquared || report.volume_ratio < kFirstOrderVolumeRatio;
  degenerate_ = degenerate_ || strained_;
  moment_map_share_ = strained_ ? 0.0 : std::min(1.0, moment_map_share_ + h / kMomentMapReturn_s);

  if (held_) hold_particles(time_s);
  contact_impulse_.setZero();
  contact_moment_.setZero();
  collider_contacts_.clear();
  dynamic_contacts_.clear();
  touching_ = false;
  step_contact_n_s_ = 0.0;
  in_step_ = true;
  boxes_known_ = false;
}

void CellsBody::end_step(const SubstepPart& part, const SubstepContext& context) {
  resolve_colliders(step_of(part.duration_s), context);
  update_carried_load(part);
  advance(part.duration_s);
  for (const Load& load : point_loads_)
    work_j_ += load.force_n.dot(nodes_.position_m(load.sample) - load.from_m);
  damp_light_nodes(part.duration_s, context.gravity_m_s2);
  first_step_ = false;
  in_step_ = false;
  boxes_known_ = false;  // boxes are also queried between steps
}

// Estimates the load carried by the body, which lowers its vibration frequencies and increases their energy.
// The carried load is the part of the contact impulses that cancels, each pair counted once. Contact impulses
// on one side do not cancel: within Coulomb's cone, the sum of their magnitudes is at most sqrt(1 + mu²)
// times the magnitude of their sum. In a held body the sum passes to the held nodes, so it is carried as
// well.
void CellsBody::update_carried_load(const SubstepPart& part) {
  const double friction = material_.friction, sum = contact_impulse_.norm();
  const double through = step_contact_n_s_ / std::sqrt(1.0 + friction * friction) - sum;
  const double part_of_mean = part.duration_s / (part.duration_s + kCarriedLoadTime_s);
  const double carried_n_s = 0.5 * std::max(0.0, through) + (held_ ? sum : 0.0);
  pressed_n_ += part_of_mean * (step_contact_n_s_ / part.duration_s - pressed_n_);
  carried_n_ += part_of_mean * (carried_n_s / part.duration_s - carried_n_);
}

void CellsBody::predict(double h, const SubstepContext& context) {
  const double step_s = step_of(h);
  const double memory = second_order_ ? 1.0 / 3.0 : 0.0;
  Vector3d force = mass_kg_ * context.gravity_m_s2, torque = Vector3d::Zero();
  for (const Load& load : point_loads_) {
    force += load.force_n;
    torque += (nodes_.position_m(load.sample) - motion_.centre_m).cross(load.force_n);
  }

  // Damping acts on the deviation from rigid motion, not on forces (otherwise a load would appear lighter).
  // The rigid motion follows the ledger. A loss factor eta dissipates 2 pi eta of the energy per cycle, so
  // the rate is eta times that of the lowest mode. A load M lowers the frequency to sqrt(k / (m' + M)), and
  // only the part m' / (m' + M) of the energy is in the motion of the nodes, which the damping acts on. The
  // rate is therefore multiplied by sqrt(1 + M / m'). m' is pi²/144 of m between two contacts, and m/3 in a
  // held body (a rod held at its end). A step cannot remove more than the whole deviation.
  const double weight_n = mass_kg_ * context.gravity_m_s2.norm(), rate = damping_rate();
  const double moving_part = free() ? M_PI * M_PI / 144.0 : 1.0 / 3.0;
  const double loaded = weight_n > 0.0 ? std::sqrt(1.0 + carried_n_ / (moving_part * weight_n)) : 1.0;
  const double kept = std::max(0.0, 1.0 - step_s * (loaded - 1.0) * rate) / (1.0 + step_s * rate);
  Vector3d old_velocity = Vector3d::Zero(), old_spin = Vector3d::Zero();
  Vector3d new_velocity = Vector3d::Zero(), new_spin = Vector3d::Zero();
  if (free() || moved_) {
    old_velocity = (motion_.momentum + memory * (motion_.momentum - momentum_before_)) / mass_kg_;
    old_spin = solve_inertia(
        motion_.inertia, motion_.angular_momentum + memory * (motion_.angular_momentum - angular_before_));
    new_velocity = old_velocity;
    new_spin = old_spin;
  }
  if (free()) {
    ledger_momentum_ = motion_.momentum + h * force;
    ledger_angular_ = motion_.angular_momentum + h * torque;
    new_velocity = (ledger_momentum_ - step_s * force) / mass_kg_;
    // The nodes get the torque with their own inertia, below.
    new_spin =
        solve_inertia(motion_.inertia, ledger_angular_) - step_s * solve_inertia(node_inertia_, torque);
  }
  PredictStep predict;
  predict.memory = static_cast<float>(memory);
  predict.step_s = static_cast<float>(step_s);
  predict.kept = static_cast<float>(kept);
  predict.centre = lanes_of(motion_.centre_m);
  predict.correction = lanes_of(velocity_correction_);
  predict.correction_spin = lanes_of(spin_correction_);
  predict.bias = lanes_of(new_velocity - kept * old_velocity + step_s * context.gravity_m_s2);
  predict.spin = lanes_of(new_spin - kept * old_spin);
  const Matrix3d field = step_s * centrifugal_correction();
  for (int d = 0; d < 3; ++d) predict.field[d] = lanes_of(field.col(d));
  predict_nodes(nodes_.arrays(), predict);

  for (const Load& load : point_loads_) {
    for (int c = 0; c < 8; ++c) {
      const uint32_t node = load.sample.nodes[c];
      const Vector3d gained = step_s * load.sample.weights[c] * inverse_masses_[node] * load.force_n;
      nodes_.push(node, step_s * gained, gained);
    }
  }
}

void CellsBody::advance(double h) {
  NodeSums sums;
  advance_nodes(nodes_.arrays(), static_cast<float>(step_of(h)), sums);
  nodes_.swap();
  const Vector3d momentum_of_step = motion_.momentum;
  measure(sums, h);
  momentum_before_ = momentum_of_step;
  angular_before_ =
      material_angular(vector_of(sums.angular_before) - motion_.centre_m.cross(momentum_before_));
  for (const ColliderContact& touch : collider_contacts_) {
    const NodeSample& sample = touch.sample;
    nodes_.push_before(sample, touch.impulse_n_s);
    momentum_before_ += touch.impulse_n_s;
    angular_before_ += (nodes_.position_m(sample) - motion_.centre_m).cross(touch.impulse_n_s);
  }
  for (const DynamicContact& touch : dynamic_contacts_) {
    nodes_.push_before(touch.sample, touch.impulse_n_s);
    momentum_before_ += touch.impulse_n_s;
    angular_before_ += (nodes_.position_m(touch.sample) - motion_.centre_m).cross(touch.impulse_n_s);
  }
}

// Damps light nodes. Their added mass is not that of the material, and little stiffness holds them. Their
// motion relative to the parent node, without the rigid motion of the body, is damped. The added mass follows
// the parent: it gets the velocity change of the parent, without gravity, which the next step adds.
void CellsBody::damp_light_nodes(double step_s, const Vector3d& gravity_m_s2) {
  const Vector3d spin = motion_.angular_velocity_rad_s();
  Vector3d momentum = Vector3d::Zero(), angular = Vector3d::Zero();
  for (LightNode& light_node : light_nodes_) {
    const Vector3d parent_m_s = nodes_.velocity_m_s(light_node.parent),
                   gained = parent_m_s - light_node.parent_m_s;
    light_node.parent_m_s = parent_m_s;
    if (inverse_masses_[light_node.node] == 0.0) continue;
    const Vector3d position = nodes_.position_m(light_node.node);
    const Vector3d deviation_m_s = parent_m_s - nodes_.velocity_m_s(light_node.node) -
                                   spin.cross(nodes_.position_m(light_node.parent) - position);
    const Vector3d change =
        kLightNodeDamping * deviation_m_s +
        (first_step_ ? 0.0 : light_node.added_mass_fraction) * (gained - step_s * gravity_m_s2);
    nodes_.change_velocities(light_node.node, change);
    momentum += masses_kg_[light_node.node] * change;
    angular += masses_kg_[light_node.node] * (position - motion_.centre_m).cross(change);
  }
  if (light_nodes_.empty() || !free()) return;
  velocity_correction_ -= momentum / mass_kg_;
  spin_correction_ -= solve_inertia(node_inertia_, angular);
}

// Updates the motion of the whole body and the difference between ledger and nodes. An impulse J at p changes
// the angular momentum about a fixed point by p x J, independent of the path of the centre c. Its part about
// the centre is (p - c) x J, with c before the step, less e x P, where e is the lead of c over h P / m. BDF2
// spreads this lead over several steps: e' = (e - h J / m) / 3.
void CellsBody::measure(const NodeSums& sums, double h) {
  const Vector3d centre_before = motion_.centre_m, spin_of_step = motion_.angular_velocity_rad_s();
  motion_.mass_kg = mass_kg_;
  motion_.centre_m = vector_of(sums.mass_position) / mass_kg_;
  motion_.momentum = vector_of(sums.momentum);
  motion_.angular_momentum = vector_of(sums.angular) - motion_.centre_m.cross(motion_.momentum);
  const Vector3d& c = motion_.centre_m;
  const double xx = sums.second[0] - mass_kg_ * c.x() * c.x(), yy = sums.second[1] - mass_kg_ * c.y() * c.y(),
               zz = sums.second[2] - mass_kg_ * c.z() * c.z(), xy = sums.second[3] - mass_kg_ * c.x() * c.y(),
               yz = sums.second[4] - mass_kg_ * c.y() * c.z(), zx = sums.second[5] - mass_kg_ * c.z() * c.x();
  motion_.inertia << yy + zz, -xy, -zx, -xy, xx + zz, -yz, -zx, -yz, xx + yy;
  step_orientation_ = (rotation_exp(h * spin_of_step) * step_orientation_).normalized();
  use_material_inertia();

  velocity_correction_.setZero();
  spin_correction_.setZero();
  if (free()) {
    ledger_momentum_ += contact_impulse_;
    contact_lag_m_ -= h / mass_kg_ * (contact_impulse_ + between_steps_impulse_);
    contact_lag_m_ *= second_order_ ? 1.0 / 3.0 : 0.0;
    between_steps_impulse_.setZero();
    ledger_angular_ +=
        contact_moment_ - centre_before.cross(contact_impulse_) - contact_lag_m_.cross(ledger_momentum_);
    velocity_correction_ = (ledger_momentum_ - motion_.momentum) / mass_kg_;
    spin_correction_ = solve_inertia(motion_.inertia, ledger_angular_ - motion_.angular_momentum);
    motion_.momentum = ledger_momentum_;
    motion_.angular_momentum = ledger_angular_;
  }
  const Vector3d spin = motion_.angular_velocity_rad_s();
  spin_rad_s_ = spin.norm();
  const double rigid_j =
      0.5 * motion_.momentum.squaredNorm() / mass_kg_ + 0.5 * spin.dot(node_inertia_ * spin);
  kinetic_j_ = sums.kinetic - 0.5 * spin.dot((node_inertia_ - motion_.inertia) * spin);  // equal if held
  deviation_m_s_ = std::sqrt(std::max(0.0, 2.0 * (sums.kinetic - rigid_j) / mass_kg_));
}

}  // namespace livegs
