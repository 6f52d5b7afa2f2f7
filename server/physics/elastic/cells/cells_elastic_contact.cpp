// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of a `cells` body with other elastic bodies. Each contributes its own points; the body with finer
// points lists first, and contacts of the other within the hull of the first are left out.
#include <algorithm>
#include <cmath>

#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/cells/contact_margins.h"
#include "physics/motion/body_id.h"

namespace livegs {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

}  // namespace

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
