// SPDX-License-Identifier: GPL-3.0-or-later
// Fracture of a rigid object into fragments. The rule which bonds break is in fracture/bond_graph.h; this
// file applies it. The order of a tick is in ../README.md; break_object() starts at the decision.
//
// Each fragment receives the velocity of its material and its share of mass and inertia, which conserves
// mass, linear and angular momentum. Kinetic energy grows only by the recoil.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "physics/check/check_values.h"
#include "physics/fracture/fracture_recoil.h"
#include "physics/world/world_state.h"

namespace livegs {
namespace {

// Impacts below this fraction of the whole object's threshold are ignored, for fragments too.
constexpr double kMinImpactRatio = 0.01;
// Impulses with |sum| >= this fraction of the sum of magnitudes have a common direction.
constexpr double kMinDirectionality = 0.99;

// The features of its contacts no longer exist.
void discard_contacts(std::span<RigidBody* const> bodies, RigidBody& broken) {
  for (ContactManifold& manifold : broken.manifolds) {
    if (manifold.other && manifold.other->asleep) manifold.other->wake();
  }
  broken.manifolds.clear();
  broken.previous_manifolds.clear();
  const auto gone = [&](const ContactManifold& manifold) { return manifold.other == &broken; };
  for (RigidBody* body : bodies) {
    if (std::erase_if(body->manifolds, gone) > 0 && body->asleep) body->wake();
    std::erase_if(body->previous_manifolds, gone);
  }
}

// Makes `body` the fragment `members` of `whole`. They may be the same object.
void become_fragment(RigidBody& body, const RigidBody& whole, const RigidObject& object,
                     std::span<const uint32_t> members) {
  const MassProperties properties = joined_mass(*object.pieces, members);
  const Eigen::Vector3d spin = whole.angular_velocity_rad_s;
  const Eigen::Vector3d arm = whole.arm_of(properties.centre_of_mass_m);
  const double mass_kg = object.material.mass_kg * joined_share(*object.pieces, members);
  body.tick_energy_j = whole.tick_energy_j * mass_kg / whole.mass_kg;
  body.velocity_m_s = whole.velocity_m_s + spin.cross(arm);
  body.world_from_body = {whole.world_from_body.position_m + arm, whole.world_from_body.orientation};
  body.mass_kg = mass_kg;
  body.set_unit_inertia(properties.inertia_m2);
  body.rest_centre_m = properties.centre_of_mass_m;
  body.shape = joined_shape(*object.pieces, members, properties.centre_of_mass_m);
  body.friction = whole.friction;
  body.restitution = object.material.restitution;
  body.asleep = false;
  body.still_s = 0.0;
  body.impacts = {};
  body.can_break = true;
  body.set_angular_velocity(spin);
}

BondGraph bond_graph_of(const RigidObject& object) {
  BondGraph graph =
      make_bond_graph(object.pieces->cut, object.material.mass_kg, object.material.break_impulse_n_s);
  for (size_t i = 0; i < graph.pieces.size(); ++i) {
    const BreakablePiece& piece = object.pieces->pieces[i];
    const double mass_kg = object.material.mass_kg * piece.mass_share;
    graph.pieces[i] = {mass_kg, piece.mass.centre_of_mass_m, mass_kg * piece.mass.inertia_m2,
                       graph.pieces[i].volume_m3};
  }
  return graph;
}

// Piece of this body at a struck point, which may be slightly off the surface.
uint32_t nearest_piece(const RigidObject& object, uint32_t body_index, const Eigen::Vector3d& point_m) {
  uint32_t nearest = 0;
  double least = INFINITY;
  for (uint32_t i = 0; i < object.pieces->pieces.size(); ++i) {
    if (object.body_of(i) != body_index) continue;
    const BreakablePiece& piece = object.pieces->pieces[i];
    const double distance = piece.shape->sample(point_m - piece.mass.centre_of_mass_m).distance_m;
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  return nearest;
}

Impact impact_of(const RigidObject& object, uint32_t body_index, const ImpulseAccumulator& sum) {
  const Eigen::Vector3d point_m = object.bodies[body_index]->rest_centre_m + sum.moment / sum.impulse_n_s;
  return {nearest_piece(object, body_index, point_m), point_m, sum.impulse_n_s * direction_of(sum)};
}

// Removes the fraction `part` of contact impulses (body axes), limited so that the energy is at most
// `most_j`: the impulses acted over several substeps, in which the body rotated.
void undo_contact_impulse(RigidBody& body, const ImpulseAccumulator& given, double part, double most_j) {
  const Eigen::Vector3d impulse = -part * (body.world_from_body.orientation * given.total_n_s);
  const Eigen::Vector3d moment = -part * (body.world_from_body.orientation * given.total_moment);
  // kinetic + s linear + s² square <= most
  const double linear = impulse.dot(body.velocity_m_s) + moment.dot(body.angular_velocity_rad_s);
  const double square =
      0.5 * (body.inverse_mass * impulse.squaredNorm() + moment.dot(body.inverse_inertia * moment));
  const double room = std::max(0.0, most_j - body.kinetic_j());
  double share = 1.0;
  if (linear + square > room) {
    share = square > 0.0 ? (std::sqrt(linear * linear + 4.0 * square * room) - linear) / (2.0 * square) : 0.0;
  }
  body.apply_impulse(share * impulse, Eigen::Vector3d::Zero());
  body.apply_angular_impulse(share * moment);
}

// Applies the recoil to the faces of broken bonds between different bodies.
void apply_fracture_energy(RigidObject& object, std::span<const uint32_t> broken, double energy_j) {
  std::vector<RigidBody*> bodies;
  std::vector<OpenedFace> faces;
  const auto number = [&](RigidBody& body) {
    const auto at = static_cast<size_t>(std::ranges::find(bodies, &body) - bodies.begin());
    if (at == bodies.size()) bodies.push_back(&body);
    return at;
  };
  for (const uint32_t bond : broken) {
    if (bond >= object.pieces->cut.bonds.size()) continue;  // bonds of isolated parts have no face
    const VoronoiBond& face = object.pieces->cut.bonds[bond];
    RigidBody& first = *object.bodies[object.body_of(face.first)];
    RigidBody& second = *object.bodies[object.body_of(face.second)];
    if (&first == &second) continue;
    faces.push_back({number(first), number(second), face.area_m2,
                     first.world_from_body.position_m + first.arm_of(face.centroid_m),
                     first.world_from_body.orientation * face.normal});
  }
  recoil(bodies, faces, energy_j);
}

}  // namespace

void World::State::split_body(uint32_t object_id, RigidObject& object, uint32_t body_index,
                              const std::vector<std::vector<uint32_t>>& groups) {
  RigidBody& broken = *object.bodies[body_index];
  discard_contacts(rigid_bodies, broken);
  const auto share = [&](const std::vector<uint32_t>& group) { return joined_share(*object.pieces, group); };
  const auto largest = std::ranges::max_element(groups, {}, share);
  for (const std::vector<uint32_t>& group : groups) {
    if (&group == &*largest) continue;
    auto fragment = std::make_unique<RigidBody>();
    fragment->object_id = object_id;
    fragment->body_index = static_cast<uint32_t>(object.bodies.size());
    become_fragment(*fragment, broken, object, group);
    for (const uint32_t piece : group) object.piece_bodies[piece] = fragment->body_index;
    object.bodies.push_back(std::move(fragment));
  }
  become_fragment(broken, broken, object, *largest);
}

bool World::State::fracture_body(uint32_t object_id, RigidObject& object, uint32_t body_index,
                                 const Impact& impact, const ImpulseAccumulator& given,
                                 double undone_fraction, double recoil_j) {
  const std::vector<uint32_t> broken = broken_bonds(object.bonds, impact);
  for (const uint32_t bond : broken) object.bonds.bonds[bond].integrity = 0.0;
  const std::vector<uint32_t> group_of = connected_groups(object.bonds);
  std::map<uint32_t, std::vector<uint32_t>> members;
  for (uint32_t piece = 0; piece < group_of.size(); ++piece) {
    if (object.body_of(piece) == body_index) members[group_of[piece]].push_back(piece);
  }
  if (members.size() < 2) return false;
  std::vector<std::vector<uint32_t>> groups;
  for (auto& [first, group] : members) groups.push_back(std::move(group));
  RigidBody& body = *object.bodies[body_index];
  // The energy must not exceed that at the start of the tick.
  undo_contact_impulse(body, given, undone_fraction,
                       body.tick_energy_j - (energy_j(body) - body.kinetic_j()));
  if (object.piece_bodies.empty()) {
    object.piece_bodies.assign(group_of.size(), 0);
    assign_grabs_to_pieces(object_id, object);
  }
  // In a jam, impulses far exceed the approach they ended, so the recoil is limited to the energy that was
  // lost.
  const double most_j = kRecoilEnergyFraction * std::max(0.0, local_energy_loss_j(body));
  split_body(object_id, object, body_index, groups);
  apply_fracture_energy(object, broken, std::min(recoil_j, most_j));
  ++object.revision;
  return true;
}

double World::State::energy_j(const RigidBody& body) const {
  return body.kinetic_j() - body.mass_kg * settings.gravity_m_s2.dot(body.world_from_body.position_m);
}

double World::State::local_energy_loss_j(const RigidBody& body) const {
  const double tick_s = 1.0 / settings.rate_hz;
  const auto reach_m = [&](const RigidBody& one) {
    return one.shape.bounding_radius_m +
           tick_s * (one.velocity_m_s.norm() + tick_s * settings.gravity_m_s2.norm());
  };
  double lost = 0.0;
  for (const auto& [id, thing] : objects) {
    const RigidObject* object = thing.rigid();
    if (!object) continue;
    for (const auto& one : object->bodies) {
      const double apart = (one->world_from_body.position_m - body.world_from_body.position_m).norm();
      if (apart < reach_m(*one) + reach_m(body)) lost += one->tick_energy_j - energy_j(*one);
    }
  }
  return lost;
}

void World::State::process_impacts() {
  bool broke = false;
  for (const auto& [id, thing] : listed_objects) {
    RigidObject* object = thing->rigid();
    if (!object) continue;
    const size_t count = object->bodies.size();
    for (uint32_t index = 0; index < count; ++index) {
      RigidBody& body = *object->bodies[index];
      if (!body.can_break) continue;
      const ImpulseAccumulator sum = body.impacts.take(1.0 / settings.rate_hz),
                               episode = body.impacts.take_ended_episode();
      if (!object->material.fragile) continue;
      const double faint_n_s = kMinImpactRatio * object->bonds.break_impulse_n_s;
      // Damage is applied after an episode of impacts: until then it is one impact on the undamaged body.
      if (episode.impulse_n_s >= faint_n_s)
        accumulate_damage(object->bonds, impact_of(*object, index, episode));
      if (sum.impulse_n_s < faint_n_s) continue;
      const Impact impact = impact_of(*object, index, sum);
      const Eigen::Vector3d where =
          body.world_from_body * Eigen::Vector3d(impact.point_m - body.rest_centre_m);
      // The impulse above the threshold was never transmitted. After an impact on a static object, fragments
      // keep their previous velocity minus the part that broke the bonds, and continue until they hit the
      // object themselves. Impulses from other bodies are kept, because those bodies have already received
      // the opposite.
      double undone_fraction = 0.0;
      const bool one_way = sum.push_n_s.norm() > kMinDirectionality * sum.impulse_n_s;
      double borne = 1.0;
      if (sum.from_colliders && one_way) {
        borne = std::min(1.0, break_threshold_n_s(object->bonds, impact) / sum.impulse_n_s);
        undone_fraction = 1.0 - borne;
      }
      const Eigen::Vector3d arm = impact.point_m - body.rest_centre_m;
      // Soft contact dissipates no energy at once.
      const double restitution = body.in_elastic_contact ? 1.0 : sum.restitution;
      const double recoil_j =
          kRecoilEnergyFraction * impact_energy_loss_j(body, sum.push_n_s, arm, borne, restitution);
      if (!fracture_body(id, *object, index, impact, sum, undone_fraction, recoil_j)) continue;
      broke = true;
      events.push_back({tick, WorldEventKind::Fracture, id, sum.impulse_n_s, where});
    }
  }
  if (broke) list_bodies();
}

Result<RigidObject*> World::State::find_rigid(uint32_t object_id) {
  WorldObject* thing = find(object_id);
  if (thing && thing->rigid()) return thing->rigid();
  return not_found(object_name(object_id) + ": there is no rigid object with this id; give the id of one");
}

Result<void> World::set_pieces(uint32_t object_id, std::shared_ptr<const BreakablePieces> pieces) {
  const std::string name = object_name(object_id);
  const auto found = state_->find_rigid(object_id);
  if (!found) return found.error();
  RigidObject* const object = *found;
  if (object->revision > 0)
    return invalid_argument(name + ": the object is already broken; reset the scene first");
  if (!(object->material.break_impulse_n_s > 0.0)) {
    return invalid_argument(name + ": break_impulse_n_s is not positive; set it for fragile objects");
  }
  std::vector<uint32_t> all(pieces->pieces.size());
  std::iota(all.begin(), all.end(), 0u);
  const MassProperties whole = joined_mass(*pieces, all);
  RigidBody& body = *object->bodies[0];
  const double apart = (whole.centre_of_mass_m - body.rest_centre_m).norm();
  if (apart > 1e-6 * body.shape.bounding_radius_m) {
    return invalid_argument(name + ": the pieces belong to another body: their centre of mass is " +
                            std::to_string(apart) + " m off");
  }
  const Eigen::Vector3d spin = body.angular_velocity_rad_s;
  body.set_unit_inertia(whole.inertia_m2);
  body.set_angular_velocity(spin);
  object->pieces = std::move(pieces);
  object->bonds = bond_graph_of(*object);
  body.can_break = true;
  return {};
}

Result<void> World::break_object(uint32_t object_id, const Eigen::Vector3d& rest_point_m) {
  const std::string name = object_name(object_id);
  const auto found = state_->find_rigid(object_id);
  if (!found) return found.error();
  RigidObject* const object = *found;
  if (!object->pieces)
    return invalid_argument(
        name + ": there are no pieces yet; make the object fragile, or wait for the cut to finish");
  Impact impact{object->pieces->cut.locate(rest_point_m), rest_point_m};
  const uint32_t index = object->body_of(impact.piece);
  const RigidBody& body = *object->bodies[index];
  const Eigen::Vector3d inwards = body.rest_centre_m - rest_point_m;
  const Eigen::Vector3d direction =
      inwards.norm() > 0.01 * body.shape.bounding_radius_m ? inwards.normalized() : -Eigen::Vector3d::UnitY();
  impact.impulse_n_s = direction;
  const double threshold = break_threshold_n_s(object->bonds, impact);
  if (!std::isfinite(threshold))
    return invalid_argument(name + ": the piece at this point cannot break further; give another point");
  impact.impulse_n_s = kForcedBreakFactor * threshold * direction;
  const Eigen::Vector3d where = body.world_from_body.position_m + body.arm_of(rest_point_m);
  state_->find(object_id)->wake();
  if (!state_->fracture_body(object_id, *object, index, impact, {}, 0.0, 0.0)) {
    return invalid_argument(name + ": no bond breaks at this point; give another point");
  }
  state_->events.push_back({state_->tick, WorldEventKind::Fracture, object_id, 0.0, where});
  state_->list_bodies();
  return {};
}

std::span<const uint32_t> World::piece_bodies(uint32_t object_id) const {
  const WorldObject* object = state_->find(object_id);
  return object && object->rigid() ? std::span<const uint32_t>(object->rigid()->piece_bodies)
                                   : std::span<const uint32_t>();
}

uint32_t World::revision(uint32_t object_id) const {
  const WorldObject* object = state_->find(object_id);
  return object && object->rigid() ? object->rigid()->revision : 0;
}

}  // namespace livegs
