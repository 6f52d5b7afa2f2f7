// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of a `cells` body with moving bodies: rigid bodies, balls and other elastic bodies. After the
// sweep, in both directions: surface points of this body against the other's surface, and contact points of a
// rigid body against this body's surface. The second direction detects corners, rods and small balls between
// surface points. Of two elastic bodies, each contributes its own points.
//
// Contacts of the second direction that lie within the hull of those of the first are redundant and left out:
// they have no degrees of freedom of their own, so that sweeps converge slowly with them.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/rigid_proxy.h"
#include "physics/motion/body_id.h"

namespace livegs {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Minimum margin of the candidate search, in cell widths, as for colliders.
constexpr double kCandidateRoom = 0.5;
// Relative motion, in particle edges, after which the contacts with a body are found again. Until then their
// material points and normals are kept.
constexpr double kCandidateMargin = 0.25;
// The same while nothing can touch: at most the distance in which every point of the other surface has an
// element within kElementReach.
constexpr double kApartMargin = 0.75;
// Maximum gap of a contact row, in particle edges. Open gaps are included because a neighbouring impulse can
// close them.
constexpr double kRowMargin = 0.02;
// Interaction range of a surface element, in particle edges.
constexpr double kElementReach = 1.5;
// Distance within which contacts surround another, in spacings of their points: 1.41 on a square grid.
constexpr double kSurroundingReach = 1.5;
// Distance of the samples of a rigid body's normal cone, in spacings of its contact points.
constexpr double kNormalConeStep = 0.02;
// Maximum penetration (in particle edges) that is corrected on folded sheets. Elements of a folded surface
// are off by up to their spacing, so deeper overlaps there are usually false positives. They are prevented
// from growing but not pushed out; otherwise a sheet gains energy.
constexpr double kMaxFoldedPenetration = 0.15;
// Maximum local coordinate of an anchor; it may lie slightly beyond its cell.
constexpr double kMaxAnchorLocal = 1.25;

// Motion that is counted for a step over that at the speeds at its start. Smaller: a body that speeds up is
// found late. What it still lacks is counted in the next step.
constexpr double kMotionRoom = 1.5;

// Rounding margin of a box, relative to its size.
constexpr float kBoxRoom = 1e-5f;

Vector3d vector_of(NodeLanes v) { return {v[0], v[1], v[2]}; }
Vector3d corner_sign(int c) { return {c & 1 ? 1.0 : -1.0, c & 2 ? 1.0 : -1.0, c & 4 ? 1.0 : -1.0}; }

uint64_t id_of(const RigidProxy* body) { return body->body_id; }
uint64_t id_of(const ElasticNeighbour& body) { return body.body_id; }

// Brings `contacts` into the order of `bodies`: those of other bodies go, new ones are empty. Returns whether
// they had it.
template <class Contacts, class Bodies>
bool keep_contacts(std::vector<Contacts>& contacts, const Bodies& bodies) {
  const auto same_id = [](const Contacts& one, const auto& body) { return one.body_id == id_of(body); };
  if (std::equal(contacts.begin(), contacts.end(), bodies.begin(), bodies.end(), same_id)) return true;
  std::vector<Contacts> kept(bodies.size());
  for (size_t k = 0; k < kept.size(); ++k) {
    const auto known = std::find_if(contacts.begin(), contacts.end(),
                                    [&](const Contacts& one) { return same_id(one, bodies[k]); });
    if (known != contacts.end()) kept[k] = std::move(*known);
    kept[k].body_id = id_of(bodies[k]);
  }
  contacts = std::move(kept);
  return false;
}

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

// Receives impulses during a step, or while the body sleeps.
class CellsBody::Participant final : public ContactParticipant {
 public:
  explicit Participant(CellsBody& body) : body_(body) {}
  double step_s = 0.0;  // h_e during a step

