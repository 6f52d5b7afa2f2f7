// SPDX-License-Identifier: GPL-3.0-or-later
// Release of stuck contacts. A soft body can be pulled around a bar until its points are on both sides; each
// point is then pushed out on its own side, and no local contact rule resolves this. The state is detected
// for the whole body: the impulses from one body cancel, and the strain is extreme (a sheet that drapes over
// a box is strained less). Contact with that body is then disabled, and the bodies are pulled apart while the
// shape recovers, until they no longer overlap. A rubber band stretched around a bar is treated in the same
// way.
#include <algorithm>

#include "core/log.h"
#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/rigid_proxy.h"
#include "physics/motion/body_id.h"

namespace livegs::cells {
namespace {

constexpr double kMaxNetImpulseRatio = 0.5;  // of the sum of impulses relative to the sum of their magnitudes
// Separation: one body radius in half of kLastingTime_s, with at most this acceleration.
constexpr double kMaxSeparation_m_s2 = 20.0;

}  // namespace

StuckContact& CellsBody::stuck_contact(uint64_t body_id) {
  const auto at = std::ranges::lower_bound(bodies_.stuck, body_id, {}, &StuckContact::body_id);
  if (at != bodies_.stuck.end() && at->body_id == body_id) return *at;
  return *bodies_.stuck.insert(at, {.body_id = body_id});
}

bool CellsBody::is_separating(uint64_t body_id) const {
  return std::ranges::any_of(
      bodies_.stuck, [&](const StuckContact& one) { return one.separating && one.body_id == body_id; });
}

bool CellsBody::is_separating() const {
  return std::ranges::any_of(bodies_.stuck, &StuckContact::separating);
}

void CellsBody::read_contact_impulses(std::span<const ContactConstraint> rows) {
  apply_rolling_resistance(rows);
  for (const ContactConstraint& row : rows) {
    if (row.point == UINT32_MAX || !(row.normal_impulse_n_s > 0.0)) continue;
    if (bodies_.last_forces.empty()) bodies_.last_forces.resize(surface_.points.size());
    bodies_.last_forces[row.point] = {row.other_body_id, bodies_.step,
                                      (row.friction_impulse_n_s / bodies_.step_s).cast<float>(),
                                      static_cast<float>(row.normal_impulse_n_s / bodies_.step_s)};
  }
}

void CellsBody::record_push(const ContactImpulse& impulse) {
  if (step_.bent_squared <= kOverstrainedSquared) return;
  StuckContact& from = stuck_contact(impulse.from_body_id);
  from.pushed_n_s += impulse.push_n_s.norm();
  from.net_n_s += impulse.push_n_s;
}

// Runs once per frame.
void CellsBody::update_stuck_contacts(double frame_s) {
  for (StuckContact& one : bodies_.stuck) {
    if (!one.separating) {
      const bool stuck = one.net_n_s.norm() < kMaxNetImpulseRatio * one.pushed_n_s;
      one.stuck_s += stuck ? frame_s : -frame_s;
      one.separating = one.overlaps = one.stuck_s > kLastingTime_s && !without(Mechanism::StuckContacts);
      if (one.separating)
        log_debug("object %u: stuck on object %u; contact is off until they are apart", object_id_,
                  object_of_body(one.body_id));
    } else if (!one.overlaps) {
      one.separating = false;
      one.stuck_s = 0.0;
    } else {
      one.overlaps = false;  // set again by a step that finds an overlap
    }
    one.pushed_n_s = 0.0;
    one.net_n_s.setZero();
  }
  std::erase_if(bodies_.stuck, [](const StuckContact& one) { return !one.separating && one.stuck_s <= 0.0; });
}

void CellsBody::apply_uniform_impulse(const Vector3d& impulse_n_s, double step_s) {
  if (asleep()) wake();
  const Vector3d gained = impulse_n_s / mass_kg_;
  for (uint32_t i = 0; i < masses_kg_.size(); ++i) {
    if (inverse_masses_[i] == 0.0) continue;
    if (step_.in_step) {
      nodes_.correct(i, step_of(step_s) * gained);
    } else {
      nodes_.change_velocities(i, gained);
    }
  }
  if (step_.in_step) {
    ledger_.contact_impulse += impulse_n_s;
    ledger_.contact_moment += ledger_.motion.centre_m.cross(impulse_n_s);
  } else if (free()) {
    ledger_.motion.momentum += impulse_n_s;
    ledger_.momentum_before += impulse_n_s;
    ledger_.between_steps_impulse += impulse_n_s;
  }
}

void CellsBody::separate(const SubstepPart& part, const SubstepContext& context,
                         std::vector<ContactConstraint>& rows) {
  const uint64_t own_id = body_id_of(object_id_);
  std::vector<CellsBody*> separating;  // elastic bodies that separate from this one
  for (const ElasticNeighbour& other : context.others) {
    if (other.body->is_separating(own_id)) separating.push_back(static_cast<CellsBody*>(other.body));
  }
  if (separating.empty() && !is_separating()) return;
  // Contact is off if one of two bodies separates from the other, which then learns of overlaps.
  std::erase_if(rows, [&](const ContactConstraint& row) {
    bool off = is_separating(row.other_body_id);
    if (off && row.gap_m < 0.0) stuck_contact(row.other_body_id).overlaps = true;
    for (CellsBody* other : separating) {
      if (body_id_of(other->object_id_) != row.other_body_id) continue;
      off = true;
      if (row.gap_m < 0.0) other->stuck_contact(own_id).overlaps = true;
    }
    return off;
  });

  const Vector3d centre = centre_m();
  const double speed_m_s = reach_m_ / (0.5 * kLastingTime_s),
               most_m_s = kMaxSeparation_m_s2 * part.duration_s;
  const auto impulse = [&](const Vector3d& away, const Vector3d& other_m_s,
                           double other_inverse_mass) -> Vector3d {
    const double lacking = speed_m_s - away.dot(velocity_m_s() - other_m_s);
    return std::clamp(lacking, 0.0, most_m_s) / (1.0 / mass_kg_ + other_inverse_mass) * away;
  };
  for (RigidProxy* body : context.bodies) {
    if (!is_separating(body->body_id)) continue;
    StuckContact& one = stuck_contact(body->body_id);
    const Pose at = body->at_end(), body_from_world = at.inverse();
    // A bar through the middle of the body may be near no surface point.
    for (uint32_t i = 0; i < lattice_.cells.size() && !one.overlaps; ++i) {
      const Vector3d inside = origin_m_ + nodes_.corrected_m(sample_at({i, lattice_.cells[i].centroid}));
      one.overlaps = body->shape->sample(body_from_world * inside).distance_m < 0.0;
    }
    if (!one.overlaps) continue;
    const Vector3d away = at.orientation * body->shape->sample(body_from_world * centre).gradient;
    const Vector3d other_m_s = body->velocity_m_s + body->spin_rad_s.cross(centre - at.position_m);
    const Vector3d given = impulse(away, other_m_s, body->inverse_mass);
    apply_uniform_impulse(given, part.duration_s);
    const ContactAnchor anchor = body->anchor_at(centre);
    body->apply_impulse(anchor, centre, -given);
    body->record_impulse(anchor, {centre, -given, -given, body_id_of(object_id_)});
  }
  for (const ElasticNeighbour& other : context.others) {
    if (!is_separating(other.body_id) || !stuck_contact(other.body_id).overlaps) continue;
    if (other.body->is_separating(own_id) && other.body_id < own_id) continue;  // pulls both
    const Vector3d between = centre - other.body->centre_m();
    const Vector3d given = impulse(between.norm() > 0.0 ? Vector3d(between.normalized()) : Vector3d::UnitY(),
                                   other.body->velocity_m_s(), 1.0 / other.body->mass_kg());
    apply_uniform_impulse(given, part.duration_s);
    other.body->apply_uniform_impulse(-given, part.duration_s);
  }
}

}  // namespace livegs::cells
