// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of a `cells` body with rigid bodies and balls: surface points of the body against the rigid
// surface, and contact points of the rigid body against the surface of this one, which detects corners, rods
// and small balls between surface points.
#include <algorithm>
#include <cmath>

#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/cells/contact_margins.h"
#include "physics/elastic/rigid_proxy.h"
#include "physics/motion/body_id.h"

namespace livegs::cells {
namespace {

// Distance of the samples of a rigid body's normal cone, in spacings of its contact points.
constexpr double kNormalConeStep = 0.02;
// Maximum penetration (in particle edges) that is corrected on folded sheets. Elements of a folded surface
// are off by up to their spacing, so deeper overlaps there are usually false positives. They are prevented
// from growing but not pushed out; otherwise a sheet gains energy.
constexpr double kMaxFoldedPenetration = 0.15;

// Normal cone of a rigid body's surface at one of its points: gradients at distance `step_m` along axes and
// diagonals. At an edge these include the normals of both faces and directions in between.
void sample_normal_cone(const RigidShape& shape, const Vector3d& point_m, double step_m, const Matrix3d& turn,
                        std::vector<SurfaceElement>& normal_cone) {
  normal_cone.clear();
  for (int k = 0; k < 27; ++k) {
    const Vector3d direction(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    if (direction.squaredNorm() == 0.0 || direction.squaredNorm() == 2.0) continue;
    const DistanceField::Sample found = shape.sample(point_m + step_m * direction.normalized());
    if (found.distance_m > 0.25 * step_m) normal_cone.push_back({Vector3d::Zero(), turn * found.gradient});
  }
}

}  // namespace

// Calls `visit(i)` for the surface cells within `margin_m` of a rigid body.
template <class Visit>
void CellsBody::visit_cells_near(const RigidProxy& body, double margin_m, const Visit& visit) const {
  const Pose body_from_world = body.before.inverse();
  const auto distance = [&](const Vector3d& point) {
    return body.shape->sample(body_from_world * point).distance_m;
  };
  if (distance(origin_m_ + ledger_.motion.centre_m) > 1.5 * reach_m_ + extent_.box_edge_m + margin_m) return;
  for (uint32_t i = 0; i < surface_.cells.size(); ++i) {
    const Ball ball = ball_around(surface_.cells[i]);
    if (distance(origin_m_ + ball.centre_m) <= ball.radius_m + margin_m) visit(i);
  }
}

bool CellsBody::may_touch_awake(const SubstepContext& context) const {
  for (const RigidProxy* body : context.bodies) {
    bool near = false;
    if (!body->asleep) {
      visit_cells_near(*body, context.duration_s * body->fastest_m_s() + kRowMargin * extent_.box_edge_m,
                       [&](uint32_t) { near = true; });
    }
    if (near) return true;
  }
  return false;
}

// As find_candidates, for rigid bodies: pairs that can touch before they approach by the margin, which is at
// least the motion of a tick at `speed_m_s`.
void CellsBody::find_rigid_candidates(const SubstepContext& context, double speed_m_s) {
  bodies_.rigid_candidates.clear();
  bodies_.rigid_margin_m = std::max(kCandidateRoom * lattice_.cell_width_m, speed_m_s / accuracy_.rate_hz);
  for (uint32_t k = 0; k < context.bodies.size(); ++k) {
    visit_cells_near(*context.bodies[k], bodies_.rigid_margin_m, [&](uint32_t cell) {
      bodies_.rigid_candidates.push_back({cell, k});
    });
  }
}

// Updates the contacts of rigid bodies that are near, and their candidates. Returns whether the contacts must
// be found again, by body.
std::vector<char> CellsBody::update_rigid_contacts(const SubstepPart& part, const SubstepContext& context) {
  bool valid = keep_contacts(bodies_.rigid, context.bodies);
  double motion_m = 0.0, fastest_m_s = 0.0;
  std::vector<char> stale;
  for (size_t k = 0; k < context.bodies.size(); ++k) {
    const RigidProxy& body = *context.bodies[k];
    RigidContacts& contacts = bodies_.rigid[k];
    const bool known =
        contacts.own_revision == bodies_.revision && contacts.shape_revision == body.shape->revision;
    valid = valid && known;
    // Motion that the last steps did not count, such as an impact between substeps or a reset.
    const double reach_m = body.shape->bounding_radius_m,
                 turned = body.before.orientation.angularDistance(contacts.last.orientation),
                 jump_m = (body.before.position_m - contacts.last.position_m).norm() + turned * reach_m;
    const double speed_m_s = (ledger_.motion.velocity_m_s() - body.velocity_m_s).norm() + node_speed_m_s() +
                             body.spin_rad_s.norm() * reach_m;
    contacts.motion_m = kMotionRoom * part.duration_s * speed_m_s + jump_m + bodies_.jump_m;
    motion_m = std::max(motion_m, contacts.motion_m);
    fastest_m_s = std::max(fastest_m_s, speed_m_s);
    contacts.margin_m -= contacts.motion_m;
    contacts.last = body.at_end();
    // The point of a ball is no material point: it moves over the surface as the ball rolls. With a normal
    // that lags, balls roll out of their pits.
    stale.push_back((body.shape->is_ball() && !contacts.points.empty()) || !(contacts.margin_m > 0.0) ||
                    !known);
  }
  bodies_.rigid_margin_m -= motion_m;
  if (!valid || bodies_.rigid_margin_m <= 0.0) find_rigid_candidates(context, fastest_m_s);
  return stale;
}

// Surface points of this body against rigid bodies.
void CellsBody::collide_surface_with_rigid(const SubstepContext& context,
                                           std::vector<ContactConstraint>& rows) {
  struct Frame {
    Matrix3d from_world_before, from_world;
    Vector3d before_m, at_m;
  };
  std::vector<Frame> frames;
  for (const RigidProxy* body : context.bodies) {
    const Pose &before = body->before, at = body->at_end();
    frames.push_back({before.orientation.toRotationMatrix().transpose(),
                      at.orientation.toRotationMatrix().transpose(), before.position_m - origin_m_,
                      at.position_m - origin_m_});
  }
  for (Candidate& candidate : bodies_.rigid_candidates) {
    candidate.apart_m -= bodies_.rigid[candidate.collider].motion_m;
    if (candidate.apart_m > 0.0) continue;
    candidate.apart_m = INFINITY;
    RigidProxy& body = *context.bodies[candidate.collider];
    const Frame& frame = frames[candidate.collider];
    const SurfaceCell& cell = surface_.cells[candidate.cell];
    for (uint32_t i = cell.begin; i < cell.end; ++i) {
      NodeSample sample = surface_.points[i];
      Vector3d point = nodes_.corrected_m(sample);
      const auto gap = [&] {
        return swept_gap(*body.shape, frame.from_world_before * (nodes_.position_m(sample) - frame.before_m),
                         frame.from_world * (point - frame.at_m));
      };
      DistanceField::Sample found = gap();
      const double patch_depth = patch_depth_m(i);
      if (patch_depth > 0.0 && found.distance_m < patch_depth) {
        sample = touching_sample(i, frame.from_world.transpose() * found.gradient);
        point = nodes_.corrected_m(sample);
        found = gap();
      }
      candidate.apart_m = std::min(candidate.apart_m, found.distance_m - kRowMargin * extent_.box_edge_m);
      if (found.distance_m > kRowMargin * extent_.box_edge_m) continue;
      ContactConstraint row;
      row.a = participant_.get();
      row.b = row.rigid = &body;
      row.anchor_a.sample = sample;
      row.point_m = origin_m_ + point;
      row.anchor_b = body.anchor_at(row.point_m);
      row.normal = frame.from_world.transpose() * found.gradient;
      row.gap_m = found.distance_m;
      row.friction =
          mixed_friction(friction_at(i), body.friction_at(frame.from_world * (point - frame.at_m)));
      row.body_id = body_id_of(object_id_);
      row.other_body_id = body.body_id;
      row.point = i;
      start_from_last_force(row);
      rows.push_back(row);
    }
  }
}

// Contact points of a rigid body against this body's surface; for a ball the deepest point.
void CellsBody::find_rigid_contacts(RigidProxy& body, RigidContacts& contacts) {
  contacts.points.clear();
  contacts.margin_m = 0.5 * kElementReach * extent_.box_edge_m;
  contacts.own_revision = bodies_.revision;
  contacts.shape_revision = body.shape->revision;
  const double within_m = (kRowMargin + kCandidateMargin) * extent_.box_edge_m;
  const Pose at = body.at_end();
  const double reach = element_reach_m(), radius = body.shape->sphere_radius_m;
  const Vector3d room = Vector3d::Constant(reach + radius);
  const Vector3d own_displacement = body.step_s * ledger_.motion.velocity_m_s();
  struct Point {
    Vector3d at_m, displacement_m, local_m;
  };
  std::vector<Point> points;
  if (!surface_.boxes_known) list_boxes();
  const Matrix3d turn = at.orientation.toRotationMatrix(),
                 turn_before = body.before.orientation.toRotationMatrix();
  AlignedBox3d box;
  const auto offer = [&](const Vector3d& local) {
    const Vector3d point = at.position_m + turn * local;
    const Vector3d displacement = point - body.before.position_m - turn_before * local - own_displacement;
    AlignedBox3d passed(point);
    passed.extend(Vector3d(point - displacement));
    if (!surface_.box.intersects(AlignedBox3d(passed.min() - room, passed.max() + room))) return;
    points.push_back({point, displacement, local});
    box.extend(point);
  };
  if (body.shape->is_ball()) offer(Vector3d::Zero());
  for (const Vector3d& point : body.shape->contact_points_m) offer(point);
  std::vector<SurfaceElement> elements;
  if (!points.empty()) surface_elements(AlignedBox3d(box.min() - room, box.max() + room), elements);
  if (elements.empty()) return;
  const PointSurface grid(elements, reach + radius);
  std::vector<SurfaceElement> normal_cone;
  for (const auto& [point, displacement, local] : points) {
    auto depth = grid.swept_depth(point, displacement);
    if (!depth) continue;
    const double gap_m = depth->distance_m - radius;
    contacts.margin_m = std::min(contacts.margin_m, std::max(gap_m - kRowMargin * extent_.box_edge_m,
                                                             kCandidateMargin * extent_.box_edge_m));
    if (gap_m > within_m) continue;
    // Without the normal cone, a corner nearer to the far side of a sheet would be pushed through it.
    if (folds_on(body)) {
      sample_normal_cone(*body.shape, local, kNormalConeStep * body.shape->contact_spacing_m, turn,
                         normal_cone);
      depth = grid.swept_depth(point, displacement, normal_cone);
      if (!depth) continue;
    }
    const ContactAnchor anchor = anchor_at(depth->element, point - depth->distance_m * depth->normal);
    const double offset_m = depth->distance_m - depth->normal.dot(point - place_now_m(anchor.sample));
    contacts.points.push_back({local, anchor.sample, depth->element, depth->normal, offset_m});
  }
}

// Thin bodies only: both sides of a sheet are within reach of a point, and the sheet can fold. On thick
// blocks, one-sided contact or remaining overlaps would keep piles awake.
bool CellsBody::folds_on(const RigidProxy& body) const {
  return !body.shape->is_ball() && size_m().minCoeff() < 2.0 * element_reach_m();
}

void CellsBody::collide_rigid_points(RigidProxy& body, const RigidContacts& contacts,
                                     std::vector<ContactConstraint>& rows) {
  const Pose at = body.at_end();
  const Matrix3d turn = at.orientation.toRotationMatrix();
  const double radius = body.shape->sphere_radius_m;
  const bool folds = folds_on(body);
  for (const RigidContacts::Point& touch : contacts.points) {
    const Vector3d point = at.position_m + turn * touch.local_m;
    const double gap = touch.normal.dot(point - place_now_m(touch.own)) + touch.offset_m - radius;
    if (gap > kRowMargin * extent_.box_edge_m) continue;
    ContactConstraint row;
    if (folds)
      row.max_separation_m_s *=
          std::clamp(1.0 + gap / (kMaxFoldedPenetration * extent_.box_edge_m), 0.0, 1.0);
    row.a = participant_.get();
    row.b = row.rigid = &body;
    row.point_m = point - radius * touch.normal;
    row.anchor_a.sample = touch.own;
    row.anchor_b = body.anchor_at(row.point_m);
    row.normal = -touch.normal;
    row.gap_m = gap;
    row.friction = mixed_friction(friction_at(touch.element), body.friction_at(touch.local_m));
    row.body_id = body_id_of(object_id_);
    row.other_body_id = body.body_id;
    rows.push_back(row);
  }
}

}  // namespace livegs::cells
