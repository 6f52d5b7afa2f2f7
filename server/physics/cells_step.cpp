// SPDX-License-Identifier: GPL-3.0-or-later
// The substep of the `cells` solver (elastic-study.md 2.6 and 4).
//
// BDF2 of a velocity that changes by corrections d: h_e = 2h/3,
//   v^ = (4 v - v_)/3 + h_e a,   y = x + (x - x_)/3 + h_e v^,   x' = y + d,   v' = v^ + d/h_e.
// Momentum ledger: the momentum and the angular momentum of the body as a whole are integrated on their own, in
// impulses: P' = P + h F + sum of contact impulses. So what a ball loses the body gains in the same substep, and
// spin does not leak into the elastic modes. Contact is an impulse to single nodes too: the velocity it gives is kept
// out of the difference v - v_, which BDF2 would otherwise carry on by thirds (half as much again in the end).
#include <algorithm>
#include <cmath>

#include "physics/cells_body.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// A body strained so far that BDF2 would wind it up takes first-order steps, which lose energy.
constexpr double kLargeStrainSquared = 0.25;  // |S - I|²
constexpr double kSmallVolume = 0.2;          // det F
// A body in contact takes first-order steps too while its shape moves slower (root mean square) than this part of
// sqrt(g L), L its smallest size: than after a fall of L/200. Contact point by point makes noise, and BDF2 keeps it
// for minutes.
constexpr double kQuiet = 0.1;
// Points ride in a cell at most this many half-widths from its middle (Lattice::embed).
constexpr double kFurthestEmbedding = 2.0;

Vector3d vector_of(const NodeLanes& lanes) { return {lanes.value[0], lanes.value[1], lanes.value[2]}; }

}  // namespace

void CellsBody::substep(const SubstepContext& context) {
  bool forced = false;
  for (const PointForce& force : context.forces) forced = forced || force.force_n.squaredNorm() > 0.0;
  forced_ = forced_ || forced;
  if (asleep()) {
    bool touched = forced;
    for (const MovingSphere& sphere : context.spheres) {
      const double reach = reach_m_ + sphere.radius_m + context.duration_s * sphere.velocity_m_s.norm();
      touched = touched || (sphere.position_m - origin_m_ - motion_.centre_m).norm() < reach;
    }
    if (!touched) return;
    wake();
  }
  const int count = choice_.substeps / scene_substeps_;
  const double h = context.duration_s / count;
  if (std::abs(h - gains_step_s_) > 1e-9 * h) set_gains(h);
  for (int i = 0; i < count; ++i) step(h, context);
  forced_ = forced;
  supported_ = touching_ || held_ || context.gravity_m_s2.squaredNorm() == 0.0;
}

void CellsBody::step(double h, const SubstepContext& context) {
  const double smallest_m = (extent_.max_m - extent_.min_m).minCoeff();
  const bool quiet = touching_ && deviation_m_s_ < kQuiet * std::sqrt(context.gravity_m_s2.norm() * smallest_m);
  const bool second_order = !first_step_ && !strained_ && !quiet;
  const double step_s = second_order ? 2.0 * h / 3.0 : h;
  predict(h, second_order, context);

  const SweepReport report = sweep_cells(batches_.batches, gains_[second_order], predicted_, corrections_);
  strained_ = report.strain_squared > kLargeStrainSquared || report.volume_ratio < kSmallVolume;

  hold_particles();
  contact_impulse_.setZero();
  contact_moment_.setZero();
  touches_.clear();
  touching_ = false;
  const double reach = reach_m_ + h * motion_.velocity_m_s().norm() + extent_.box_edge_m;
  reachable_colliders(context.colliders, origin_m_ + motion_.centre_m, 1.1 * reach, reachable_);
  if (!reachable_.empty()) resolve_colliders(step_s);
  if (!context.spheres.empty()) resolve_balls(h, step_s, context.spheres);
  advance(step_s);
  first_step_ = false;
}

