// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of a `cells` body with moving bodies: what contacts with rigid and with elastic bodies share, and
// contacts with elastic bodies, of which each contributes its own points. After the sweep.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/cells/contact_margins.h"
#include "physics/elastic/rigid_proxy.h"
#include "physics/motion/body_id.h"

namespace livegs::cells {
namespace {

// Maximum local coordinate of an anchor; it may lie slightly beyond its cell.
constexpr double kMaxAnchorLocal = 1.25;

Vector3d vector_of(NodeLanes v) { return {v[0], v[1], v[2]}; }

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
    if (!body_.free() && body_.mobility(anchor.sample) == 0.0) nodes.pulls.fill(0.0f);
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
    const NodeLanes room = 1e-5f * (high - low);  // for rounding
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

double CellsBody::node_speed_m_s() const {
  const double of_nodes = reach_m_ * step_.spin_rad_s + kNodeDeviations * step_.deviation_m_s;
  if (!holding_.moved) return of_nodes;
  return std::max(of_nodes, step_.driven_m_s + ledger_.motion.velocity_m_s().norm());
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

// Surface points of this body against another elastic body, within the margin of relative motion.
void CellsBody::find_elastic_contacts(CellsBody& other, double h, ElasticContacts& contacts) {
  const double edge_m = std::min(extent_.box_edge_m, other.extent_.box_edge_m);
  contacts.margin_m = 0.5 * kElementReach * edge_m;
  contacts.own_revision = bodies_.revision;
  contacts.other_revision = other.bodies_.revision;
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

void CellsBody::collide_surface_with_elastic(CellsBody& other, double h, ElasticContacts& contacts,
                                             std::vector<ContactConstraint>& rows) {
  const Vector3d relative_m_s = ledger_.motion.velocity_m_s() - other.ledger_.motion.velocity_m_s();
  const double speed_m_s = relative_m_s.norm() + node_speed_m_s() + other.node_speed_m_s();
  const double motion_m = kMotionRoom * h * speed_m_s + bodies_.jump_m + other.bodies_.jump_m;
  contacts.margin_m -= motion_m;
  if (contacts.margin_m <= 0.0 || contacts.own_revision != bodies_.revision ||
      contacts.other_revision != other.bodies_.revision) {
    find_elastic_contacts(other, h, contacts);
  }
  const double max_separation_m_s = separation_limit_m_s(std::min(reach_m_, other.reach_m_));
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
    row.max_separation_m_s = max_separation_m_s;
    start_from_last_force(row);
    rows.push_back(row);
  }
}

void CellsBody::list_contacts(const SubstepPart& part, const SubstepContext& context,
                              std::vector<ContactConstraint>& rows) {
  // The motion of a body that is not near is not counted: its contacts are found again when it returns.
  keep_contacts(bodies_.elastic, context.others);
  const std::vector<char> stale = update_rigid_contacts(part, context);
  if (context.bodies.empty() && context.others.empty()) return;
  collide_surface_with_rigid(context, rows);
  for (size_t k = 0; k < stale.size(); ++k) {
    if (stale[k]) find_rigid_contacts(*context.bodies[k], bodies_.rigid[k]);
    collide_rigid_points(*context.bodies[k], bodies_.rigid[k], rows);
  }
  for (size_t k = 0; k < context.others.size(); ++k) {
    auto& other = static_cast<CellsBody&>(*context.others[k].body);  // of the same solver
    collide_surface_with_elastic(other, part.duration_s, bodies_.elastic[k], rows);
  }
}

}  // namespace livegs::cells