  Matrix3d response(const ContactAnchor& anchor) const override {
    return step_s * body_.mobility(anchor.sample) * Matrix3d::Identity();
  }
  Vector3d displacement_m(const ContactAnchor& anchor) const override {
    if (!body_.step_.in_step) return step_s * body_.velocity_of(anchor.sample);
    return body_.nodes_.displacement_m(anchor.sample);
  }
  AnchorNodes nodes_of(const ContactAnchor& anchor) const override {
    if (!body_.step_.in_step) return {};
    AnchorNodes nodes = body_.nodes_.anchor_nodes(anchor.sample, step_s);
    if (!body_.free() && body_.mobility(anchor.sample) == 0.0) std::fill_n(nodes.pulls, 8, 0.0f);
    return nodes;
  }
  void count_impulse(const Vector3d& point, const Vector3d& impulse) override {
    body_.ledger_.contact_impulse += impulse;
    body_.ledger_.contact_moment += (point - body_.origin_m_).cross(impulse);
  }
  // During a step, impulses go to the nodes of nodes_of.
  void apply_impulse(const ContactAnchor& anchor, const Vector3d& point, const Vector3d& impulse) override {
    body_.push_anchor(anchor, point, impulse);
  }
  void record_impulse(const ContactAnchor& anchor, const ContactImpulse& of) override {
    const Vector3d& impulse = of.impulse_n_s;
    body_.record_contact_impulse(of.point_m, impulse.norm());
    body_.record_push(of);
    body_.limiter_.work_j += impulse.dot(displacement_m(anchor)) / step_s;
    if (!body_.step_.in_step) return body_.settle_anchor(anchor, of.point_m, impulse);
    body_.bodies_.contacts.push_back({anchor.sample, impulse});
    body_.step_.touching = true;
  }

