// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/contact/restitution.h"

#include <algorithm>
#include <cmath>

namespace livegs {

RestitutionEnergyLimiter::RestitutionEnergyLimiter(std::span<RigidBody* const> bodies) : bodies_(bodies) {
  positions_m_.reserve(bodies.size());
  for (const RigidBody* body : bodies) {
    held_ = held_ || !body->springs.empty();
    kinetic_j_ += body->asleep ? 0.0 : body->kinetic_j();
    positions_m_.push_back(body->world_from_body.position_m);
  }
}

void RestitutionEnergyLimiter::begin() {
  before_.clear();
  for (const RigidBody* body : bodies_) {
    before_.push_back({body->velocity_m_s, body->angular_momentum, body->angular_velocity_rad_s});
  }
}

double RestitutionEnergyLimiter::end() {
  if (held_) return 1.0;
  // E_allowed = E_start + work of gravity and loads. E(s) = before + s linear + s² square, where `before` is
  // the energy without restitution.
  double most = kinetic_j_, before = 0.0, linear = 0.0, square = 0.0;
  for (size_t i = 0; i < bodies_.size(); ++i) {
    const RigidBody& body = *bodies_[i];
    if (body.asleep) continue;
    const Motion& was = before_[i];
    most +=
        body.mass_kg * body.substep_acceleration_m_s2.dot(body.world_from_body.position_m - positions_m_[i]);
    before += 0.5 * (body.mass_kg * was.velocity_m_s.squaredNorm() +
                     was.angular_velocity_rad_s.dot(was.angular_momentum));
    const Eigen::Vector3d change = body.velocity_m_s - was.velocity_m_s,
                          turn = body.angular_momentum - was.angular_momentum;
    linear += body.mass_kg * was.velocity_m_s.dot(change) + was.angular_velocity_rad_s.dot(turn);
    square += 0.5 * (body.mass_kg * change.squaredNorm() +
                     turn.dot(body.angular_velocity_rad_s - was.angular_velocity_rad_s));
  }
  const double room = std::max(0.0, most - before);
  if (linear + square <= room || !(square > 0.0)) return 1.0;
  const double part =
      std::clamp((std::sqrt(linear * linear + 4.0 * square * room) - linear) / (2.0 * square), 0.0, 1.0);
  for (size_t i = 0; i < bodies_.size(); ++i) {
    RigidBody& body = *bodies_[i];
    if (body.asleep) continue;
    const auto cut = [part](Eigen::Vector3d& now, const Eigen::Vector3d& was) {
      now = was + part * (now - was);
    };
    cut(body.velocity_m_s, before_[i].velocity_m_s);
    cut(body.angular_momentum, before_[i].angular_momentum);
    cut(body.angular_velocity_rad_s, before_[i].angular_velocity_rad_s);
  }
  return part;
}

}  // namespace livegs
