// SPDX-License-Identifier: GPL-3.0-or-later
// Coupling of elastic and rigid bodies: neighbour search, impulse exchange, and common sleep islands.
#include <algorithm>
#include <cmath>
#include <span>

#include "core/disjoint_sets.h"
#include "core/parallel_for.h"
#include "physics/motion/free_rotation.h"
#include "physics/motion/vector_algebra.h"
#include "physics/rigid/rigid_sleep.h"
#include "physics/world/world_state.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// Limit of a rigid body's predicted velocity change per substep, in multiples of gravity. The prediction is
// right at rest and wrong directly after an impact.
constexpr double kMaxPredictedGravities = 2.0;
// Margin of the neighbour search, relative to an elastic body's radius, beyond the motion in a substep.
constexpr double kReachMargin = 0.1;

// An elastic body and another elastic or rigid body, by index.
struct NearPair {
  uint32_t elastic = 0, other = 0;
  bool rigid = false;  // the other one
  // Largest distance of the surfaces; of a rigid one, from the centre of the elastic body.
  double room_m = 0.0;
  bool near = false;
};

Eigen::AlignedBox3d box_of(const RigidShape& shape, const Pose& at) {
  const ShapeBox box = turned_box(shape, at.orientation.toRotationMatrix(), at.position_m);
  return {box.middle_m - box.half_m, box.middle_m + box.half_m};
}

Eigen::AlignedBox3d wider(const Eigen::AlignedBox3d& box, double by_m) {
  return {box.min().array() - by_m, box.max().array() + by_m};
}

// Whether surfaces may come within `room_m` of each other, tested with the boxes of their parts.
bool may_meet(const ElasticBody& a, const ElasticBody& b, const Eigen::AlignedBox3d& bounds_of_b,
              double room_m) {
  const Eigen::AlignedBox3d of_a = a.surface_bounds_m(wider(bounds_of_b, room_m));
  if (of_a.isEmpty()) return false;
  const Eigen::AlignedBox3d of_b = b.surface_bounds_m(wider(of_a, room_m));
  return !of_b.isEmpty() && !a.surface_bounds_m(wider(of_b, room_m)).isEmpty();
}

double distance_m(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  return (a.min() - b.max()).cwiseMax(b.min() - a.max()).cwiseMax(0.0).norm();
}

}  // namespace

