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

#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/motion/free_rotation.h"
#include "physics/motion/vector_algebra.h"

namespace livegs::cells {
namespace {

// Volume ratio det F below which a body takes first-order steps, which dissipate energy, as beyond
// kStrainedSquared; BDF2 would amplify the motion.
constexpr double kFirstOrderVolumeRatio = 0.2;
// A body in contact also takes first-order steps while its shape changes slowly: RMS speed below this
// fraction of sqrt(g L), with L the smallest side (the speed after a fall of L/200). Pointwise contact causes
// noise, which BDF2 damps too little.
constexpr double kMaxSlowSpeedRatio = 0.1;

// Grip strength fades from full at this cell stretch to zero at twice the stretch.
constexpr double kGripFadeStart = 2.0;

// Impact speed that triggers impact steps, relative to the wave speed. Larger values let landing bodies gain
// energy.
constexpr double kImpactSpeedRatio = 0.03;
constexpr double kImpactFrames = 2.0;

}  // namespace

int CellsBody::begin_substep(const SubstepContext& context) {
  surface_.boxes_known = false;
  rest_.forced = false;
  rest_.driven = driven(context.start_s, context.start_s + context.duration_s);
  for (const PointForce& force : context.forces)
    rest_.forced = rest_.forced || force.spring || force.force_n.squaredNorm() > 0.0;
  if (asleep()) {
    const bool touched = rest_.forced || rest_.driven || may_touch_awake(context);
    if (!touched) return 0;
    wake();
  }
  if (rest_.rigid && rigid_substep(context)) return 0;
  // A substep longer than the scene's is split, never stretched, because the stiffness was chosen for the
  // scene's; at most 6000 of those: about 1 s at 90 Hz and 64 substeps.
  const double longer = std::ceil(context.duration_s * accuracy_.rate_hz * accuracy_.scene_substeps - 1e-6);
  gather_point_loads(context);
  const int steps = accuracy_.resolution.substeps / accuracy_.scene_substeps *
                    static_cast<int>(std::clamp(longer, 1.0, 6000.0));
  return in_impact(context) ? steps * accuracy_.resolution.impact_substeps : steps;
}

// Impact detection. The body's own steps are too long for a shock: with one sweep each, the cells in front of
// it invert and gain energy. An impact is a fast deformation in contact, or a fast approach. Impact steps
// last kImpactFrames, by which time most of the shock is vibration. They are not used for bodies in a hand,
// or next to other elastic bodies: all of these would take the same steps, and they yield anyway.
bool CellsBody::in_impact(const SubstepContext& context) {
  if (without(Mechanism::ImpactSteps) || !context.others.empty() || rest_.forced) return false;
  const bool comes = !step_.touching && !(colliders_.candidates.empty() && bodies_.rigid_candidates.empty());
  const double speed_m_s = step_.touching ? step_.deviation_m_s
                           : comes        ? ledger_.motion.velocity_m_s().norm() + step_.deviation_m_s
                                          : 0.0;
  if (speed_m_s > kImpactSpeedRatio * accuracy_.resolution.wave_speed_m_s(accuracy_.rate_hz))
    step_.impact_until_s = context.start_s + kImpactFrames / accuracy_.rate_hz;
  return context.start_s < step_.impact_until_s;
}

void CellsBody::end_substep(const SubstepContext& context) {
  step_.gravity = context.gravity_m_s2;
  step_.gravity_m_s2 = step_.gravity.norm();
  rest_.supported = step_.touching || holding_.held || context.gravity_m_s2.squaredNorm() == 0.0;
}

// Collects the point forces of the scene and the tractions of regions.
void CellsBody::gather_point_loads(const SubstepContext& context) {
  loads_.points = loads_.regions;
  for (const PointForce& force : context.forces) {
    loads_.points.push_back({sample_at(lattice_.embed(force.point_m)), force.force_n, force.spring});
  }
}

// Implicit springs. The spring force at the end of a step depends on the force itself through the mobility w
// of its point. The update is therefore scaled by 1 / (1 + w h (k h + c)). This is stable for any stiffness,
// and at rest the force is stiffness times stretch.
void CellsBody::solve_springs(const SubstepPart& part) {
  const double h = part.duration_s;
  for (Load& load : loads_.points) {
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
    spring.force_n = clamp_norm(spring.force_n, spring.max_force_n * grip_factor(load.sample));
    load.force_n = spring.force_n;
  }
}

// Grip strength, by the largest stretch of the cell that a hand holds. Unlimited pulling would stretch thin
// parts without bound and add large amounts of energy.
double CellsBody::grip_factor(const NodeSample& sample) const {
  if (without(Mechanism::GripFade)) return 1.0;
  Matrix3d f = Matrix3d::Zero();
  for (int c = 0; c < 8; ++c) f += nodes_.position_m(sample.nodes[c]) * corner_sign(c).transpose();
  f *= 0.25 / lattice_.cell_width_m;
  const double squared =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(f.transpose() * f, Eigen::EigenvaluesOnly).eigenvalues()[2];
  return std::clamp(2.0 - std::sqrt(squared) / kGripFadeStart, 0.0, 1.0);
}

double CellsBody::slow_speed_m_s(const Vector3d& gravity_m_s2) const {
  const double smallest_m = size_m().minCoeff();
  return kMaxSlowSpeedRatio * std::sqrt(gravity_m_s2.norm() * smallest_m);
}

void CellsBody::begin_step(const SubstepPart& part, const SubstepContext& context) {
  const double h = part.duration_s, time_s = context.start_s + part.began_s + h;
  // Neighbours can impose another step length. The previous step is then not a valid basis for BDF2.
  const bool even = std::abs(h - gains_.last_step_s) <= 1e-9 * h;
  gains_.last_step_s = h;
  step_.is_slow = !without(Mechanism::FirstOrderWhenSlow) && step_.touching &&
                  step_.deviation_m_s < slow_speed_m_s(context.gravity_m_s2);
  step_.second_order = options_.second_order && even && !step_.first &&
                       (!step_.strained || without(Mechanism::FirstOrderWhenStrained)) && !step_.is_slow;
  // The result of a sweep from zero multipliers depends slightly on its order. A landing body alternates the
  // order, because a fixed one would cause a sideways drift. A slow body keeps one order in order to come to
  // rest, and so does a free one, because nearly empty cells would vibrate.
  step_.backward =
      !without(Mechanism::AlternatingSweep) && step_.touching && !step_.is_slow && !step_.backward;
  for (Load& load : loads_.points) load.from_m = nodes_.position_m(load.sample);
  solve_springs(part);
  predict(h, context);
  if (holding_.moved) move_regions(time_s, h);

  GaussSeidelArrays sweep;
  sweep.predicted = nodes_.predicted();
  sweep.corrections = nodes_.corrections();
  sweep.full = batches_.full.data();
  sweep.cut = batches_.cut.data();
  sweep.thin = batches_.thin.data();
  sweep.plastic = plastic_.cut.empty() ? nullptr : plastic_.cut.data();
  sweep.thin_plastic = plastic_.parts.empty() ? nullptr : plastic_.thin.data();
  const GaussSeidelGains& gains = gains_of(h, step_.second_order);
  sweep.gains = gains.cut.data();
  sweep.thin_gains = gains.thin.data();
  sweep.full_gains = gains.full;
  sweep.inverse_four_widths = static_cast<float>(0.25 / lattice_.cell_width_m);
  sweep.backward = step_.backward;
  sweep.paired = batches_.paired;
  const GaussSeidelReport report = gauss_seidel_pass(sweep, batches_.colours);
  step_.strain_squared = report.strain_squared;
  step_.bent_squared = report.bent_squared;
  step_.strained = report.strain_squared > kStrainedSquared || report.volume_ratio < kFirstOrderVolumeRatio;
  recovery_.degenerate = recovery_.degenerate || step_.strained;

  if (holding_.held) hold_particles(time_s);
  ledger_.contact_impulse.setZero();
  ledger_.contact_moment.setZero();
  colliders_.contacts.clear();
  bodies_.contacts.clear();
  step_.touching = false;
  loads_.contact_n_s = 0.0;
  step_.in_step = true;
  surface_.boxes_known = false;
}

void CellsBody::end_step(const SubstepPart& part, const SubstepContext& context) {
  resolve_colliders(step_of(part.duration_s), context);
  update_carried_load(part);
  advance(part.duration_s);
  for (const Load& load : loads_.points)
    limiter_.work_j += load.force_n.dot(nodes_.position_m(load.sample) - load.from_m);
  step_.first = false;
  step_.in_step = false;
}

// Estimates the load carried by the body, which lowers its vibration frequencies and increases their energy.
// The carried load is the part of the contact impulses that cancels, each pair counted once. Contact impulses
// on one side do not cancel: within Coulomb's cone, the sum of their magnitudes is at most sqrt(1 + mu²)
// times the magnitude of their sum. In a held body the sum passes to the held nodes, so it is carried as
// well.
void CellsBody::update_carried_load(const SubstepPart& part) {
  const double friction = max_friction(), sum = ledger_.contact_impulse.norm();
  const double through = loads_.contact_n_s / std::sqrt(1.0 + friction * friction) - sum;
  const double mean_s = 0.5 * kLastingTime_s;  // time constant; spans several bounces
  const double part_of_mean = part.duration_s / (part.duration_s + mean_s);
  const double carried_n_s = 0.5 * std::max(0.0, through) + (holding_.held ? sum : 0.0);
  loads_.pressed_n += part_of_mean * (loads_.contact_n_s / part.duration_s - loads_.pressed_n);
  loads_.carried_n += part_of_mean * (carried_n_s / part.duration_s - loads_.carried_n);
}

void CellsBody::predict(double h, const SubstepContext& context) {
  const double step_s = step_of(h);
  const double memory = step_.second_order ? 1.0 / 3.0 : 0.0;
  Vector3d force = mass_kg_ * context.gravity_m_s2, torque = Vector3d::Zero();
  for (const Load& load : loads_.points) {
    force += load.force_n;
    torque += (nodes_.position_m(load.sample) - ledger_.motion.centre_m).cross(load.force_n);
  }

  // Damping acts on the deviation from rigid motion, not on forces (otherwise a load would appear lighter).
  // The rigid motion follows the ledger. A load M lowers the frequency to sqrt(k / (m' + M)), and
  // only the part m' / (m' + M) of the energy is in the motion of the nodes, which the damping acts on. The
  // rate is therefore multiplied by sqrt(1 + M / m'). m' is pi²/144 of m between two contacts, and m/3 in a
  // held body (a rod held at its end). A step cannot remove more than the whole deviation.
  const double weight_n = mass_kg_ * context.gravity_m_s2.norm(), rate = damping_rate();
  const double moving_part = free() ? M_PI * M_PI / 144.0 : 1.0 / 3.0;
  const double loaded = weight_n > 0.0 && !without(Mechanism::LoadedDamping)
                            ? std::sqrt(1.0 + loads_.carried_n / (moving_part * weight_n))
                            : 1.0;
  const double kept = std::max(0.0, 1.0 - step_s * (loaded - 1.0) * rate) / (1.0 + step_s * rate);
  Vector3d old_velocity = Vector3d::Zero(), old_spin = Vector3d::Zero();
  Vector3d new_velocity = Vector3d::Zero(), new_spin = Vector3d::Zero();
  if (free() || holding_.moved) {
    old_velocity =
        (ledger_.motion.momentum + memory * (ledger_.motion.momentum - ledger_.momentum_before)) / mass_kg_;
    old_spin = solve_inertia(ledger_.motion.inertia,
                             ledger_.motion.angular_momentum +
                                 memory * (ledger_.motion.angular_momentum - ledger_.angular_before));
    new_velocity = old_velocity;
    new_spin = old_spin;
  }
  if (free()) {
    ledger_.momentum = ledger_.motion.momentum + h * force;
    ledger_.angular = ledger_.motion.angular_momentum + h * torque;
    new_velocity = (ledger_.momentum - step_s * force) / mass_kg_;
    // The nodes get the torque with their own inertia, below.
    new_spin = solve_inertia(ledger_.motion.inertia, ledger_.angular) -
               step_s * solve_inertia(ledger_.node_inertia, torque);
  }
  PredictStep predict;
  predict.memory = static_cast<float>(memory);
  predict.step_s = static_cast<float>(step_s);
  predict.kept = static_cast<float>(kept);
  predict.centre = CellNodes::lanes(ledger_.motion.centre_m);
  predict.correction = CellNodes::lanes(ledger_.velocity_correction);
  predict.correction_spin = CellNodes::lanes(ledger_.spin_correction);
  predict.bias = CellNodes::lanes(new_velocity - kept * old_velocity + step_s * context.gravity_m_s2);
  predict.spin = CellNodes::lanes(new_spin - kept * old_spin);
  const Matrix3d field = step_s * centrifugal_correction();
  for (int d = 0; d < 3; ++d) predict.field[d] = CellNodes::lanes(field.col(d));
  predict_nodes(nodes_.arrays(), predict);

  for (const Load& load : loads_.points) {
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
  const Vector3d momentum_of_step = ledger_.motion.momentum;
  measure(sums, h);
  ledger_.momentum_before = momentum_of_step;
  ledger_.angular_before = material_angular(Vector3d(sums.angular_before) -
                                            ledger_.motion.centre_m.cross(ledger_.momentum_before));
  const auto exclude = [&](const auto& touch) {
    nodes_.push_before(touch.sample, touch.impulse_n_s);
    ledger_.momentum_before += touch.impulse_n_s;
    ledger_.angular_before +=
        (nodes_.position_m(touch.sample) - ledger_.motion.centre_m).cross(touch.impulse_n_s);
  };
  for (const ColliderContact& touch : colliders_.contacts) exclude(touch);
  for (const DynamicContact& touch : bodies_.contacts) exclude(touch);
}

// Updates the motion of the whole body and the difference between ledger and nodes. An impulse J at p changes
// the angular momentum about a fixed point by p x J, independent of the path of the centre c. Its part about
// the centre is (p - c) x J, with c before the step, less e x P, where e is the lead of c over h P / m. BDF2
// spreads this lead over several steps: e' = (e - h J / m) / 3.
void CellsBody::measure(const NodeSums& sums, double h) {
  const Vector3d centre_before = ledger_.motion.centre_m,
                 spin_of_step = ledger_.motion.angular_velocity_rad_s();
  ledger_.motion.mass_kg = mass_kg_;
  ledger_.motion.centre_m = Vector3d(sums.mass_position) / mass_kg_;
  ledger_.motion.momentum = Vector3d(sums.momentum);
  ledger_.motion.angular_momentum =
      Vector3d(sums.angular) - ledger_.motion.centre_m.cross(ledger_.motion.momentum);
  const Vector3d& c = ledger_.motion.centre_m;
  const double xx = sums.squares[0] - mass_kg_ * c.x() * c.x(),
               yy = sums.squares[1] - mass_kg_ * c.y() * c.y(),
               zz = sums.squares[2] - mass_kg_ * c.z() * c.z(),
               xy = sums.products[0] - mass_kg_ * c.x() * c.y(),
               yz = sums.products[1] - mass_kg_ * c.y() * c.z(),
               zx = sums.products[2] - mass_kg_ * c.z() * c.x();
  ledger_.motion.inertia << yy + zz, -xy, -zx, -xy, xx + zz, -yz, -zx, -yz, xx + yy;
  ledger_.step_orientation = (rotation_exp(h * spin_of_step) * ledger_.step_orientation).normalized();
  use_material_inertia();

  ledger_.velocity_correction.setZero();
  ledger_.spin_correction.setZero();
  if (free()) {
    ledger_.momentum += ledger_.contact_impulse;
    ledger_.contact_lag_m -= h / mass_kg_ * (ledger_.contact_impulse + ledger_.between_steps_impulse);
    ledger_.contact_lag_m *= step_.second_order && !without(Mechanism::ContactLag) ? 1.0 / 3.0 : 0.0;
    ledger_.between_steps_impulse.setZero();
    ledger_.angular += ledger_.contact_moment - centre_before.cross(ledger_.contact_impulse) -
                       ledger_.contact_lag_m.cross(ledger_.momentum);
    ledger_.velocity_correction = (ledger_.momentum - ledger_.motion.momentum) / mass_kg_;
    ledger_.spin_correction =
        solve_inertia(ledger_.motion.inertia, ledger_.angular - ledger_.motion.angular_momentum);
    ledger_.motion.momentum = ledger_.momentum;
    ledger_.motion.angular_momentum = ledger_.angular;
  }
  const Vector3d spin = ledger_.motion.angular_velocity_rad_s();
  step_.spin_rad_s = spin.norm();
  const double rigid_j =
      0.5 * ledger_.motion.momentum.squaredNorm() / mass_kg_ + 0.5 * spin.dot(ledger_.node_inertia * spin);
  step_.kinetic_j =
      sums.kinetic - 0.5 * spin.dot((ledger_.node_inertia - ledger_.motion.inertia) * spin);  // equal if held
  step_.deviation_m_s = std::sqrt(std::max(0.0, 2.0 * (sums.kinetic - rigid_j) / mass_kg_));
}

}  // namespace livegs::cells