void CellsBody::predict(double h, bool second_order, const SubstepContext& context) {
  const size_t count = masses_kg_.size();
  const double step_s = second_order ? 2.0 * h / 3.0 : h;
  const double memory = second_order ? 1.0 / 3.0 : 0.0;

  Vector3d force = motion_.mass_kg * context.gravity_m_s2, torque = Vector3d::Zero();
  const bool forced = !context.forces.empty();
  if (forced) {
    std::fill(accelerations_m_s2_.begin(), accelerations_m_s2_.end(), Vector3d::Zero());
    for (const PointForce& point : context.forces) {
      const Sample sample = sample_at(lattice_.embed(point.point_m));
      for (int c = 0; c < 8; ++c) {
        accelerations_m_s2_[sample.nodes[c]] += sample.weights[c] * inverse_masses_[sample.nodes[c]] * point.force_n;
      }
      force += point.force_n;
      torque += (at(sample, positions_m_) - motion_.centre_m).cross(point.force_n);
    }
  }

  MassMotion predicted;  // of the velocities carried on without forces, where the body is now
  for (size_t i = 0; i < count; ++i) {
    Vector3d& v = predicted_velocities_m_s_[i];
    if (inverse_masses_[i] == 0.0) {
      v.setZero();
      continue;
    }
    v = velocities_m_s_[i] + memory * (velocities_m_s_[i] - previous_velocities_m_s_[i]);
    const Vector3d momentum = masses_kg_[i] * v;
    predicted.momentum += momentum;
    predicted.angular_momentum += (positions_m_[i] - motion_.centre_m).cross(momentum);
  }

  // The deviation from rigid motion is damped, forces are not (or a load would weigh less); the rigid motion itself
  // follows the ledger.
  const double kept = 1.0 / (1.0 + step_s * damping_rate());
  Vector3d old_velocity = Vector3d::Zero(), old_spin = Vector3d::Zero();
  Vector3d new_velocity = Vector3d::Zero(), new_spin = Vector3d::Zero();
  if (free()) {
    ledger_momentum_ = motion_.momentum + h * force;
    ledger_angular_ = motion_.angular_momentum + h * torque;
    old_velocity = predicted.momentum / motion_.mass_kg;
    old_spin = solve_inertia(motion_.inertia, predicted.angular_momentum);
    new_velocity = (ledger_momentum_ - step_s * force) / motion_.mass_kg;
    new_spin = solve_inertia(motion_.inertia, ledger_angular_ - step_s * torque);
  }
  for (size_t i = 0; i < count; ++i) {
    const Vector3d r = positions_m_[i] - motion_.centre_m;
    Vector3d& v = predicted_velocities_m_s_[i];
    v = kept * (v - old_velocity - old_spin.cross(r)) + new_velocity + new_spin.cross(r) +
        step_s * context.gravity_m_s2;
    if (forced) v += step_s * accelerations_m_s2_[i];
    Vector3d y = positions_m_[i];
    if (inverse_masses_[i] == 0.0) {
      v.setZero();
    } else {
      y += memory * (positions_m_[i] - previous_positions_m_[i]) + step_s * v;
    }
    predicted_[i].value = Lanes{y.x(), y.y(), y.z(), inverse_masses_[i]};
    corrections_[i].value = all_lanes(0.0);
  }
}

void CellsBody::hold_particles() {
  for (const HeldSample& held : held_particles_) {
    pull(held.sample, (held.target_m - origin_m_ - corrected(held.sample)) / mobility(held.sample));
  }
}

void CellsBody::resolve_colliders(double step_s) {
  for (const SurfaceCell& cell : surface_cells_) {
    Vector3d centre = Vector3d::Zero();
    for (const uint32_t node : cell.nodes) centre += 0.125 * at(node);
    double radius = 0.0;
    for (const uint32_t node : cell.nodes) radius = std::max(radius, (at(node) - centre).squaredNorm());
    radius = kFurthestEmbedding * std::sqrt(radius);
    for (const Collider* collider : reachable_) {
      if (!reaches(*collider, origin_m_ + centre, radius)) continue;
      const double friction = mixed_friction(material_.friction, collider->friction);
      for (uint32_t i = cell.begin; i < cell.end; ++i) {
        const Sample& sample = surface_[i];
        const Vector3d point = corrected(sample);
        const SurfaceSample surface = sample_surface(*collider, origin_m_ + point);
        const double depth = -surface.distance_m;
        if (depth <= 0.0) continue;
        touching_ = true;
        const double w = mobility(sample);
        if (w <= 0.0) continue;
        const Vector3d moved = point - at(sample, positions_m_);
        const Vector3d correction = contact_correction(surface.normal, depth, moved, friction);
        take_contact(sample, point, correction / w, step_s);
      }
    }
  }
}