std::vector<std::vector<World::State::CoupledBodies>> World::State::build_elastic_groups(double duration_s) {
  if (elastic_objects.empty()) return {};
  const double gain_m_s = duration_s * settings.gravity_m_s2.norm();
  for (size_t i = 0; i < rigid_bodies.size(); ++i) {
    const RigidBody& body = *rigid_bodies[i];
    RigidProxy& copy = rigid_proxies[i];
    copy = RigidProxy{};
    copy.body_id = body.body_id();
    copy.shape = &body.shape;
    copy.start = copy.before = body.world_from_body;
    copy.velocity_m_s = body.velocity_m_s;
    copy.spin_rad_s = body.angular_velocity_rad_s;
    copy.inverse_mass = 1.0 / body.mass_kg;
    copy.inverse_inertia = rotated_tensor(body.world_from_body.orientation, body.inverse_inertia_body());
    copy.friction = &body.friction;
    copy.rest_centre_m = body.rest_centre_m;
    copy.asleep = body.asleep;
    if (body.asleep) continue;
    const double limit = kMaxPredictedGravities * gain_m_s;
    copy.predicted_change_m_s = clamp_norm(velocity_changes[i].velocity_m_s, limit);
    copy.predicted_change_rad_s =
        clamp_norm(velocity_changes[i].spin_rad_s, limit / body.shape.bounding_radius_m);
  }

  const size_t count = elastic_objects.size();
  std::vector<Eigen::AlignedBox3d> elastic_boxes, rigid_boxes;
  for (ElasticObject* elastic : elastic_objects) {
    elastic_boxes.push_back(elastic->body->bounds_m());
    elastic->near_bodies.clear();
    elastic->near_elastic.clear();
  }
  for (const RigidProxy& body : rigid_proxies) rigid_boxes.push_back(box_of(*body.shape, body.start));
  DisjointSets sets(count + rigid_bodies.size()), together(count);
  // Pairs whose boxes are near, by elastic body; whether their surfaces are is decided on several threads. A
  // frozen body counts with its reach, also if another pair makes it elastic in this substep.
  std::vector<NearPair> pairs;
  for (uint32_t i = 0; i < count; ++i) {
    ElasticObject& elastic = *elastic_objects[i];
    const ElasticBody& body = *elastic.body;
    const Vector3d centre = body.centre_m();
    const bool asleep = body.asleep();
    const double own_reach = (1.0 + kReachMargin) * body.reach_m() + body.element_reach_m() +
                             duration_s * (body.velocity_m_s().norm() + gain_m_s);
    if (elastic.stepped || !(body.reach_m() > 0.0)) continue;
    for (uint32_t k = 0; k < rigid_bodies.size(); ++k) {
      const RigidProxy& other = rigid_proxies[k];
      if (asleep && other.asleep) continue;
      const double reach = own_reach + duration_s * other.fastest_m_s();
      const double apart = reach + other.shape->bounding_radius_m;
      if ((centre - other.start.position_m).squaredNorm() > apart * apart) continue;
      if (distance_m(elastic_boxes[i], rigid_boxes[k]) > reach - body.reach_m()) continue;
      pairs.push_back({i, k, true, reach});
    }
    for (uint32_t k = i + 1; k < count; ++k) {
      const ElasticObject& other = *elastic_objects[k];
      const bool other_asleep = other.body->asleep();
      if (other.stepped || (asleep && other_asleep) || !(other.body->reach_m() > 0.0)) continue;
      const double reach = own_reach + (1.0 + kReachMargin) * other.body->reach_m() +
                           other.body->element_reach_m() +
                           duration_s * (other.body->velocity_m_s().norm() + gain_m_s);
      if ((other.body->centre_m() - centre).squaredNorm() > reach * reach) continue;
      const double room = reach - body.reach_m() - other.body->reach_m();
      if (distance_m(elastic_boxes[i], elastic_boxes[k]) > room) continue;
      pairs.push_back({i, k, false, room});
    }
  }
  std::vector<char> has_pair(count, 0);
  for (const NearPair& pair : pairs)
    has_pair[pair.elastic] = has_pair[pair.rigid ? pair.elastic : pair.other] = 1;
  parallel_for(count, 4 /* a thread */, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (has_pair[i]) elastic_objects[i]->body->prepare_bounds();
    }
  });
  parallel_for(pairs.size(), 32 /* a thread */, [&](size_t begin, size_t end) {
    for (NearPair& pair : std::span(pairs).subspan(begin, end - begin)) {
      const ElasticBody& body = *elastic_objects[pair.elastic]->body;
      if (!pair.rigid) {
        pair.near =
            may_meet(body, *elastic_objects[pair.other]->body, elastic_boxes[pair.other], pair.room_m);
        continue;
      }
      const RigidProxy& other = rigid_proxies[pair.other];
      const double room = pair.room_m - body.reach_m();
      if (body.surface_bounds_m(wider(rigid_boxes[pair.other], room)).isEmpty()) continue;
      const Vector3d between = body.centre_m() - other.start.position_m;
      pair.near =
          other.shape->sample(other.start.orientation.conjugate() * between).distance_m <= pair.room_m;
    }
  });
  for (const NearPair& pair : pairs) {
    if (!pair.near) continue;
    ElasticObject& elastic = *elastic_objects[pair.elastic];
    if (pair.rigid) {
      elastic.near_bodies.push_back(&rigid_proxies[pair.other]);
      sets.join(pair.elastic, static_cast<uint32_t>(count) + pair.other);
      continue;
    }
    ElasticObject& other = *elastic_objects[pair.other];
    elastic.body->prepare_for_contact();
    other.body->prepare_for_contact();
    elastic.near_elastic.push_back({other.body.get(), body_id_of(other.object_id)});
    other.near_elastic.push_back({elastic.body.get(), body_id_of(elastic.object_id)});
    together.join(pair.elastic, pair.other);
    sets.join(pair.elastic, pair.other);
  }
  std::vector<CoupledBodies> stepped(count);
  for (uint32_t i = 0; i < count; ++i) {
    if (!elastic_objects[i]->stepped) stepped[together.find(i)].push_back(elastic_objects[i]);
  }
  std::vector<std::vector<CoupledBodies>> groups(count);
  for (uint32_t i = 0; i < count; ++i) {
    if (!stepped[i].empty()) groups[sets.find(i)].push_back(std::move(stepped[i]));
  }
  std::erase_if(groups, [](const auto& group) { return group.empty(); });
  return groups;
}

// Applies the impulses of elastic bodies to rigid ones. The part that balances the predicted change by
// gravity and rigid contacts is spread over the substep; the rest acts at its start.
void World::State::apply_elastic_impulses(double duration_s) {
  if (elastic_objects.empty()) return;
  for (size_t i = 0; i < rigid_bodies.size(); ++i) {
    const RigidProxy& copy = rigid_proxies[i];
    const double size = copy.contact_impulse_n_s;
    if (size == 0.0) continue;
    RigidBody& body = *rigid_bodies[i];
    if (body.asleep) body.wake();
    body.in_elastic_contact = true;
    const Vector3d balance = -body.mass_kg * copy.predicted_change_m_s;
    const double whole = balance.squaredNorm();
    const double part = whole > 0.0 ? std::clamp(balance.dot(copy.impulse_n_s) / whole, 0.0, 1.0) : 0.0;
    const Vector3d impact = copy.impulse_n_s - part * balance;
    loads[i].impulse_n_s += part * balance;
    loads[i].implicit_impulse_n_s += impact;
    loads[i].angular_impulse += copy.angular_impulse;
    body.contact_impulse_n_s += size;
    body.external_contact_impulse_n_s += size;
    body.external_contact_moment += copy.contact_moment;
    const double struck = impact.norm();
    // Corrects the pose to that of the proxy: later impulses in the substep displaced it less. Balancing
    // impulses are evenly distributed.
    const double steps = copy.step_impulse_n_s / size, even = 0.5 * (steps - 1.0) / steps * duration_s;
    body.world_from_body.position_m += even * part / body.mass_kg * balance - copy.position_lag_m;
    const double turned = struck / std::max(copy.impulse_n_s.norm(), struck);
    body.world_from_body.orientation =
        (rotation_exp(-turned * copy.orientation_lag_rad) * body.world_from_body.orientation).normalized();
    body.update_turning();
    // Soft contact lasts long, so it counts as a sustained force.
    body.record_force(copy.impulse_n_s, copy.contact_moment / size - body.world_from_body.position_m);
  }
}