 private:
  CellsBody& body_;
};

Vector3d CellsBody::place_now_m(const NodeSample& sample) const {
  return origin_m_ + (step_.in_step ? nodes_.corrected_m(sample) : nodes_.position_m(sample));
}

Vector3d CellsBody::node_now(uint32_t node) const {
  return origin_m_ + (step_.in_step ? nodes_.corrected_m(node) : nodes_.position_m(node));
}

void CellsBody::list_boxes() const {
  surface_.boxes_known = true;
  surface_.box.setEmpty();
  surface_.cell_boxes.clear();
  for (const SurfaceCell& cell : surface_.cells) {
    const std::array<NodeLanes, 8> corners = nodes_.corners_m(cell.nodes, cell.points, step_.in_step);
    NodeLanes low = corners[0], high = corners[0];
    for (int k = 1; k < 8; ++k) {
      low = corners[k] < low ? corners[k] : low;
      high = corners[k] > high ? corners[k] : high;
    }
    const NodeLanes room = kBoxRoom * (high - low);
    surface_.cell_boxes.emplace_back(origin_m_ + vector_of(low - room), origin_m_ + vector_of(high + room));
    surface_.box.extend(surface_.cell_boxes.back());
  }
}

void CellsBody::prepare_bounds() {
  if (!surface_.boxes_known && !frozen()) list_boxes();
}

AlignedBox3d CellsBody::surface_bounds_m(const AlignedBox3d& within) const {
  if (frozen()) return ElasticBody::surface_bounds_m(within);
  if (!surface_.boxes_known) list_boxes();
  AlignedBox3d bounds;
  if (!surface_.box.intersects(within)) return bounds;
  for (const AlignedBox3d& box : surface_.cell_boxes) {
    if (box.intersects(within)) bounds.extend(box);
  }
  return bounds;
}

void CellsBody::surface_elements(const AlignedBox3d& within, std::vector<SurfaceElement>& elements) const {
  if (!surface_.boxes_known) list_boxes();
  if (!surface_.box.intersects(within)) return;
  for (size_t n = 0; n < surface_.cells.size(); ++n) {
    if (!surface_.cell_boxes[n].intersects(within)) continue;
    const SurfaceCell& cell = surface_.cells[n];
    NodeLanes corners[8];
    for (int c = 0; c < 8; ++c) corners[c] = nodes_.place_m(cell.nodes[c], step_.in_step);
    // Normals transform with the cofactors of the deformation gradient.
    Matrix3d f;
    for (int d = 0; d < 3; ++d) {
      NodeLanes edge{0, 0, 0, 0};
      for (int c = 0; c < 8; ++c) edge += c & 1 << d ? corners[c] : -corners[c];
      f.col(d) = vector_of(edge);
    }
    Matrix3d cofactors;
    cofactors << f.col(1).cross(f.col(2)), f.col(2).cross(f.col(0)), f.col(0).cross(f.col(1));
    const bool inside = within.contains(surface_.cell_boxes[n]);
    for (uint32_t i = cell.begin; i < cell.end; ++i) {
      NodeLanes place{0, 0, 0, 0};
      for (int c = 0; c < 8; ++c) place += surface_.points[i].weights[c] * corners[c];
      const Vector3d position = origin_m_ + vector_of(place);
      if (!inside && !within.contains(position)) continue;
      for (uint32_t k = surface_.face_begins[i]; k < surface_.face_begins[i + 1]; ++k) {
        const Vector3d normal = cofactors * surface_.face_normals[k].cast<double>();
        const double length = normal.norm();
        if (length > 0.0) elements.push_back({position, normal / length, 0.0, i});
      }
    }
  }
}

double CellsBody::element_reach_m() const { return kElementReach * extent_.box_edge_m; }

// Starts at the element's local coordinates and adds the offset, by the inverse of the cell's deformation.
ContactAnchor CellsBody::anchor_at(uint32_t element, const Vector3d& point_m) const {
  ContactAnchor anchor;
  anchor.sample = surface_.points[element];
  Vector3d position = Vector3d::Zero();
  Matrix3d f = Matrix3d::Zero();  // with respect to the local coordinates
  for (int c = 0; c < 8; ++c) {
    const Vector3d corner = node_now(anchor.sample.nodes[c]);
    position += anchor.sample.weights[c] * corner;
    f += 0.125 * corner * corner_sign(c).transpose();
  }
  const double half = 0.5 * lattice_.cell_width_m;
  if (!(f.determinant() > 0.01 * half * half * half)) return anchor;
  const Vector3d local = surface_.local[element].cast<double>();
  const Vector3d furthest = local.cwiseAbs().cwiseMax(kMaxAnchorLocal);
  const auto weights =
      trilinear_weights((local + f.inverse() * (point_m - position)).cwiseMin(furthest).cwiseMax(-furthest));
  for (int c = 0; c < 8; ++c) anchor.sample.weights[c] = static_cast<float>(weights[c]);
  return anchor;
}

void CellsBody::push_anchor(const ContactAnchor& anchor, const Vector3d& point_m,
                            const Vector3d& impulse_n_s) {
  if (asleep()) wake();
  for (int c = 0; c < 8; ++c) {
    const uint32_t node = anchor.sample.nodes[c];
    nodes_.change_velocities(node, anchor.sample.weights[c] * inverse_masses_[node] * impulse_n_s);
  }
  if (!free()) return;
  const Vector3d turn = (point_m - origin_m_ - ledger_.motion.centre_m).cross(impulse_n_s);
  ledger_.motion.momentum += impulse_n_s;
  ledger_.motion.angular_momentum += turn;
  ledger_.momentum_before += impulse_n_s;
  ledger_.angular_before += turn;
  ledger_.spin_correction +=
      solve_inertia(ledger_.motion.inertia, turn) - solve_inertia(ledger_.node_inertia, turn);
  ledger_.between_steps_impulse += impulse_n_s;
}

// Corrects for the offset between the point of the impulse (ledger) and the anchor (nodes).
void CellsBody::settle_anchor(const ContactAnchor& anchor, const Vector3d& point_m,
                              const Vector3d& impulse_n_s) {
  if (!free()) return;
  const Vector3d offset_m = point_m - origin_m_ - nodes_.position_m(anchor.sample);
  ledger_.spin_correction += solve_inertia(ledger_.motion.inertia, offset_m.cross(impulse_n_s));
}

void CellsBody::record_contact_impulse(const Vector3d& point_m, double impulse_n_s) {
  loads_.contact_n_s += impulse_n_s;
  loads_.contact_total.impulse_n_s += impulse_n_s;
  loads_.contact_total.moment += impulse_n_s * point_m;
}

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

double CellsBody::node_speed_m_s() const {
  const double of_nodes = reach_m_ * step_.spin_rad_s + 4.0 * step_.deviation_m_s;
  if (!holding_.moved) return of_nodes;
  return std::max(of_nodes, step_.driven_m_s + ledger_.motion.velocity_m_s().norm());
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
    valid =
        valid && contacts.own_revision == bodies_.revision && contacts.shape_revision == body.shape->revision;
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
                    contacts.own_revision != bodies_.revision ||
                    contacts.shape_revision != body.shape->revision);
  }
  bodies_.rigid_margin_m -= motion_m;
  if (!valid || bodies_.rigid_margin_m <= 0.0) find_rigid_candidates(context, fastest_m_s);
  return stale;
}

