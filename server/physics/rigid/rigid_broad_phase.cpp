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

// Enlargement of boxes. Larger: fewer updates, more pairs.
constexpr double kBoxMargin = 0.05;        // relative to the bounding radius
constexpr double kExpectedSubsteps = 8.0;  // substeps of motion at the current speed

// Box swept by the body in `time_s`, including rotation.
void body_box(const RigidBody& body, double margin_m, double time_s, double gravity_m_s2, Vector3d& low,
              Vector3d& high) {
  const double radius = body.shape.bounding_radius_m;
  Vector3d half = Vector3d::Constant(radius), middle = body.world_from_body.position_m;
  if (!body.shape.is_ball()) {
    const Eigen::Matrix3d rotation = body.world_from_body.orientation.toRotationMatrix();
    middle += rotation * (0.5 * (body.shape.min_m + body.shape.max_m));
    half = rotation.cwiseAbs() * (0.5 * (body.shape.max_m - body.shape.min_m));
  }
  const double turn = std::min(2.0, time_s * body.angular_velocity_rad_s.norm()) * radius;
  half.array() += margin_m + turn + 0.5 * gravity_m_s2 * time_s * time_s;
  const Vector3d displacement = time_s * body.velocity_m_s;
  low = middle - half + displacement.cwiseMin(0.0);
  high = middle + half + displacement.cwiseMax(0.0);
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
    Vector3d low, high;
    body_box(*bodies[i], kContactMargin * bodies[i]->shape.bounding_radius_m, duration_s, gravity_m_s2, low,
             high);
    good = (low.array() >= boxes_[i].low.array()).all() && (high.array() <= boxes_[i].high.array()).all();
  }
  if (good) return;
  known_ = true;
  if (boxes_.size() != bodies.size()) {
    order_.resize(bodies.size());
    std::iota(order_.begin(), order_.end(), 0u);
  }
  boxes_.resize(bodies.size());
  for (size_t i = 0; i < bodies.size(); ++i) {
    Box& box = boxes_[i];
    box.body = bodies[i];
    body_box(*box.body, kBoxMargin * box.body->shape.bounding_radius_m, kExpectedSubsteps * duration_s,
             gravity_m_s2, box.low, box.high);
  }
  find_pairs();
}

void RigidBroadPhase::find_pairs() {
  // Sorts along the axis of the largest variance.
  Vector3d mean = Vector3d::Zero(), square = Vector3d::Zero();
  for (const Box& box : boxes_) {
    const Vector3d middle = 0.5 * (box.low + box.high);
    mean += middle;
    square += middle.cwiseProduct(middle);
  }
  (square * static_cast<double>(boxes_.size()) - mean.cwiseProduct(mean)).maxCoeff(&axis_);
  std::sort(order_.begin(), order_.end(), [&](uint32_t a, uint32_t b) {
    const double low_a = boxes_[a].low[axis_], low_b = boxes_[b].low[axis_];
    return low_a != low_b ? low_a < low_b : a < b;
  });
  for (const Box& box : boxes_) box.body->near.clear();
  for (size_t i = 0; i < order_.size(); ++i) {
    const Box& first = boxes_[order_[i]];
    for (size_t k = i + 1; k < order_.size(); ++k) {
      const Box& second = boxes_[order_[k]];
      if (second.low[axis_] > first.high[axis_]) break;
      if (first.body->asleep && second.body->asleep) continue;
      if ((first.low.array() > second.high.array()).any() || (second.low.array() > first.high.array()).any())
        continue;
      if (owns_pair(*first.body, *second.body)) {
        first.body->near.push_back(second.body);
      } else {
        second.body->near.push_back(first.body);
      }
    }
  }
  for (const Box& box : boxes_) {
    std::sort(box.body->near.begin(), box.body->near.end(),
              [](const RigidBody* a, const RigidBody* b) { return a->body_id() < b->body_id(); });
  }
}

}  // namespace livegs
