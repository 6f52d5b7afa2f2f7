// SPDX-License-Identifier: GPL-3.0-or-later
// Sort and sweep: Baraff 1992, Dynamic simulation of non-penetrating rigid bodies, section 2.
#include "physics/rigid/rigid_broad_phase.h"

#include <algorithm>
#include <numeric>

#include "physics/collision/contact_candidate.h"
#include "physics/rigid/contact/contact_solver.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// Substeps of motion at the current speed that boxes are enlarged by. Larger: fewer updates, more pairs.
constexpr double kExpectedSubsteps = 8.0;

// Box swept by the body in `time_s`, including rotation. `margin` is relative to the bounding radius.
Eigen::AlignedBox3d swept_box(const RigidBody& body, double margin, double time_s, double gravity_m_s2) {
  const double radius = body.shape.bounding_radius_m;
  const Pose& pose = body.world_from_body;
  auto [middle, half] = turned_box(body.shape, pose.orientation.toRotationMatrix(), pose.position_m);
  const double turn = std::min(2.0, time_s * body.angular_velocity_rad_s.norm()) * radius;
  half.array() += margin * radius + turn + 0.5 * gravity_m_s2 * time_s * time_s;
  const Vector3d displacement = time_s * body.velocity_m_s;
  return {middle - half + displacement.cwiseMin(0.0), middle + half + displacement.cwiseMax(0.0)};
}

}  // namespace

bool owns_pair(const RigidBody& a, const RigidBody& b) {
  if (a.shape.is_ball() != b.shape.is_ball()) return a.shape.is_ball();
  return a.body_id() < b.body_id();
}

void RigidBroadPhase::update(std::span<RigidBody* const> bodies, double gravity_m_s2, double duration_s) {
  bool good = known_ && boxes_.size() == bodies.size();
  for (size_t i = 0; good && i < bodies.size(); ++i) {
    if (bodies[i]->asleep) continue;
    good = boxes_[i].contains(swept_box(*bodies[i], kContactMargin, duration_s, gravity_m_s2));
  }
  if (good) return;
  known_ = true;
  if (boxes_.size() != bodies.size()) {
    order_.resize(bodies.size());
    std::iota(order_.begin(), order_.end(), 0u);
  }
  boxes_.clear();
  for (RigidBody* body : bodies) {
    boxes_.push_back(swept_box(*body, 5.0 * kContactMargin, kExpectedSubsteps * duration_s, gravity_m_s2));
    body->near.clear();
  }
  find_pairs(bodies);
}

void RigidBroadPhase::find_pairs(std::span<RigidBody* const> bodies) {
  // Sorts along the axis of the largest variance.
  Vector3d mean = Vector3d::Zero(), square = Vector3d::Zero();
  for (const Eigen::AlignedBox3d& box : boxes_) {
    const Vector3d middle = 0.5 * (box.min() + box.max());
    mean += middle;
    square += middle.cwiseProduct(middle);
  }
  (square * static_cast<double>(boxes_.size()) - mean.cwiseProduct(mean)).maxCoeff(&axis_);
  std::ranges::sort(order_, {}, [&](uint32_t i) { return std::pair(boxes_[i].min()[axis_], i); });
  for (size_t i = 0; i < order_.size(); ++i) {
    const Eigen::AlignedBox3d& box = boxes_[order_[i]];
    RigidBody& first = *bodies[order_[i]];
    for (size_t k = i + 1; k < order_.size(); ++k) {
      const Eigen::AlignedBox3d& other = boxes_[order_[k]];
      RigidBody& second = *bodies[order_[k]];
      if (other.min()[axis_] > box.max()[axis_]) break;
      if ((first.asleep && second.asleep) || !box.intersects(other)) continue;
      const bool owner = owns_pair(first, second);
      (owner ? first : second).near.push_back(owner ? &second : &first);
    }
  }
  for (RigidBody* body : bodies) std::ranges::sort(body->near, {}, &RigidBody::body_id);
}

}  // namespace livegs