// Surface points of this body against rigid bodies. Those near a body with a place in `near` are listed there
// as well.
void CellsBody::collide_surface_with_rigid(ContactParticipant& participant, const SubstepContext& context,
                                           std::span<std::optional<NearSurface>> near,
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
    if (candidate.apart_m > 0.0 && !near[candidate.collider]) continue;
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
      if (std::optional<NearSurface>& here = near[candidate.collider];
          here && found.distance_m < (kRowMargin + kCandidateMargin) * extent_.box_edge_m) {
        here->points.push_back({origin_m_ + point, frame.from_world.transpose() * found.gradient, 0.0, i});
        here->gaps_m.push_back(found.distance_m);
      }
      candidate.apart_m = std::min(candidate.apart_m, found.distance_m - kRowMargin * extent_.box_edge_m);
      if (found.distance_m > kRowMargin * extent_.box_edge_m) continue;
      ContactConstraint row;
      row.a = &participant;
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

// Contact points of a rigid body against this body's surface; for a ball the deepest point. `surface` are
// this body's points near the rigid one, with their gaps.
void CellsBody::find_rigid_contacts(RigidProxy& body, const NearSurface& surface, RigidContacts& contacts) {
  contacts.points.clear();
  contacts.margin_m = kApartMargin * extent_.box_edge_m;
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
  const PointSurface first(surface.points, kSurroundingReach * extent_.box_edge_m);
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
    if (const auto around = first.surrounding(point - radius * depth->normal, -depth->normal)) {
      double lowest_m = INFINITY;
      for (const uint32_t k : *around) lowest_m = std::min(lowest_m, surface.gaps_m[k]);
      if (depth->distance_m - radius >= lowest_m - kRowMargin * extent_.box_edge_m) continue;
    }
    const ContactAnchor anchor = anchor_at(depth->element, point - depth->distance_m * depth->normal);
    const double offset_m = depth->distance_m - depth->normal.dot(point - place_now_m(anchor.sample));
    contacts.points.push_back({local, anchor.sample, depth->element, depth->normal, offset_m});
  }
}

// Thin bodies only: both sides of a sheet are within reach of a point, and the sheet can fold. On thick
// blocks, one-sided contact or remaining overlaps would keep piles awake.
bool CellsBody::folds_on(const RigidProxy& body) const {
  return !body.shape->is_ball() && (extent_.max_m - extent_.min_m).minCoeff() < 2.0 * element_reach_m();
}