// Wakes a sleeping body if `awake` (a member of its island is awake). Returns whether the body is awake now;
// false for unknown ids.
bool World::State::wake_body(uint64_t body_id, bool awake) {
  if (const size_t index = rigid_index(body_id); index < rigid_bodies.size()) {
    RigidBody& body = *rigid_bodies[index];
    if (awake && body.asleep) body.wake();
    return !body.asleep;
  }
  WorldObject* object = find(object_of_body(body_id));
  if (!object || !object->elastic()) return false;
  if (awake && object->asleep()) object->wake();
  return !object->asleep();
}

// Wakes bodies in contact with awake ones.
void World::State::wake_islands() {
  if (elastic_objects.empty()) return;
  bool again = true;
  while (again) {
    again = false;
    for (ElasticObject* elastic : elastic_objects) {
      for (const uint64_t id : elastic->contacts_last_tick) {
        const bool awake = !elastic->body->asleep(), other_awake = wake_body(id, false);
        if (!awake && other_awake) elastic->body->wake();
        if (awake && !other_awake) again = wake_body(id, true) || again;
        again = again || (!awake && other_awake);
      }
    }
  }
  for (RigidBody* body : rigid_bodies) body->in_elastic_contact = false;
}

// Puts bodies that pushed each other in this tick to sleep together: rigid bodies once every elastic one can
// sleep, then the elastic ones.
void World::State::sleep_islands(double tick_s) {
  if (!settings.sleep) {
    for (ElasticObject* elastic : elastic_objects) elastic->contacts_this_tick.clear();
    return;
  }
  if (elastic_objects.empty()) {
    update_sleep(rigid_bodies, tick_s, broad_phase);
    return;
  }
  std::vector<uint64_t> ids;
  for (const RigidBody* body : rigid_bodies) ids.push_back(body->body_id());
  for (const ElasticObject* elastic : elastic_objects) ids.push_back(body_id_of(elastic->object_id));
  std::ranges::sort(ids);
  const auto place_of = [&](uint64_t id) { return std::ranges::lower_bound(ids, id) - ids.begin(); };
  DisjointSets sets(ids.size());
  for (ElasticObject* elastic : elastic_objects) {
    if (!elastic->body->asleep()) {
      std::vector<uint64_t>& contacts = elastic->contacts_this_tick;
      std::ranges::sort(contacts);
      contacts.erase(std::ranges::unique(contacts).begin(), contacts.end());
      elastic->contacts_last_tick.swap(contacts);
    }
    elastic->contacts_this_tick.clear();
    const auto own = place_of(body_id_of(elastic->object_id));
    for (const uint64_t id : elastic->contacts_last_tick) {
      const auto other = place_of(id);
      if (other < std::ssize(ids) && ids[other] == id)
        sets.join(static_cast<uint32_t>(own), static_cast<uint32_t>(other));
    }
  }
  const auto root_of = [&](uint64_t id) { return sets.find(static_cast<uint32_t>(place_of(id))); };
  std::vector<char> is_awake(ids.size(), 0), in_island(ids.size(), 0);
  for (const ElasticObject* elastic : elastic_objects) {
    if (!elastic->body->can_sleep()) is_awake[root_of(body_id_of(elastic->object_id))] = 1;
  }
  for (uint32_t i = 0; i < ids.size(); ++i) {
    if (sets.find(i) != i) in_island[sets.find(i)] = 1;
  }
  for (RigidBody* body : rigid_bodies) body->island_awake = is_awake[root_of(body->body_id())] != 0;
  update_sleep(rigid_bodies, tick_s, broad_phase);
  for (const RigidBody* body : rigid_bodies) {
    if (!body->asleep) is_awake[root_of(body->body_id())] = 1;
  }
  for (ElasticObject* elastic : elastic_objects) {
    const uint32_t root = root_of(body_id_of(elastic->object_id));
    elastic->body->defer_sleep(in_island[root] != 0);
    if (in_island[root] && !is_awake[root] && !elastic->body->asleep()) elastic->body->sleep();
  }
}

}  // namespace livegs
