// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of the baseline with moving bodies: particles as balls against rigid bodies and against particles
// of other elastic bodies, and contact points of rigid bodies against the particles.
#include <algorithm>
#include <cmath>

#include "baseline/livegs_v1_body.h"
#include "physics/elastic/rigid_proxy.h"

namespace livegs {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

ContactAnchor anchor_of(uint32_t particle) {
  ContactAnchor anchor;
  for (uint32_t& node : anchor.sample.nodes) node = particle;
  anchor.sample.weights[0] = 1.0f;
  return anchor;
}

uint32_t particle_of(const ContactAnchor& anchor) { return anchor.sample.nodes[0]; }

}  // namespace

// Receives impulses during a step, or while the body sleeps.
class LivegsV1Body::Participant final : public ContactParticipant {
 public:
  explicit Participant(LivegsV1Body& body) : body_(body) {}
  double step_s = 0.0;

  Matrix3d response(const ContactAnchor& anchor) const override {
    return step_s * body_.mobility(particle_of(anchor)) * Matrix3d::Identity();
  }
  Vector3d displacement_m(const ContactAnchor& anchor) const override {
    if (!body_.in_step_) return step_s * body_.velocities_m_s_[particle_of(anchor)];
    return body_.predicted_m_[particle_of(anchor)] - body_.positions_m_[particle_of(anchor)];
  }
  void apply_impulse(const ContactAnchor& anchor, const Vector3d&, const Vector3d& impulse) override {
    if (!body_.in_step_) return body_.push_particle(particle_of(anchor), impulse);
    body_.predicted_m_[particle_of(anchor)] += step_s * body_.mobility(particle_of(anchor)) * impulse;
  }
  void record_impulse(const ContactAnchor&, const ContactImpulse& impulse) override {
    body_.record_contact_impulse(impulse.point_m, impulse.impulse_n_s.norm());
    body_.touching_ = true;
  }

 private:
  LivegsV1Body& body_;
};

void LivegsV1Body::prepare_contact_step(double step_s) {
  if (!participant_) participant_ = std::make_unique<Participant>(*this);
  static_cast<Participant&>(*participant_).step_s = step_s;
}

void LivegsV1Body::surface_elements(const AlignedBox3d& within, std::vector<SurfaceElement>& elements) const {
  for (const SurfacePoint& point : surface_) {
    const Vector3d at = origin_m_ + (in_step_ ? predicted_m_ : positions_m_)[point.particle];
    if (within.contains(at))
      elements.push_back({at, Vector3d::Zero(), std::max(point.radius_m, 0.5 * spacing_m_), point.particle});
  }
}

Eigen::AlignedBox3d LivegsV1Body::bounds_m() const {
  Eigen::AlignedBox3d box;
  for (const Vector3d& position : positions_m_) box.extend(position);
  return box.translate(origin_m_);
}

double LivegsV1Body::element_reach_m() const { return kElementReach * spacing_m_; }
ContactAnchor LivegsV1Body::anchor_at(uint32_t element, const Vector3d&) const { return anchor_of(element); }

void LivegsV1Body::push_particle(uint32_t particle, const Vector3d& impulse_n_s) {
  if (asleep()) wake();
  if (held(particle)) return;
  velocities_m_s_[particle] += mobility(particle) * impulse_n_s;
  motion_.momentum += impulse_n_s;
  motion_.angular_momentum += (positions_m_[particle] - motion_.centre_m).cross(impulse_n_s);
}

void LivegsV1Body::record_contact_impulse(const Vector3d& point_m, double impulse_n_s) {
  contact_total_.impulse_n_s += impulse_n_s;
  contact_total_.moment += impulse_n_s * point_m;
}

void LivegsV1Body::sleep() {
  sleep_timer_.sleep();
  for (Vector3d& v : velocities_m_s_) v.setZero();
  motion_.momentum.setZero();
  motion_.angular_momentum.setZero();
}

bool LivegsV1Body::may_touch_awake(const SubstepContext& context) const {
  for (const RigidProxy* body : context.bodies) {
    if (body->asleep) continue;
    const Pose body_from_world = body->start.inverse();
    const double margin = context.duration_s * body->fastest_m_s() + kRowMargin * spacing_m_;
    const auto gap = [&](const Vector3d& p) {
      return body->shape->sample(body_from_world * Vector3d(origin_m_ + p)).distance_m;
    };
    if (gap(motion_.centre_m) > reach_m_ + spacing_m_ + margin) continue;
    for (const SurfacePoint& point : surface_) {
      if (gap(positions_m_[point.particle]) < point.radius_m + margin) return true;
    }
  }
  return false;
}