void CellsBody::collide_rigid_points(RigidProxy& body, const RigidContacts& contacts,
                                     ContactParticipant& participant, std::vector<ContactConstraint>& rows) {
  const Pose at = body.at_end();
  const Matrix3d turn = at.orientation.toRotationMatrix();
  const double radius = body.shape->sphere_radius_m;
  const bool folds = folds_on(body);
  for (const RigidContacts::Point& touch : contacts.points) {
    const Vector3d point = at.position_m + turn * touch.local_m;
    const double gap = touch.normal.dot(point - place_now_m(touch.own)) + touch.offset_m - radius;
    if (gap > kRowMargin * extent_.box_edge_m) continue;
    ContactConstraint row;
    if (folds) row.push_m_s *= std::clamp(1.0 + gap / (kMaxFoldedPenetration * extent_.box_edge_m), 0.0, 1.0);
    row.a = &participant;
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

// The body with finer points lists its contacts first.
bool CellsBody::lists_first(const CellsBody& other) const {
  if (extent_.box_edge_m != other.extent_.box_edge_m) return extent_.box_edge_m < other.extent_.box_edge_m;
  return object_id_ < other.object_id_;
}

// Contacts with `other` in this step; null if there are none, as of a sleeping body.
const CellsBody::ElasticContacts* CellsBody::contacts_listed_with(const CellsBody& other) const {
  for (const ElasticContacts& contacts : bodies_.elastic) {
    if (contacts.body_id == body_id_of(other.object_id_))
      return contacts.listed_step == bodies_.step ? &contacts : nullptr;
  }
  return nullptr;
}

// Surface points of this body against another elastic body, within the margin of relative motion.
void CellsBody::find_elastic_contacts(CellsBody& other, double h, ElasticContacts& contacts) {
  const double edge_m = std::min(extent_.box_edge_m, other.extent_.box_edge_m);
  contacts.margin_m = kApartMargin * edge_m;
  contacts.own_revision = bodies_.revision;
  contacts.other_revision = other.bodies_.revision;
  ++contacts.finds;
  contacts.points.clear();
  const double reach = other.element_reach_m();
  const Vector3d displacement = h * (ledger_.motion.velocity_m_s() - other.velocity_m_s());
  const Vector3d room = Vector3d::Constant(reach) + displacement.cwiseAbs();
  if (!surface_.boxes_known) list_boxes();
  std::vector<SurfaceElement> elements;
  other.surface_elements(AlignedBox3d(surface_.box.min() - room, surface_.box.max() + room), elements);
  AlignedBox3d box;
  for (const SurfaceElement& element : elements) box.extend(element.position_m);
  std::vector<SurfaceElement> points;
  if (!elements.empty()) surface_elements(AlignedBox3d(box.min() - room, box.max() + room), points);
  if (points.empty()) return;
  const PointSurface grid(elements, reach);
  for (size_t k = 0, end = 0; k < points.size(); k = end) {
    for (end = k; end < points.size() && points[end].index == points[k].index; ++end) {  // one point's faces
    }
    const SurfaceElement& point = points[k];
    NodeSample sample = surface_.points[point.index];
    Vector3d position = point.position_m;
    auto depth = grid.swept_depth(position, displacement, {&point, end - k});
    const double patch_depth = patch_depth_m(point.index);
    if (depth && patch_depth > 0.0 && depth->distance_m < patch_depth) {
      sample = touching_sample(point.index, depth->normal);
      position = origin_m_ + nodes_.corrected_m(sample);
      depth = grid.swept_depth(position, displacement, {&point, end - k});
    }
    if (!depth) continue;
    const double apart_m = depth->distance_m - kRowMargin * extent_.box_edge_m;
    contacts.margin_m = std::min(contacts.margin_m, std::max(apart_m, kCandidateMargin * edge_m));
    if (apart_m > kCandidateMargin * edge_m) continue;
    const ContactAnchor anchor =
        other.anchor_at(depth->element, position - depth->distance_m * depth->normal);
    contacts.points.push_back({point.index, depth->element, sample, anchor.sample, depth->normal});
  }
}

// Removes contacts of this body within the hull of those of `other`. A point between four contacts of one
// face is as far from the surface as these, unless the face is curved or bent there.
void CellsBody::remove_redundant(const CellsBody& other, const ElasticContacts& first,
                                 ElasticContacts& contacts) const {
  std::vector<SurfaceElement> elements;
  for (const ElasticContacts::Point& touch : first.points)
    elements.push_back({other.place_now_m(touch.own), touch.normal, 0.0, 0});
  const PointSurface of_first(elements, kSurroundingReach * other.extent_.box_edge_m);
  const double room_m = kRowMargin * std::min(extent_.box_edge_m, other.extent_.box_edge_m);
  std::erase_if(contacts.points, [&](const ElasticContacts::Point& touch) {
    const Vector3d place = place_now_m(touch.own);
    const auto surrounding = of_first.surrounding(place, -touch.normal);
    if (!surrounding) return false;
    double lowest_m = INFINITY;
    for (const uint32_t k : *surrounding) {
      const ElasticContacts::Point& one = first.points[k];
      lowest_m = std::min(lowest_m, one.normal.dot(other.place_now_m(one.own) - place_now_m(one.other)));
    }
    const double gap_m = touch.normal.dot(place - other.place_now_m(touch.other));
    return gap_m >= lowest_m - room_m;
  });
}

void CellsBody::collide_surface_with_elastic(CellsBody& other, double h, ElasticContacts& contacts,
                                             std::vector<ContactConstraint>& rows) {
  const ElasticContacts* first = lists_first(other) ? nullptr : other.contacts_listed_with(*this);
  const Vector3d relative_m_s = ledger_.motion.velocity_m_s() - other.ledger_.motion.velocity_m_s();
  const double speed_m_s = relative_m_s.norm() + node_speed_m_s() + other.node_speed_m_s();
  const double motion_m = kMotionRoom * h * speed_m_s + bodies_.jump_m + other.bodies_.jump_m;
  contacts.margin_m -= motion_m;
  const int finds_of_first = first ? first->finds : 0;
  if (contacts.margin_m <= 0.0 || contacts.own_revision != bodies_.revision ||
      contacts.other_revision != other.bodies_.revision || contacts.other_finds != finds_of_first) {
    find_elastic_contacts(other, h, contacts);
    if (first) remove_redundant(other, *first, contacts);
    contacts.other_finds = finds_of_first;
  }
  for (ElasticContacts::Point& touch : contacts.points) {
    touch.apart_m -= motion_m;
    if (touch.apart_m > 0.0) continue;
    const Vector3d position = origin_m_ + nodes_.corrected_m(touch.own);
    const double gap_m = touch.normal.dot(position - other.place_now_m(touch.other));
    touch.apart_m = gap_m - kRowMargin * extent_.box_edge_m;
    if (touch.apart_m > 0.0) continue;
    ContactConstraint row;
    row.a = participant_.get();
    row.b = other.participant_.get();
    row.anchor_a.sample = touch.own;
    row.point_m = position;
    row.anchor_b.sample = touch.other;
    row.normal = touch.normal;
    row.gap_m = gap_m;
    row.friction = mixed_friction(friction_at(touch.point), other.friction_at(touch.other_point));
    row.body_id = body_id_of(object_id_);
    row.other_body_id = contacts.body_id;
    row.point = touch.point;
    start_from_last_force(row);
    rows.push_back(row);
  }
}

void CellsBody::prepare_contact_step(double step_s) {
  if (!participant_) participant_ = std::make_unique<Participant>(*this);
  static_cast<Participant&>(*participant_).step_s = step_.in_step ? step_of(step_s) : step_s;
  prepare_bounds();
  const Vector3d velocity_m_s = ledger_.motion.velocity_m_s();
  const double node_speed = node_speed_m_s();
  bodies_.jump_m = bodies_.step_s * ((velocity_m_s - bodies_.velocity_m_s).norm() +
                                     std::max(0.0, node_speed - bodies_.node_speed_m_s));
  bodies_.velocity_m_s = velocity_m_s;
  bodies_.node_speed_m_s = node_speed;
  ++bodies_.step;
  bodies_.step_s = step_s;
}

void CellsBody::start_from_last_force(ContactConstraint& row) const {
  if (bodies_.last_forces.empty() || without(Mechanism::ContactWarmStart)) return;
  const LastForce& last = bodies_.last_forces[row.point];
  if (last.step + 1 != bodies_.step || last.body_id != row.other_body_id) return;
  row.normal_impulse_n_s = bodies_.step_s * last.normal_n;
  row.friction_impulse_n_s = bodies_.step_s * last.friction_n.cast<double>();
}

void CellsBody::list_contacts(const SubstepPart& part, const SubstepContext& context,
                              std::vector<ContactConstraint>& rows) {
  // The motion of a body that is not near is not counted: its contacts are found again when it returns.
  keep_contacts(bodies_.elastic, context.others);
  const std::vector<char> stale = update_rigid_contacts(part, context);
  if (context.bodies.empty() && context.others.empty()) return;
  ContactParticipant& participant = contact_participant();
  std::vector<std::optional<NearSurface>> near(stale.size());
  for (size_t k = 0; k < near.size(); ++k) {
    if (stale[k]) near[k].emplace();
  }
  collide_surface_with_rigid(participant, context, near, rows);
  for (size_t k = 0; k < near.size(); ++k) {
    if (near[k]) find_rigid_contacts(*context.bodies[k], *near[k], bodies_.rigid[k]);
    collide_rigid_points(*context.bodies[k], bodies_.rigid[k], participant, rows);
  }
  list_pairs(true, part.duration_s, context, rows);
}

void CellsBody::list_other_contacts(const SubstepPart& part, const SubstepContext& context,
                                    std::vector<ContactConstraint>& rows) {
  list_pairs(false, part.duration_s, context, rows);
}

// Contacts with the elastic bodies before which this one lists them, or after which.
void CellsBody::list_pairs(bool first, double h, const SubstepContext& context,
                           std::vector<ContactConstraint>& rows) {
  for (size_t k = 0; k < context.others.size(); ++k) {
    auto& other = static_cast<CellsBody&>(*context.others[k].body);  // of the same solver
    if (lists_first(other) != first) continue;
    collide_surface_with_elastic(other, h, bodies_.elastic[k], rows);
    bodies_.elastic[k].listed_step = bodies_.step;
  }
}

}  // namespace livegs