void CellsBody::resolve_balls(double h, double step_s, std::span<MovingSphere> spheres) {
  for (MovingSphere& sphere : spheres) {
    const Vector3d start = sphere.position_m;
    Vector3d end = start + h * sphere.velocity_m_s;
    const double reach = 1.1 * (reach_m_ + h * motion_.velocity_m_s().norm()) + sphere.radius_m + extent_.box_edge_m;
    if ((end - origin_m_ - motion_.centre_m).norm() < reach) {
      const double ball_mobility = h / (step_s * sphere.mass_kg);
      const double friction = mixed_friction(material_.friction, sphere.friction);
      for (const Sample& sample : surface_) {
        const Vector3d point = corrected(sample);
        const auto contact =
            ball_contact(origin_m_ + point, 0.0, point - at(sample, positions_m_), mobility(sample), end,
                         end - start, sphere.radius_m, ball_mobility, friction);
        if (!contact) continue;
        const Vector3d impulse = contact->pull_kg_m / step_s;
        take_contact(sample, point, contact->pull_kg_m, step_s);
        sphere.impulse_n_s -= impulse;
        sphere.velocity_m_s -= impulse / sphere.mass_kg;
        end -= h / sphere.mass_kg * impulse;
      }
    }
    sphere.position_m = end;
  }
}

void CellsBody::advance(double step_s) {
  const size_t count = masses_kg_.size();
  std::swap(previous_positions_m_, positions_m_);
  std::swap(previous_velocities_m_s_, velocities_m_s_);
  for (size_t i = 0; i < count; ++i) {
    if (inverse_masses_[i] == 0.0) {
      positions_m_[i] = previous_positions_m_[i];
      velocities_m_s_[i].setZero();
      continue;
    }
    const Vector3d d = vector_of(corrections_[i]);
    positions_m_[i] = vector_of(predicted_[i]) + d;
    velocities_m_s_[i] = predicted_velocities_m_s_[i] + d / step_s;
  }
  for (const Touch& touch : touches_) {
    const Sample& sample = *touch.sample;
    for (int c = 0; c < 8; ++c) {
      const uint32_t node = sample.nodes[c];
      previous_velocities_m_s_[node] += sample.weights[c] * inverse_masses_[node] * touch.impulse_n_s;
    }
  }
  motion_ = mass_motion(positions_m_, velocities_m_s_, masses_kg_);

  if (free()) {
    ledger_momentum_ += contact_impulse_;
    ledger_angular_ += contact_moment_ - motion_.centre_m.cross(contact_impulse_);
    const Vector3d velocity = (ledger_momentum_ - motion_.momentum) / motion_.mass_kg;
    const Vector3d spin = solve_inertia(motion_.inertia, ledger_angular_ - motion_.angular_momentum);
    for (size_t i = 0; i < count; ++i) {
      velocities_m_s_[i] += velocity + spin.cross(positions_m_[i] - motion_.centre_m);
    }
    motion_.momentum = ledger_momentum_;
    motion_.angular_momentum = ledger_angular_;
  }

  const Vector3d velocity = motion_.velocity_m_s(), spin = motion_.angular_velocity_rad_s();
  double deviation = 0.0, furthest = 0.0;
  for (size_t i = 0; i < count; ++i) {
    const Vector3d r = positions_m_[i] - motion_.centre_m;
    deviation += masses_kg_[i] * (velocities_m_s_[i] - velocity - spin.cross(r)).squaredNorm();
    furthest = std::max(furthest, r.squaredNorm());
  }
  deviation_m_s_ = std::sqrt(deviation / motion_.mass_kg);
  reach_m_ = std::sqrt(furthest);
}

Vector3d CellsBody::corrected(const Sample& sample) const {
  Lanes sum = all_lanes(0.0);
  for (int c = 0; c < 8; ++c) {
    const uint32_t node = sample.nodes[c];
    sum += all_lanes(sample.weights[c]) * (predicted_[node].value + corrections_[node].value);
  }
  return {sum[0], sum[1], sum[2]};
}

Vector3d CellsBody::at(uint32_t node) const {
  const Lanes sum = predicted_[node].value + corrections_[node].value;
  return {sum[0], sum[1], sum[2]};
}

double CellsBody::mobility(const Sample& sample) const {
  double sum = 0.0;
  for (int c = 0; c < 8; ++c) sum += sample.weights[c] * sample.weights[c] * inverse_masses_[sample.nodes[c]];
  return sum;
}

void CellsBody::pull(const Sample& sample, const Vector3d& pull_kg_m) {
  const Lanes step = {pull_kg_m.x(), pull_kg_m.y(), pull_kg_m.z(), 0.0};
  for (int c = 0; c < 8; ++c) {
    corrections_[sample.nodes[c]].value += all_lanes(sample.weights[c] * inverse_masses_[sample.nodes[c]]) * step;
  }
}

void CellsBody::take_contact(const Sample& sample, const Vector3d& point_m, const Vector3d& pull_kg_m, double step_s) {
  const Vector3d impulse = pull_kg_m / step_s;
  pull(sample, pull_kg_m);
  contact_impulse_ += impulse;
  contact_moment_ += point_m.cross(impulse);
  touches_.push_back({&sample, impulse});
}

}  // namespace livegs
