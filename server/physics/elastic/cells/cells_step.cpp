// SPDX-License-Identifier: GPL-3.0-or-later
// The substep of the `cells` solver (elastic-study.md 2.6 and 4).
//
// BDF2 of a velocity that changes by corrections d: h_e = 2h/3,
//   v^ = (4 v - v_)/3 + h_e a,   y = x + (x - x_)/3 + h_e v^,   x' = y + d,   v' = v^ + d/h_e.
// Momentum ledger: the momentum and the angular momentum of the body as a whole are integrated on their own,
// in impulses and in double precision: P' = P + h F + sum of contact impulses. So what a ball loses the body
// gains in the same substep, and spin does not leak into the elastic modes. What the nodes lack of it they
// are owed, and get when they are next predicted. Contact is an impulse to single nodes too: the velocity it
// gives is kept out of the difference v - v_, which BDF2 would otherwise carry on by thirds (half as much
// again in the end).
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "physics/elastic/cells/cells_body.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A body strained so far that BDF2 would wind it up takes first-order steps, which lose energy.
constexpr double kFirstOrderStrainSquared = 0.25;  // |S - I|²
constexpr double kFirstOrderVolumeRatio = 0.2;     // det F
// A body in contact takes first-order steps too while its shape moves slower (root mean square) than this
// part of sqrt(g L), L its smallest size: than after a fall of L/200. Contact point by point makes noise, and
// BDF2 keeps it for minutes.
constexpr double kMaxSlowSpeedRatio = 0.1;
// Pressed between others by so many of its weights, a body does not alternate the order of its sweep: what
// two orders differ by grows with the load, and fed a tremble of 0.2 m/s under which a pillow carried a box
// of 25 times its mass 10 cm away.
constexpr double kMaxAlternatingLoad = 4.0;

// Of the stretch of a cell that a hand holds: from here on its grip fades, and here it has none.
constexpr double kGripFadeStart = 2.0, kGripFadeEnd = 4.0;

// Of the speed of its waves. At 0.1 a capsule still read 1.3 times its energy while it landed, at 0.05 1.02
// times, here 1.01.
constexpr double kImpactSpeedRatio = 0.03;
constexpr double kImpactFrames = 2.0;

// Loads are felt over this time: some bounces.
constexpr double kCarriedLoadTime_s = 0.25;

constexpr double kLightNodeDamping = 0.25;  // of a light node's motion beside its parent, a step

// Of the scene's substeps in one: a second at 90 Hz and 64 substeps.
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
  // A longer substep than the scene's is taken in several, never stretched: the stiffness was chosen for this
  // one.
  const double longer = std::ceil(context.duration_s * rate_hz_ * scene_substeps_ - 1e-6);
  gather_point_loads(context);
  const int steps =
      resolution_.substeps / scene_substeps_ * static_cast<int>(std::clamp(longer, 1.0, kMaxSceneSubsteps));
  return in_impact(context) ? steps * resolution_.impact_substeps : steps;
}

// A shock is what a body's own steps are too long for: one sweep each, and the cells in front of it are
// squashed, turned inside out and fly apart with several times the energy. It is known by what deforms while
// it touches, and by what comes near something; two frames are over before most of it has become vibration.
// Not in a hand, and not beside other soft bodies, which would all take its steps (in a heap of five a tick
// of 8 ms took 20), and which give way.
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

// Forces of the scene and tractions, at their nodes. `time_s` is when the step ends.
void CellsBody::gather_point_loads(const SubstepContext& context) {
  point_loads_ = region_loads_;
  for (const PointForce& force : context.forces) {
    point_loads_.push_back({sample_at(lattice_.embed(force.point_m)), force.force_n, force.spring});
  }
}

