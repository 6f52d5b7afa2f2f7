// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/world.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/assert.h"
#include "physics/check/check_values.h"
#include "physics/collision/convex_polyhedron.h"
#include "physics/collision/surface_points.h"
#include "physics/world/world_state.h"

namespace livegs {
namespace {

Result<void> check_mesh(uint32_t id, const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return object_error(id, "the mesh has no triangles");
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    if (!vertex.allFinite()) return object_error(id, "a vertex of the mesh is not finite");
  }
  for (const auto& triangle : mesh.triangles) {
    if (std::ranges::max(triangle) >= mesh.vertices_m.size())
      return object_error(id, "a triangle of the mesh refers to a missing vertex");
  }
  return {};
}

Result<void> check_settings(const WorldSettings& settings) {
  if (!settings.gravity_m_s2.allFinite()) return invalid_argument("world: gravity_m_s2 is not finite");
  if (!(settings.rate_hz >= 1.0 && settings.rate_hz <= 1e4)) {
    return invalid_argument("world: rate_hz " + number_text(settings.rate_hz) + " is outside 1 to 10000");
  }
  if (settings.substeps < 1 || settings.substeps > 4096) {
    return invalid_argument("world: substeps " + std::to_string(settings.substeps) + " is outside 1 to 4096");
  }
  return {};
}

Result<void> check_break_impulse(uint32_t object_id, const Material& material) {
  // As in scene files. Below the minimum, standing would count as an impact.
  return check_range(object_id, "break_impulse_n_s", material.break_impulse_n_s, 1e-6, 1e6);
}

Result<void> check_rigid(const RigidBodyDescription& description) {
  const uint32_t id = description.object_id;
  LIVEGS_RETURN_IF_ERROR(check_material(id, description.material));
  LIVEGS_RETURN_IF_ERROR(check_pose(id, description.world_from_object));
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "velocity_m_s", description.velocity_m_s));
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "angular_velocity_rad_s", description.angular_velocity_rad_s));
  LIVEGS_RETURN_IF_ERROR(check_mesh(id, description.mesh));
  for (const FrictionBox& one : description.friction_boxes)
    LIVEGS_RETURN_IF_ERROR(check_range(id, "friction_boxes.factor", one.factor, 0.0, kMaxFrictionFactor));
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "centre_of_mass_m", description.properties.centre_of_mass_m));
  const Eigen::Matrix3d& inertia = description.properties.inertia_m2;
  if (!inertia.allFinite()) return object_error(id, "inertia is not finite");
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d moments = solver.eigenvalues();  // ascending
  // The largest moment is at most the sum of the other two; a flat body has equality.
  if (!(moments[0] > 0.0) || moments[2] > 1.001 * (moments[0] + moments[1])) {
    return object_error(id, "inertia is not physical; check that the mesh is closed and oriented outwards");
  }
  return {};
}

Result<void> check_ball(const BallDescription& description) {
  const uint32_t id = description.object_id;
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "position_m", description.position_m));
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "velocity_m_s", description.velocity_m_s));
  LIVEGS_RETURN_IF_ERROR(check_positive(id, "radius_m", description.radius_m));
  LIVEGS_RETURN_IF_ERROR(check_positive(id, "mass_kg", description.mass_kg));
  LIVEGS_RETURN_IF_ERROR(check_range(id, "friction", description.friction, 0.0, kMaxFriction));
  LIVEGS_RETURN_IF_ERROR(check_range(id, "restitution", description.restitution, 0.0, 1.0));
  return {};
}

}  // namespace

void WorldObject::sleep() {
  if (RigidObject* object = rigid()) {
    for (const auto& body : object->bodies) body->sleep(object->bodies[0]->body_id() + 1);
  } else if (ElasticObject* soft = elastic()) {
    soft->body->sleep();
  }
}

bool WorldObject::asleep() const {
  if (const RigidObject* object = rigid())
    return std::ranges::all_of(object->bodies, [](const auto& body) { return body->asleep; });
  if (const ElasticObject* object = elastic()) return object->body->asleep();
  return true;
}

void WorldObject::wake() {
  if (RigidObject* object = rigid()) {
    for (const auto& body : object->bodies) body->wake();
  } else if (ElasticObject* soft = elastic()) {
    soft->body->wake();
  }
}

WorldObject* World::State::find(uint32_t object_id) {
  const auto found = objects.find(object_id);
  return found == objects.end() ? nullptr : &found->second;
}

