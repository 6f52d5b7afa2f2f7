// SPDX-License-Identifier: GPL-3.0-or-later
// Springs of ray pulls and grabs. gather_springs() sets targets, stiffness and bounds; solvers compute the
// forces: rigid/rigid_spring.cpp, CellsBody::solve_springs(), or spring_force() here.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/check/check_values.h"
#include "physics/motion/vector_algebra.h"
#include "physics/world/world_state.h"

namespace livegs {
namespace {

// Radius of the palm, m: an elastic object is held at points within this distance of the hand.
constexpr double kPalmRadius_m = 0.05;
// Larger: a more even grip, more springs.
constexpr size_t kMaxGripPoints = 6;
constexpr double kHandTimeoutTicks = 3.0;  // after this many ticks without update the hand's velocity is zero

double squared(double value) { return value * value; }

// Farthest point sampling within the palm, starting with the particle nearest to the hand.
std::vector<GripPoint> grip_points_in_palm(const ElasticObject& elastic, const Pose& world_from_hand) {
  const std::vector<Eigen::Vector3d>& rest = elastic.rest_particles_m;
  const Pose hand_from_world = world_from_hand.inverse();
  std::vector<Eigen::Vector3d> seen;  // hand frame
  for (const Eigen::Vector3d& point : rest)
    seen.push_back(hand_from_world * elastic.body->world_point(point));
  // Distance to the nearest chosen point; before the first, minus the distance to the hand.
  std::vector<double> apart(seen.size());
  for (size_t i = 0; i < seen.size(); ++i) apart[i] = -seen[i].norm();
  std::vector<GripPoint> grip_points;
  while (grip_points.size() < kMaxGripPoints) {
    const auto next = static_cast<size_t>(std::ranges::max_element(apart) - apart.begin());
    if (!grip_points.empty() && apart[next] <= 0.0) break;
    grip_points.push_back({rest[next], seen[next]});
    for (size_t i = 0; i < seen.size(); ++i) {
      const double distance = (seen[i] - seen[next]).norm();
      const double before = seen[i].norm() <= kPalmRadius_m ? INFINITY : 0.0;
      apart[i] = std::min(grip_points.size() == 1 ? before : apart[i], distance);
    }
  }
  return grip_points;
}

// Signed distance from the surface to a point in the shape's frame, negative inside. Far from the surface a
// field returns the distance to the bounding box, too small for a curved fragment, so triangles are used
// there.
double surface_distance_m(const RigidShape& shape, const Eigen::Vector3d& local_m) {
  const double sampled_m = shape.sample(local_m).distance_m;
  if (sampled_m <= 0.0 || shape.is_ball() || shape.convex) return sampled_m;
  return triangle_distance_m(shape, local_m);
}

// Explicit spring force for solvers without implicit springs (ElasticBody::takes_springs): the force on a
// material point of an elastic body over the next `duration_s`, bounded by max_force_n. Damping against the
// target's velocity is critical for `mass_kg`. Stiffness and damping are limited to the stable range of the
// grasped cell in one substep.
Eigen::Vector3d spring_force(const World::Spring& spring, const Eigen::Vector3d& target_velocity_m_s,
                             const ElasticBody& body, double mass_kg, double duration_s) {
  const ElasticAccuracy accuracy = body.accuracy();
  // Effective mass and stiffness of the point within one substep: those of one cell.
  const double cell_mass = mass_kg / std::max<double>(1.0, static_cast<double>(accuracy.cells));
  const double cell_stiffness =
      std::min(accuracy.reached_youngs_modulus_pa, body.material().effective_youngs_modulus_pa()) *
      accuracy.cell_width_m;
  const double most = 0.5 * (cell_mass / duration_s + duration_s * cell_stiffness);
  const double stiffness = std::min(spring.stiffness_n_m, most / duration_s);
  const double damping = std::min(2.0 * std::sqrt(stiffness * mass_kg), most);
  const Eigen::Vector3d stretch = spring.target_m - body.world_point(spring.rest_point_m);
  const Eigen::Vector3d faster = target_velocity_m_s - body.point_velocity_m_s(spring.rest_point_m);
  const Eigen::Vector3d force = stiffness * stretch + damping * faster;
  return clamp_norm(force, spring.max_force_n);
}

// Body of an object with the surface nearest to a point, within `reach_m`.
struct NearestBody {
  std::optional<size_t> index;
  double distance_m = INFINITY;  // negative inside
  Eigen::Vector3d rest_point_m = Eigen::Vector3d::Zero();
};
NearestBody nearest_body(const RigidObject& object, const Eigen::Vector3d& point_m, double reach_m) {
  NearestBody nearest;
  for (size_t i = 0; i < object.bodies.size(); ++i) {
    const RigidBody& body = *object.bodies[i];
    const Eigen::Vector3d local = body.world_from_body.inverse() * point_m;
    if (local.norm() > body.shape.bounding_radius_m + std::min(reach_m, nearest.distance_m)) continue;
    const double distance = surface_distance_m(body.shape, local);
    if (!(distance <= reach_m) || (nearest.index && distance >= nearest.distance_m)) continue;
    nearest = {i, distance, local + body.rest_centre_m};
  }
  return nearest;
}

RayHit hit_of(uint32_t object_id, const RigidObject& object, const NearestBody& nearest) {
  return {object_id, std::max(0.0, nearest.distance_m), nearest.rest_point_m,
          object.piece_nearest_to(*nearest.index, nearest.rest_point_m)};
}

RayHit nearest_particle(uint32_t object_id, const ElasticObject& elastic, const Eigen::Vector3d& point_m) {
  RayHit nearest{object_id, INFINITY, Eigen::Vector3d::Zero(), {}};
  for (const Eigen::Vector3d& rest : elastic.rest_particles_m) {
    const double distance = (elastic.body->world_point(rest) - point_m).norm();
    if (distance < nearest.distance_m) nearest = {object_id, distance, rest, {}};
  }
  return nearest;
}

}  // namespace

std::optional<uint32_t> RigidObject::piece_nearest_to(size_t body_index,
                                                      const Eigen::Vector3d& rest_point_m) const {
  std::optional<uint32_t> nearest;
  double least = INFINITY;
  for (uint32_t i = 0; i < piece_bodies.size(); ++i) {
    if (piece_bodies[i] != body_index) continue;
    const BreakablePiece& piece = pieces->pieces[i];
    const double distance = surface_distance_m(*piece.shape, rest_point_m - piece.mass.centre_of_mass_m);
    if (nearest && distance >= least) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

void World::State::assign_grabs_to_pieces(uint32_t object_id, const RigidObject& object) {
  for (auto& [id, held] : grabs) {
    if (held.object_id == object_id) held.piece = object.piece_nearest_to(0, held.rest_point_m);
  }
}

void World::State::gather_springs(double duration_s) {
  for (RigidBody* body : rigid_bodies) body->springs.clear();
  const auto add_rigid_spring = [](RigidBody& body, RigidSpring& row) {
    body.wake();
    body.springs.push_back(&row);
  };
  // Adds a spring, critically damped for `mass_kg`. Returns its force; with implicit springs that of the last
  // step.
  const auto add_elastic_spring = [&](ElasticObject& elastic, const World::Spring& spring,
                                      const Eigen::Vector3d& velocity, double mass_kg, PointSpring& point) {
    if (!elastic.body->takes_springs()) {
      point.force_n = spring_force(spring, velocity, *elastic.body, mass_kg, duration_s);
      elastic.forces.push_back({spring.rest_point_m, point.force_n});
      return point.force_n;
    }
    point.target_m = spring.target_m;
    point.target_velocity_m_s = velocity;
    point.stiffness_n_m = spring.stiffness_n_m;
    point.damping_n_s_m = 2.0 * std::sqrt(spring.stiffness_n_m * mass_kg);
    point.max_force_n = spring.max_force_n;
    elastic.forces.push_back({spring.rest_point_m, Eigen::Vector3d::Zero(), &point});
    return point.force_n;
  };
  for (auto& [id, held] : springs) {
    held.force_n.setZero();
    WorldObject* object = find(held.object_id);
    if (!object || object->fixed()) continue;
    if (RigidObject* rigid = object->rigid()) {
      held.row.rest_point_m = held.spring.rest_point_m;
      held.row.target_m = held.spring.target_m;
      held.row.stiffness_n_m = held.spring.stiffness_n_m;
      held.row.max_force_n = held.spring.max_force_n;
      add_rigid_spring(rigid->body_with(held.spring.rest_point_m, held.spring.piece), held.row);
    } else {
      ElasticObject& elastic = *object->elastic();
      held.force_n = add_elastic_spring(elastic, held.spring, Eigen::Vector3d::Zero(),
                                        elastic.body->mass_kg(), held.point);
    }
  }
  for (auto& [id, held] : grabs) {
    held.force_n.setZero();
    WorldObject* object = find(held.object_id);
    if (!object || object->fixed()) continue;
    // Hands are extrapolated until their next update. After the timeout their velocity is zero.
    const double tick_s = 1.0 / settings.rate_hz;
    const double extrapolation_s = std::max(held.extrapolation_s, tick_s);
    Pose hand = held.world_from_hand;
    hand.position_m += std::min(held.since_update_s, extrapolation_s) * held.velocity_m_s;
    const Eigen::Vector3d turned = std::min(held.since_update_s, extrapolation_s) * held.spin_rad_s;
    const bool timed_out = held.since_update_s > extrapolation_s + kHandTimeoutTicks * tick_s;
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    const Eigen::Vector3d &velocity = timed_out ? zero : held.velocity_m_s,
                          &spin = timed_out ? zero : held.spin_rad_s;
    if (turned.norm() > 0.0) {
      hand.orientation = Eigen::AngleAxisd(turned.norm(), turned.normalized()) * hand.orientation;
    }
    held.since_update_s += duration_s;
    const double rate = 2.0 * std::numbers::pi * held.grip.frequency_hz;
    if (RigidObject* rigid = object->rigid()) {
      RigidBody& body = rigid->body_with(held.rest_point_m, held.piece);
      RigidSpring& row = held.row;
      row.rest_point_m = held.rest_point_m;
      row.target_m = hand.position_m;
      row.target_velocity_m_s = velocity;
      row.target_orientation = (hand.orientation * held.hand_from_object).normalized();
      row.target_spin_rad_s = spin;
      row.stiffness_n_m = body.mass_kg * squared(rate);
      row.turn_rad_s = rate;
      row.max_force_n = held.grip.max_force_n;
      row.max_torque_n_m = held.grip.max_torque_n_m;
      add_rigid_spring(body, row);
    } else {
      ElasticObject& elastic = *object->elastic();
      const double share = 1.0 / static_cast<double>(held.grip_points.size());
      const double mass_kg = share * elastic.body->mass_kg();
      for (GripPoint& place : held.grip_points) {
        const Eigen::Vector3d arm = hand.orientation * place.hand_point_m;
        const World::Spring spring{place.rest_point_m, hand.position_m + arm, mass_kg * squared(rate),
                                   share * held.grip.max_force_n};
        held.force_n += add_elastic_spring(elastic, spring, velocity + spin.cross(arm), mass_kg, place.point);
      }
    }
  }
}

void World::set_spring(uint64_t spring_id, uint32_t object_id, const Spring& spring) {
  if (!state_->find(object_id) || !spring.target_m.allFinite()) return;
  ActiveSpring& held = state_->springs[spring_id];
  if (held.object_id != object_id) held = {};
  held.object_id = object_id;
  held.spring = spring;
}

void World::clear_spring(uint64_t spring_id) { state_->springs.erase(spring_id); }

Eigen::Vector3d World::spring_force_n(uint64_t spring_id) const {
  const auto found = state_->springs.find(spring_id);
  if (found == state_->springs.end()) return Eigen::Vector3d::Zero();
  const WorldObject* object = state_->find(found->second.object_id);
  return object && object->rigid() ? found->second.row.force_n : found->second.force_n;
}

Result<void> World::grab(uint64_t grab_id, uint32_t object_id, const Pose& world_from_hand,
                         const Grip& grip) {
  release_grab(grab_id);
  const std::string name = object_name(object_id);
  const WorldObject* object = state_->find(object_id);
  if (!object) return not_found("grab: " + name + " is unknown; give the id of an object in the world");
  if (object->fixed())
    return invalid_argument("grab: " + name + " is static; only moving objects can be grabbed");
  if (auto checked = check_pose(object_id, world_from_hand); !checked) return checked;
  if (!(grip.frequency_hz > 0.0 && grip.frequency_hz <= 100.0) || !(grip.max_force_n >= 0.0) ||
      !(grip.max_torque_n_m >= 0.0)) {
    return invalid_argument("grab of " + name + ": frequency_hz is outside 0 to 100, or a bound is negative");
  }
  ActiveGrab held;
  held.object_id = object_id;
  held.grip = grip;
  held.world_from_hand = {world_from_hand.position_m, world_from_hand.orientation.normalized()};
  if (const RigidObject* rigid = object->rigid()) {
    const NearestBody nearest = nearest_body(*rigid, world_from_hand.position_m, INFINITY);
    if (!nearest.index) return invalid_argument("grab of " + name + ": the hand position is out of range");
    held.rest_point_m = nearest.rest_point_m;
    held.piece = rigid->piece_nearest_to(*nearest.index, nearest.rest_point_m);
    held.hand_from_object = held.world_from_hand.orientation.conjugate() *
                            rigid->bodies[*nearest.index]->world_from_body.orientation;
  } else {
    held.grip_points = grip_points_in_palm(*object->elastic(), held.world_from_hand);
    held.rest_point_m = held.grip_points.front().rest_point_m;
  }
  state_->grabs[grab_id] = std::move(held);
  return {};
}

void World::move_grab(uint64_t grab_id, const Pose& world_from_hand, const Eigen::Vector3d& velocity_m_s,
                      const Eigen::Vector3d& spin_rad_s, double extrapolation_s) {
  const auto found = state_->grabs.find(grab_id);
  if (found == state_->grabs.end() || !velocity_m_s.allFinite() || !spin_rad_s.allFinite()) return;
  if (!(extrapolation_s >= 0.0 && std::isfinite(extrapolation_s))) return;
  if (!check_pose(0, world_from_hand)) return;
  ActiveGrab& held = found->second;
  held.world_from_hand = {world_from_hand.position_m, world_from_hand.orientation.normalized()};
  held.velocity_m_s = velocity_m_s;
  held.spin_rad_s = spin_rad_s;
  held.extrapolation_s = extrapolation_s;
  held.since_update_s = 0.0;
}

void World::release_grab(uint64_t grab_id) { state_->grabs.erase(grab_id); }

std::optional<World::GrabState> World::grab_state(uint64_t grab_id) const {
  const auto found = state_->grabs.find(grab_id);
  if (found == state_->grabs.end()) return std::nullopt;
  const ActiveGrab& held = found->second;
  const WorldObject* object = state_->find(held.object_id);
  if (!object) return std::nullopt;
  GrabState state{world_point(held.object_id, held.rest_point_m, held.piece), held.force_n,
                  Eigen::Vector3d::Zero(), held.piece};
  if (object->rigid()) {
    state.force_n = held.row.force_n;
    state.torque_n_m = held.row.torque_n_m;
  }
  return state;
}

double World::contact_impulse_n_s(uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                                  std::optional<uint32_t> piece) const {
  const WorldObject* object = state_->find(object_id);
  if (!object) return 0.0;
  if (const RigidObject* rigid = object->rigid())
    return rigid->body_with(rest_point_m, piece).last_tick_contact_impulse_n_s;
  return object->elastic() ? object->elastic()->last_tick_contact_impulse_n_s : 0.0;
}

double World::mass_at_kg(uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                         std::optional<uint32_t> piece) const {
  const WorldObject* object = state_->find(object_id);
  if (!object) return 0.0;
  if (const RigidObject* rigid = object->rigid()) return rigid->body_with(rest_point_m, piece).mass_kg;
  return object->elastic() ? object->elastic()->body->mass_kg() : 0.0;
}

std::optional<RayHit> World::nearest(const Eigen::Vector3d& point_m, double reach_m) const {
  std::optional<RayHit> nearest;
  for (const auto& [id, object] : state_->objects) {
    const double within_m = nearest ? nearest->distance_m : reach_m;
    std::optional<RayHit> met;
    if (const RigidObject* rigid = object.rigid()) {
      const NearestBody body = nearest_body(*rigid, point_m, within_m);
      if (body.index) met = hit_of(id, *rigid, body);
    } else if (const ElasticObject* elastic = object.elastic()) {
      if ((elastic->body->centre_m() - point_m).norm() > 2.0 * elastic->body->reach_m() + within_m) continue;
      met = nearest_particle(id, *elastic, point_m);
    }
    if (met && met->distance_m <= reach_m && (!nearest || met->distance_m < nearest->distance_m))
      nearest = met;
  }
  return nearest;
}

std::optional<RayHit> World::nearest_of(uint32_t object_id, const Eigen::Vector3d& point_m) const {
  const WorldObject* object = state_->find(object_id);
  if (!object || object->fixed()) return std::nullopt;
  if (const RigidObject* rigid = object->rigid()) {
    const NearestBody nearest = nearest_body(*rigid, point_m, INFINITY);
    return nearest.index ? std::optional(hit_of(object_id, *rigid, nearest)) : std::nullopt;
  }
  return nearest_particle(object_id, *object->elastic(), point_m);
}

}  // namespace livegs