// What a spring asks for at the end of a step depends on the force itself, by the mobility w of its point at
// most: the force goes by 1 / (1 + w h (k h + c)) of the way there. So none is too stiff, and at rest it is
// stiffness times stretch.
void CellsBody::solve_springs(const SubstepPart& part) {
  const double h = part.duration_s;
  for (Load& load : point_loads_) {
    if (!load.spring) continue;
    PointSpring& spring = *load.spring;
    if (!spring.force_n.allFinite()) spring.force_n.setZero();  // of a body that was put back since
    const double w = mobility(load.sample), k = spring.stiffness_n_m;
    // What the point bears: more would only make it tremble.
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

// A hand slips off what it has drawn out: the cell it holds is stretched, by its longest direction, so and so
// far. One that went on pulling tore leaves out to 120 times their size, and gave 1e4 J a frame to what drew
// them back.
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
  // Beside bodies that need more steps it takes theirs: the last step is then no basis for one of second
  // order.
  const bool even = std::abs(h - last_step_s_) <= 1e-9 * h;
  last_step_s_ = h;
  const double smallest_m = (extent_.max_m - extent_.min_m).minCoeff();
  is_slow_ =
      touching_ && deviation_m_s_ < kMaxSlowSpeedRatio * std::sqrt(context.gravity_m_s2.norm() * smallest_m);
  second_order_ = options_.second_order && even && !first_step_ && !strained_ && !is_slow_;
  // Where a sweep from zero multipliers comes to rest depends on its order a little. A body that lands
  // alternates, or one order would drive it sideways; a quiet one keeps one, or it would never be still, and
  // so does a free one, or cells with next to nothing in them would ring.
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
  boxes_known_ = false;  // it is looked at between steps too
}

// What the body carries makes its vibrations slower and their energy larger, and what damps them is in its
// own nodes. Impulses that cancel go through it. None of those on one side do: within Coulomb's cone their
// sizes sum to no more than sqrt(1 + mu²) of their sum.
void CellsBody::update_carried_load(const SubstepPart& part) {
  const double friction = material_.friction;
  const double through = step_contact_n_s_ / std::sqrt(1.0 + friction * friction) - contact_impulse_.norm();
  const double part_of_mean = part.duration_s / (part.duration_s + kCarriedLoadTime_s);
  carried_n_ += part_of_mean * (0.5 * std::max(0.0, through) / part.duration_s - carried_n_);
}

void CellsBody::predict(double h, const SubstepContext& context) {
  const double step_s = step_of(h);
  const double memory = second_order_ ? 1.0 / 3.0 : 0.0;
  Vector3d force = mass_kg_ * context.gravity_m_s2, torque = Vector3d::Zero();
  for (const Load& load : point_loads_) {
    force += load.force_n;
    torque += (nodes_.position_m(load.sample) - motion_.centre_m).cross(load.force_n);
  }

  // The deviation from rigid motion is damped, forces are not (or a load would weigh less); the rigid motion
  // itself follows the ledger. A loss factor eta takes 2 pi eta of the energy a cycle. Under a load M the
  // body goes as sqrt(k / M), k = E A / L, and of the energy only m / 12 M is in the deviation of its nodes
  // from its mean motion: the rate eta pi sqrt(k / m) of the lowest free mode grows by 12 / pi sqrt(M / m).
  // More than all of the deviation cannot be taken in a step.
  const double weight_n = mass_kg_ * context.gravity_m_s2.norm(), rate = damping_rate();
  const double loaded = weight_n > 0.0 ? std::sqrt(1.0 + 144.0 / (M_PI * M_PI) * carried_n_ / weight_n) : 1.0;
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
    new_spin = solve_inertia(motion_.inertia, ledger_angular_ - step_s * torque);
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
  angular_before_ = vector_of(sums.angular_before) - motion_.centre_m.cross(momentum_before_);
  for (const ColliderContact& touch : collider_contacts_) {
    const NodeSample& sample = surface_[touch.sample];
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

// The mass that light nodes were given is not the material's, and next to nothing holds them: what they move
// by beside the node they follow, the motion of the body as a whole left out, is calmed, and borrowed mass is
// borne with that node: it gains the velocity that the node gained, not gravity's, which the next step adds.
void CellsBody::damp_light_nodes(double step_s, const Vector3d& gravity_m_s2) {
  const Vector3d spin = motion_.angular_velocity_rad_s();
  Vector3d momentum = Vector3d::Zero(), angular = Vector3d::Zero();
  for (LightNode& light_node : light_nodes_) {
    const Vector3d parent_m_s = nodes_.velocity_m_s(light_node.parent),
                   gained = parent_m_s - light_node.parent_m_s;
    light_node.parent_m_s = parent_m_s;
    if (inverse_masses_[light_node.node] == 0.0) continue;
    const Vector3d position = nodes_.position_m(light_node.node);
    const Vector3d beside = parent_m_s - nodes_.velocity_m_s(light_node.node) -
                            spin.cross(nodes_.position_m(light_node.parent) - position);
    const Vector3d change =
        kLightNodeDamping * beside +
        (first_step_ ? 0.0 : light_node.added_mass_fraction) * (gained - step_s * gravity_m_s2);
    nodes_.change_velocities(light_node.node, change);
    momentum += masses_kg_[light_node.node] * change;
    angular += masses_kg_[light_node.node] * (position - motion_.centre_m).cross(change);
  }
  if (light_nodes_.empty() || !free()) return;
  velocity_correction_ -= momentum / mass_kg_;
  spin_correction_ -= solve_inertia(motion_.inertia, angular);
}

// The motion of the body as a whole, and what its nodes lack of the ledger's. An impulse J at p turns the
// body by p x J about a fixed point, whatever way the centre c takes to its new velocity: its share about the
// centre is (p - c) x J with c before the step, less e x P for the way e that c is ahead of h P / m. BDF2
// spreads that way over several steps, e' = (e - h J / m) / 3.
void CellsBody::measure(const NodeSums& sums, double h) {
  const Vector3d centre_before = motion_.centre_m;
  motion_.mass_kg = mass_kg_;
  motion_.centre_m = vector_of(sums.mass_position) / mass_kg_;
  motion_.momentum = vector_of(sums.momentum);
  motion_.angular_momentum = vector_of(sums.angular) - motion_.centre_m.cross(motion_.momentum);
  const Vector3d& c = motion_.centre_m;
  const double xx = sums.second[0] - mass_kg_ * c.x() * c.x(), yy = sums.second[1] - mass_kg_ * c.y() * c.y(),
               zz = sums.second[2] - mass_kg_ * c.z() * c.z(), xy = sums.second[3] - mass_kg_ * c.x() * c.y(),
               yz = sums.second[4] - mass_kg_ * c.y() * c.z(), zx = sums.second[5] - mass_kg_ * c.z() * c.x();
  motion_.inertia << yy + zz, -xy, -zx, -xy, xx + zz, -yz, -zx, -yz, xx + yy;

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
      0.5 * motion_.momentum.squaredNorm() / mass_kg_ + 0.5 * motion_.angular_momentum.dot(spin);
  kinetic_j_ = sums.kinetic;
  deviation_m_s_ = std::sqrt(std::max(0.0, 2.0 * (sums.kinetic - rigid_j) / mass_kg_));
}

}  // namespace livegs