size_t World::State::rigid_index(uint64_t body_id) const {
  const auto at = std::ranges::lower_bound(rigid_bodies, body_id, {}, &RigidBody::body_id);
  const bool found = at != rigid_bodies.end() && (*at)->body_id() == body_id;
  return found ? static_cast<size_t>(at - rigid_bodies.begin()) : rigid_bodies.size();
}

void World::State::list_bodies() {
  rigid_bodies.clear();
  broad_phase.invalidate();
  elastic_objects.clear();
  listed_objects.clear();
  for (auto& [id, object] : objects) {
    listed_objects.emplace_back(id, &object);
    if (RigidObject* rigid = object.rigid()) {
      for (const auto& body : rigid->bodies) rigid_bodies.push_back(body.get());
    }
    if (ElasticObject* elastic = object.elastic()) elastic_objects.push_back(elastic);
  }
  for (RigidBody* body : rigid_bodies) body->in_elastic_contact = body->island_awake = false;
  loads.resize(rigid_bodies.size());
  rigid_proxies.assign(rigid_bodies.size(), {});
  velocity_changes.assign(rigid_bodies.size(), {});
  if (!joints.empty()) link_joints();
}

void World::State::wake_all() {
  for (auto& [id, object] : objects) object.wake();
}

int min_substeps(double rate_hz) {
  return static_cast<int>(std::ceil(1.0 / (rate_hz * kMaxSubstep_s) - 1e-9));
}

void prepare_body(RigidBodyDescription& description) {
  if (description.sphere_radius_m > 0.0 || !check_rigid(description)) return;
  description.shape = std::make_shared<const RigidShape>(
      mesh_shape(description.mesh, description.properties.centre_of_mass_m));
}

void prepare_body(ElasticBodyDescription& description) {
  if (!check_elastic_body(description)) return;
  description.patches =
      std::make_shared<const std::vector<SurfacePatch>>(surface_patches(description.particles));
}