void LivegsV1Body::list_contacts(const SubstepPart& part, const SubstepContext& context,
                                 std::vector<ContactConstraint>& rows) {
  if (context.bodies.empty() && context.others.empty()) return;
  const double h = part.duration_s;
  ContactParticipant& participant = contact_participant();
  const double margin = kRowMargin * spacing_m_;
  const Vector3d centre = origin_m_ + motion_.centre_m, displacement = h * motion_.velocity_m_s();
  const double around = 1.1 * (reach_m_ + spacing_m_) + displacement.norm();
  AlignedBox3d box;
  for (const SurfacePoint& point : contact_points_)
    box.extend(Vector3d(origin_m_ + predicted_m_[point.particle]));

  std::vector<SurfaceElement> own;
  for (RigidProxy* body : context.bodies) {
    const Pose from_before = body->before.inverse(), at = body->at_end(), from_at = at.inverse();
    if (body->shape->sample(from_at * centre).distance_m > around + h * body->fastest_m_s()) continue;
    const auto add = [&](uint32_t particle, const Vector3d& normal, double gap) {
      ContactConstraint row;
      row.a = &participant;
      row.b = body;
      row.anchor_a = anchor_of(particle);
      row.point_m = origin_m_ + predicted_m_[particle];
      // A first-order step applies a particle's impulse at its position before the step.
      row.anchor_b = body->anchor_at(row.point_m, origin_m_ + positions_m_[particle]);
      row.normal = normal;
      row.gap_m = gap;
      row.friction = mixed_friction(material_.friction, body->friction_at(from_at * row.point_m));
      row.other_body_id = body->body_id;
      rows.push_back(row);
    };
    for (const SurfacePoint& point : contact_points_) {
      const DistanceField::Sample found =
          swept_gap(*body->shape, from_before * Vector3d(origin_m_ + positions_m_[point.particle]),
                    from_at * Vector3d(origin_m_ + predicted_m_[point.particle]));
      const double gap = found.distance_m - point.radius_m;
      if (gap <= margin) add(point.particle, at.orientation * found.gradient, gap);
    }
    if (body->shape->is_ball()) continue;
    if (own.empty()) {
      for (const SurfacePoint& point : surface_) {
        own.push_back(
            {origin_m_ + predicted_m_[point.particle], Vector3d::Zero(), point.radius_m, point.particle});
      }
    }
    const PointSurface grid(own, element_reach_m());
    for (const Vector3d& corner : body->shape->contact_points_m) {
      const Vector3d point = at * corner;
      if (!box.contains(point)) continue;
      const auto depth = grid.depth(point);
      if (depth && depth->distance_m <= 0.0) add(depth->element, -depth->normal, depth->distance_m);
    }
  }
  for (const ElasticNeighbour& other : context.others) {
    std::vector<SurfaceElement> elements;
    const Vector3d room = Vector3d::Constant(other.body->element_reach_m());
    other.body->surface_elements(AlignedBox3d(box.min() - room, box.max() + room), elements);
    if (elements.empty()) continue;
    const PointSurface grid(elements, other.body->element_reach_m());
    const double friction = mixed_friction(material_.friction, other.body->material().friction);
    for (const SurfacePoint& point : surface_) {
      const Vector3d at = origin_m_ + predicted_m_[point.particle];
      const auto depth = grid.swept_depth(at, displacement - h * other.body->velocity_m_s());
      if (!depth || depth->distance_m - point.radius_m > margin) continue;
      ContactConstraint row;
      row.a = &participant;
      row.b = &other.body->contact_participant();
      row.anchor_a = anchor_of(point.particle);
      row.anchor_b = anchor_of(depth->element);
      row.point_m = at;
      row.normal = depth->normal;
      row.gap_m = depth->distance_m - point.radius_m;
      row.friction = friction;
      row.other_body_id = other.body_id;
      rows.push_back(row);
    }
  }
}

}  // namespace livegs
