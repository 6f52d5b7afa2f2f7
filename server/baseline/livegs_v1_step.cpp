// SPDX-License-Identifier: GPL-3.0-or-later
// Substep of the baseline: drive, colliders, and velocities from positions.
#include <algorithm>
#include <cmath>

#include "baseline/livegs_v1_body.h"
#include "core/log.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// Displacements above this fraction of the particle spacing are swept, to prevent tunnelling through the
// ground. kMaxUnsweptPart (conservative_advancement.h) differs: it refers to the body's thickness, and the
// ground of the paper has none.
constexpr double kMaxUnsweptSpacings = 0.5;

// First contact of a moving point with the collider, by sphere tracing. `gap_m` is the contact tolerance and
// the minimum step.
struct Meeting {
  Vector3d point_m, normal;
};
std::optional<Meeting> first_meeting(const Collider& collider, const Vector3d& start_m,
                                     const Vector3d& displacement_m, double radius_m, double gap_m) {
  const double length = displacement_m.norm();
  double gone = 0.0;
  for (int probe = 0; probe < 200 && gone < length; ++probe) {
    const Vector3d point = start_m + gone / length * displacement_m;
    const SurfaceSample surface = sample_surface(collider, point);
    const double free = surface.distance_m - radius_m;
    if (free <= gap_m && surface.normal.dot(displacement_m) < 0.0) return Meeting{point, surface.normal};
    gone += std::max(free, gap_m);
  }
  return std::nullopt;
}

}  // namespace

int LivegsV1Body::begin_substep(const SubstepContext& context) {
  const double end_s = context.start_s + context.duration_s;
  forced_ = driven(context.start_s, end_s);
  for (const PointForce& force : context.forces) forced_ = forced_ || force.force_n.squaredNorm() > 0.0;
  if (asleep()) {
    const bool touched = forced_ || may_touch_awake(context);
    if (!touched) return 0;
    wake();
  }
  touching_ = false;
  return steps_of(context);
}

void LivegsV1Body::end_substep(const SubstepContext& context) {
  supported_ = touching_ || held_ || context.gravity_m_s2.squaredNorm() == 0.0;
}

// Number of steps for the substep; 0 if even 1000 would be too long. If free fall within a substep exceeds
// the particle spacing, the body would be flattened on the ground. Such a substep is split into steps of the
// paper's length, for which d_R was defined. Shorter substeps are never split, so the step dependence of the
// baseline is unchanged.
int LivegsV1Body::steps_of(const SubstepContext& context) {
  const double fall_m = context.duration_s * context.duration_s * context.gravity_m_s2.norm();
  if (fall_m <= spacing_m_) return 1;
  const double steps = std::max(2.0, std::ceil(context.duration_s / kPaperSubstep_s - 1e-9));
  const bool refused = !(steps <= 1000.0);
  if (!warned_of_step_) {
    log_warn(
        "object %u: livegs-v1 %s a substep of %g s (free fall %g m, particle spacing %g m); "
        "raise the rate or the substeps",
        object_id_, refused ? "skips" : "splits", context.duration_s, fall_m, spacing_m_);
    warned_of_step_ = true;
  }
  return refused ? 0 : static_cast<int>(steps);
}

void LivegsV1Body::begin_step(const SubstepPart& part, const SubstepContext& context) {
  drive(context, context.start_s + part.began_s + part.duration_s, part.duration_s);
  match_shapes(blend(part.duration_s));
  in_step_ = true;
}

void LivegsV1Body::end_step(const SubstepPart& part, const SubstepContext& context) {
  const double h = part.duration_s;
  resolve_contacts(context, h);
  for (size_t i = 0; i < positions_m_.size(); ++i)
    velocities_m_s_[i] = (predicted_m_[i] - positions_m_[i]) / h;
  std::swap(positions_m_, predicted_m_);
  motion_ = body_momentum(positions_m_, velocities_m_s_, masses_kg_);
  reach_m_ = 0.0;
  for (const Vector3d& x : positions_m_) reach_m_ = std::max(reach_m_, (x - motion_.centre_m).norm());
  in_step_ = false;
}