World::World(const WorldSettings& settings) : state_(std::make_unique<State>()) {
  LIVEGS_ASSERT(check_settings(settings).has_value());
  state_->settings = settings;
  state_->settings.substeps = std::max(settings.substeps, min_substeps(settings.rate_hz));
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

const WorldSettings& World::settings() const { return state_->settings; }
uint64_t World::tick() const { return state_->tick; }
StepTimes World::last_times() const { return state_->times; }

void World::put_to_sleep(uint32_t object_id) {
  if (WorldObject* object = state_->find(object_id)) object->sleep();
}

void World::add_collider(const Collider& collider, uint32_t object_id) {
  state_->colliders.push_back(collider);
  state_->collider_objects.push_back(object_id);
  if (auto* box = std::get_if<BoxShape>(&state_->colliders.back().shape);
      box && box->size_m.minCoeff() > 0.0) {
    box->polyhedron = std::make_shared<ConvexPolyhedron>(box_polyhedron(box->size_m));
  }
  state_->wake_all();
}

namespace {

Result<void> check_new_id(const WorldObject* present, uint32_t object_id) {
  if (!present) return {};
  return object_error(object_id, "the id is already in use; choose another");
}

Pose normalized(Pose pose) {
  pose.orientation.normalize();
  return pose;
}

}  // namespace

Result<void> World::add_static(uint32_t object_id, const Pose& world_from_object) {
  if (auto fresh = check_new_id(state_->find(object_id), object_id); !fresh) return fresh;
  if (auto checked = check_pose(object_id, world_from_object); !checked) return checked;
  StaticObject object{normalized(world_from_object), {}};
  object.material.behavior = Behavior::Static;
  state_->objects[object_id] = {std::move(object), true};
  return {};
}

Result<void> World::add_rigid(const RigidBodyDescription& description) {
  const uint32_t id = description.object_id;
  if (auto fresh = check_new_id(state_->find(id), id); !fresh) return fresh;
  if (auto checked = check_rigid(description); !checked) return checked;
  return state_->add(description);
}

Result<void> World::State::add(const RigidBodyDescription& description) {
  RigidObject object;
  object.material = description.material;
  object.material.behavior = Behavior::Rigid;
  object.bodies.push_back(std::make_unique<RigidBody>());
  RigidBody& body = *object.bodies[0];
  body.object_id = description.object_id;
  body.rest_centre_m = description.properties.centre_of_mass_m;
  if (description.sphere_radius_m > 0.0) {
    body.shape = ball_shape(description.sphere_radius_m);
  } else {
    body.shape = description.shape ? *description.shape : mesh_shape(description.mesh, body.rest_centre_m);
  }
  body.shape.round = description.round;
  if (body.shape.round) body.shape.round->centre_m -= body.rest_centre_m;
  body.mass_kg = description.material.mass_kg;
  body.set_unit_inertia(description.properties.inertia_m2);
  body.friction.own = description.material.friction;
  if (!description.friction_boxes.empty())
    body.friction.boxes = std::make_shared<const std::vector<FrictionBox>>(description.friction_boxes);
  body.restitution = description.material.restitution;
  body.world_from_body = normalized(description.world_from_object);
  body.world_from_body.position_m = body.world_from_body * body.rest_centre_m;
  body.velocity_m_s = description.velocity_m_s;
  body.set_angular_velocity(description.angular_velocity_rad_s);
  objects[description.object_id] = {std::move(object), false};
  list_bodies();
  return {};
}

Result<void> World::add_ball(const BallDescription& description) {
  const uint32_t id = description.object_id;
  if (auto fresh = check_new_id(state_->find(id), id); !fresh) return fresh;
  if (auto checked = check_ball(description); !checked) return checked;

  RigidBodyDescription ball;
  ball.object_id = id;
  ball.properties.inertia_m2 =
      0.4 * description.radius_m * description.radius_m * Eigen::Matrix3d::Identity();
  ball.sphere_radius_m = description.radius_m;
  ball.material.mass_kg = description.mass_kg;
  ball.material.friction = description.friction;
  ball.material.restitution = description.restitution;
  ball.world_from_object.position_m = description.position_m;
  ball.velocity_m_s = description.velocity_m_s;
  return state_->add(ball);
}

Result<void> World::add_elastic(const ElasticBodyDescription& description) {
  const uint32_t id = description.object_id;
  if (auto fresh = check_new_id(state_->find(id), id); !fresh) return fresh;
  const WorldSettings& settings = state_->settings;
  auto body = settings.make_elastic(description, settings.rate_hz, settings.substeps, settings.sleep);
  if (!body) return body.error();
  ElasticObject object;
  object.body = std::move(body).value();
  object.rest_particles_m = description.particles.positions_m;
  object.object_id = id;
  state_->objects[id] = {std::move(object), false};
  state_->list_bodies();
  return {};
}

// Contacts refer to bodies by pointer, so they must not outlive a body or a move of it.
void World::State::end_contacts_of(uint32_t object_id) {
  WorldObject* object = find(object_id);
  if (RigidObject* rigid = object->rigid()) {
    for (const auto& body : rigid->bodies) {
      for (const ContactManifold& manifold : body->manifolds) {
        if (manifold.other) manifold.other->wake();
      }
      body->manifolds.clear();
      body->previous_manifolds.clear();
    }
  }
  if (const ElasticObject* elastic = object->elastic()) {
    for (const uint64_t id : elastic->contacts_last_tick) {
      if (WorldObject* other = find(object_of_body(id))) other->wake();
    }
  }
  for (ElasticObject* elastic : elastic_objects) {
    const auto was = [&](uint64_t id) { return object_of_body(id) == object_id; };
    if (std::erase_if(elastic->contacts_last_tick, was) > 0) elastic->body->wake();
  }
  const auto gone = [&](const ContactManifold& manifold) {
    return manifold.other && object_of_body(manifold.other_id) == object_id;
  };
  for (RigidBody* body : rigid_bodies) {
    if (std::erase_if(body->manifolds, gone) > 0) body->wake();
    std::erase_if(body->previous_manifolds, gone);
  }
}

void World::remove_colliders(uint32_t object_id) {
  State& state = *state_;
  for (size_t i = state.colliders.size(); i-- > 0;) {
    if (state.collider_objects[i] != object_id) continue;
    state.colliders.erase(state.colliders.begin() + static_cast<std::ptrdiff_t>(i));
    state.collider_objects.erase(state.collider_objects.begin() + static_cast<std::ptrdiff_t>(i));
  }
  // Contacts with colliders are known by the collider's index.
  for (RigidBody* body : state.rigid_bodies) {
    const auto fixed = [](const ContactManifold& manifold) { return !manifold.other; };
    std::erase_if(body->manifolds, fixed);
    std::erase_if(body->previous_manifolds, fixed);
  }
  state.wake_all();
}

void World::remove(uint32_t object_id) {
  const auto found = state_->objects.find(object_id);
  if (found == state_->objects.end()) return;
  state_->end_contacts_of(object_id);
  if (found->second.fixed()) remove_colliders(object_id);
  state_->objects.erase(found);
  // The id may be reused by an object without forces, springs and grabs.
  const auto on_it = [&](const auto& entry) { return entry.second.object_id == object_id; };
  std::erase_if(state_->forces, on_it);
  std::erase_if(state_->springs, on_it);
  std::erase_if(state_->grabs, on_it);
  state_->list_bodies();
}

Result<void> World::place(uint32_t object_id, const Pose& world_from_object,
                          const Eigen::Vector3d& velocity_m_s,
                          const Eigen::Vector3d& angular_velocity_rad_s) {
  const auto fail = [&](const char* why) { return object_error(object_id, why); };
  WorldObject* object = state_->find(object_id);
  if (!object) return fail("unknown id; give the id of an object in the world");
  if (object->fixed()) return fail("is static and cannot be moved; set its behavior to RIGID or ELASTIC");
  if (auto checked = check_pose(object_id, world_from_object); !checked) return checked;
  const Pose pose = normalized(world_from_object);
  if (RigidObject* rigid = object->rigid()) {
    if (!rigid->piece_bodies.empty())
      return fail("is broken and cannot be moved as a whole; reset the scene first");
    state_->end_contacts_of(object_id);
    RigidBody& body = *rigid->bodies[0];
    body.wake();
    body.world_from_body = {pose * body.rest_centre_m, pose.orientation};
    body.velocity_m_s = velocity_m_s;
    body.set_angular_velocity(angular_velocity_rad_s);
  } else {
    if (!object->elastic()->body->place(pose, velocity_m_s, angular_velocity_rad_s))
      return fail("cannot be moved by this solver");
    state_->end_contacts_of(object_id);
  }
  state_->broad_phase.invalidate();
  return {};
}

void World::set_force(uint64_t force_id, uint32_t object_id, const PointForce& force, double duration_s) {
  WorldObject* object = state_->find(object_id);
  if (!object) return;
  object->wake();
  const double now_s = static_cast<double>(state_->tick) / state_->settings.rate_hz;
  state_->forces[force_id] = {object_id, force, now_s + duration_s};
}

Result<void> World::set_material(uint32_t object_id, const Material& material) {
  WorldObject* object = state_->find(object_id);
  if (!object)
    return not_found(object_name(object_id) + ": unknown id; give the id of an object in the world");
  const Material* present = this->material(object_id);
  if (present->behavior != material.behavior) {
    return object_error(object_id, "behavior cannot change; remove the object and add it again");
  }
  if (StaticObject* fixed = object->fixed()) {
    fixed->material = material;
    return {};
  }
  if (auto checked = check_material(object_id, material); !checked) return checked;
  if (RigidObject* rigid = object->rigid()) {
    if (material.fragile || rigid->pieces) {
      if (auto checked = check_break_impulse(object_id, material); !checked) return checked;
    }
    const double growth = material.mass_kg / rigid->material.mass_kg;
    rigid->material = material;
    for (const auto& body : rigid->bodies) {
      const Eigen::Vector3d spin = body->angular_velocity_rad_s;
      body->mass_kg = rigid->bodies.size() == 1 ? material.mass_kg : growth * body->mass_kg;
      body->friction.own = material.friction;
      body->restitution = material.restitution;
      body->set_angular_velocity(spin);
    }
    rigid->bonds.break_impulse_n_s = material.break_impulse_n_s;
    for (BondGraph::Piece& piece : rigid->bonds.pieces) {
      piece.mass_kg *= growth;
      piece.inertia *= growth;
    }
  } else {
    if (auto checked = check_stiffness(object_id, material); !checked) return checked;
    ElasticBody& body = *object->elastic()->body;
    const double budget = state_->settings.elastic_node_substeps;
    double left = budget;
    for (const ElasticObject* other : state_->elastic_objects) {
      if (other->object_id != object_id) left -= other->body->node_substeps();
    }
    body.set_node_substep_budget(
        std::max(left, budget / static_cast<double>(state_->elastic_objects.size())));
    body.set_material(material);
  }
  object->wake();
  return {};
}

Result<void> World::release_region(uint32_t object_id, const std::string& region) {
  WorldObject* object = state_->find(object_id);
  ElasticObject* elastic = object ? object->elastic() : nullptr;
  if (!elastic || !elastic->body->release_region(region)) {
    return not_found(object_name(object_id) + ": no fixed or moved region is named " + region +
                     "; name one of the object");
  }
  object->wake();
  return {};
}

const Material* World::material(uint32_t object_id) const {
  const WorldObject* object = state_->find(object_id);
  if (!object) return nullptr;
  if (const StaticObject* fixed = object->fixed()) return &fixed->material;
  if (const RigidObject* rigid = object->rigid()) return &rigid->material;
  return &object->elastic()->body->material();
}

std::vector<WorldEvent> World::take_events() { return std::exchange(state_->events, {}); }

}  // namespace livegs
