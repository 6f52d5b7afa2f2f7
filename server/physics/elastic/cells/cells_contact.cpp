// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of the body's surface points with colliders, after the elastic sweep: one Gauss-Seidel pass.
// Forward and backward passes alternate, because a fixed order causes a sideways drift.
#include <algorithm>
#include <cmath>

#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/cells/contact_margins.h"
#include "physics/elastic/contact_constraints.h"

namespace livegs::cells {
namespace {

// Minimum mobility of a point of a partly held body, relative to the mobility without held nodes. Below it
// the mobility is 0: the few free nodes would move many times as far as the point, or by rounding only.
constexpr double kMinMobilityRatio = 1e-2;

}  // namespace

// Bounding sphere of the cell's points at the start of the step.
CellsBody::Ball CellsBody::ball_around(const SurfaceCell& cell) const {
  const std::array<NodeLanes, 8> corners = nodes_.corners_m(cell.nodes, cell.points, false);
  NodeLanes centre = corners[0];
  for (int k = 1; k < 8; ++k) centre += corners[k];
  centre *= 0.125f;
  float squared = 0.0f;
  for (const NodeLanes corner : corners) {
    const NodeLanes arm = corner - centre;
    squared = std::max(squared, arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]);
  }
  return {{centre[0], centre[1], centre[2]}, std::sqrt(squared)};
}

// Pairs of surface cells and colliders that can touch before a node moves by the margin.
void CellsBody::find_candidates(const SubstepContext& context) {
  const double speed = ledger_.motion.velocity_m_s().norm() + node_speed_m_s() +
                       context.gravity_m_s2.norm() / accuracy_.rate_hz;
  const double margin = std::max(kCandidateRoom * lattice_.cell_width_m, speed / accuracy_.rate_hz);
  colliders_.margin_m = margin;
  colliders_.count = context.colliders.size();
  colliders_.candidates.clear();
  std::vector<uint32_t> near;
  for (uint32_t k = 0; k < context.colliders.size(); ++k) {
    if (reaches(context.colliders[k], origin_m_ + ledger_.motion.centre_m,
                1.5 * reach_m_ + extent_.box_edge_m + margin)) {
      near.push_back(k);
    }
  }
  if (near.empty()) return;
  for (uint32_t i = 0; i < surface_.cells.size(); ++i) {
    const Ball ball = ball_around(surface_.cells[i]);
    for (const uint32_t k : near) {
      if (reaches(context.colliders[k], origin_m_ + ball.centre_m, ball.radius_m + margin))
        colliders_.candidates.push_back({i, k});
    }
  }
}

void CellsBody::resolve_colliders(double step_s, const SubstepContext& context) {
  // Bound of a node's motion in this step, and of the corners of its cell.
  colliders_.margin_m -= kMotionRoom * step_s * (ledger_.motion.velocity_m_s().norm() + node_speed_m_s());
  if (colliders_.margin_m <= 0.0 || colliders_.count != context.colliders.size()) find_candidates(context);

  if (colliders_.candidates.empty()) return;
  const size_t first_contact = colliders_.contacts.size();
  const std::vector<ColliderProbe> probes(context.colliders.begin(), context.colliders.end());
  const auto resolve = [&](const ColliderProbe& collider, uint32_t i) {
    NodeSample sample = surface_.points[i];
    Vector3d point = nodes_.corrected_m(sample), from = nodes_.position_m(sample);
    SurfaceSample surface = swept_surface(collider, origin_m_ + from, origin_m_ + point);
    const double patch_depth = patch_depth_m(i);
    double w = surface_.mobility[i];
    if (patch_depth > 0.0 && surface.distance_m < patch_depth) {
      sample = touching_sample(i, surface.normal);
      w = mobility(sample);
      point = nodes_.corrected_m(sample);
      from = nodes_.position_m(sample);
      surface = swept_surface(collider, origin_m_ + from, origin_m_ + point);
    }
    if (surface.distance_m >= 0.0) return;
    step_.touching = true;
    const Vector3d moved = point - from;
    const double gap_before = surface.distance_m - surface.normal.dot(moved);
    const double depth = std::min(0.0, gap_before + kMaxRigidSeparation_m_s * step_s) - surface.distance_m;
    if (depth <= 0.0 || w <= 0.0) return;
    const double friction = mixed_friction(friction_at(i), collider.collider().friction);
    const Vector3d pull_kg_m = contact_correction(surface.normal, depth, moved, friction) / w;
    apply_collider_contact(i, sample, point, pull_kg_m, step_s);
    const double size = pull_kg_m.norm() / step_s;
    record_contact_impulse(origin_m_ + point, size);
  };
  for (size_t n = 0; n < colliders_.candidates.size(); ++n) {
    const Candidate& candidate =
        colliders_.candidates[step_.backward ? colliders_.candidates.size() - 1 - n : n];
    const SurfaceCell& cell = surface_.cells[candidate.cell];
    const ColliderProbe& collider = probes[candidate.collider];
    const uint32_t count = cell.end - cell.begin;
    for (uint32_t i = 0; i < count; ++i) {
      resolve(collider, step_.backward ? cell.end - 1 - i : cell.begin + i);
    }
  }
  apply_rolling_resistance(first_contact, step_s);
}

double CellsBody::mobility(const NodeSample& sample) const {
  double sum = 0.0, unheld = 0.0;
  for (int c = 0; c < 8; ++c) sum += sample.weights[c] * sample.weights[c] * inverse_masses_[sample.nodes[c]];
  if (free()) return sum;
  for (int c = 0; c < 8; ++c) unheld += sample.weights[c] * sample.weights[c] / masses_kg_[sample.nodes[c]];
  return sum > kMinMobilityRatio * unheld ? sum : 0.0;
}

void CellsBody::apply_collider_contact(uint32_t index, const NodeSample& sample, const Vector3d& point_m,
                                       const Vector3d& pull_kg_m, double step_s) {
  const Vector3d impulse = pull_kg_m / step_s;
  nodes_.pull(sample, pull_kg_m);
  ledger_.contact_impulse += impulse;
  ledger_.contact_moment += point_m.cross(impulse);
  colliders_.contacts.push_back({index, sample, impulse});
}

}  // namespace livegs::cells
