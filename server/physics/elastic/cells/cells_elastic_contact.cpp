// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of a `cells` body with other elastic bodies. Each contributes its own points.
#include <algorithm>

#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/cells/contact_margins.h"
#include "physics/motion/body_id.h"

namespace livegs {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

}  // namespace

// Surface points of this body against another elastic body, within the margin of relative motion.
void CellsBody::find_elastic_contacts(CellsBody& other, double h, ElasticContacts& contacts) {
  const double edge_m = std::min(extent_.box_edge_m, other.extent_.box_edge_m);
  contacts.margin_m = kApartMargin * edge_m;
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

}  // namespace livegs