// Damping acts on the deviation of the old velocities from the rigid motion of the body (zero if the body is
// anchored). Forces are not damped; otherwise a load would appear lighter.
void LivegsV1Body::drive(const SubstepContext& context, double end_s, double h) {
  const double kept = 1.0 / (1.0 + h * damping_rate(h));
  if (kept < 1.0) {
    const Vector3d velocity = anchored_ ? Vector3d::Zero().eval() : motion_.velocity_m_s();
    const Vector3d spin = anchored_ ? Vector3d::Zero().eval() : motion_.angular_velocity_rad_s();
    for (size_t i = 0; i < positions_m_.size(); ++i) {
      const Vector3d whole = velocity + spin.cross(positions_m_[i] - motion_.centre_m);
      velocities_m_s_[i] = whole + kept * (velocities_m_s_[i] - whole);
    }
  }
  for (const PointForce& force : context.forces) {
    const size_t i = nearest_particle(force.point_m);
    velocities_m_s_[i] += h / masses_kg_[i] * force.force_n;
  }
  for (const Load& load : loads_)
    velocities_m_s_[load.particle] += h / masses_kg_[load.particle] * load.force_n;
  for (size_t i = 0; i < positions_m_.size(); ++i) {
    predicted_m_[i] = positions_m_[i];
    if (!held(i)) predicted_m_[i] += h * (velocities_m_s_[i] + h * context.gravity_m_s2);
  }
  for (const uint32_t i : driven_) predicted_m_[i] = prescribed_m(i, end_s);
}

void LivegsV1Body::resolve_contacts(const SubstepContext& context, double h) {
  // Radius about the centre that encloses every particle before and after the step.
  double swept = reach_m_;
  for (const Vector3d& x : predicted_m_) swept = std::max(swept, (x - motion_.centre_m).norm());
  swept = 1.1 * (swept + spacing_m_);
  const Vector3d centre = origin_m_ + motion_.centre_m;
  reachable_colliders(context.colliders, centre, swept, reachable_);

  for (const SurfacePoint& point : contact_points_) {
    const size_t i = point.particle;
    for (const Collider* collider : reachable_) {
      const double friction = mixed_friction(material_.friction, collider->friction);
      const auto push = [&](const Vector3d& normal, double depth_m) {
        touching_ = true;
        if (held(i)) return;
        const Vector3d correction =
            contact_correction(normal, depth_m, predicted_m_[i] - positions_m_[i], friction);
        predicted_m_[i] += correction;
        record_contact_impulse(origin_m_ + predicted_m_[i], masses_kg_[i] * correction.norm() / h);
      };
      const Vector3d displacement = predicted_m_[i] - positions_m_[i];
      if (displacement.norm() > kMaxUnsweptSpacings * spacing_m_) {
        const auto met = first_meeting(*collider, origin_m_ + positions_m_[i], displacement, point.radius_m,
                                       0.01 * spacing_m_);
        const double depth = met ? met->normal.dot(met->point_m - origin_m_ - predicted_m_[i]) : 0.0;
        if (depth > 0.0) push(met->normal, depth);
      }
      const SurfaceSample surface = sample_surface(*collider, origin_m_ + predicted_m_[i]);
      const double depth = point.radius_m - surface.distance_m;
      if (depth > 0.0) push(surface.normal, depth);
    }
  }
}

void LivegsV1Body::end_frame(double frame_s) {
  if (asleep()) return;
  for (Vector3d& x : positions_m_) x -= motion_.centre_m;
  origin_m_ += motion_.centre_m;
  motion_.centre_m.setZero();
  orientation_ = centre_pose().orientation;
  double fastest = 0.0;
  for (const Vector3d& v : velocities_m_s_) fastest = std::max(fastest, v.squaredNorm());
  // Larger than 0.02 m/s: slow motion may stop.
  if (sleep_timer_.tick(frame_s, std::sqrt(fastest) < 0.02 && supported_ && !forced_)) sleep();
}

}  // namespace livegs
