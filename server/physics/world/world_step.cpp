// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <set>
#include <utility>

#include "core/clock.h"
#include "core/parallel_for.h"
#include "physics/elastic/step_elastic_bodies.h"
#include "physics/elastic_device.h"
#include "physics/world/world_state.h"

namespace livegs {

void World::State::clear_ended_forces(double now_s) {
  // A force that ends with a tick has ended in spite of rounding.
  const double ended_s = now_s + 1e-9 / settings.rate_hz;
  std::erase_if(forces, [&](const auto& force) {
    if (force.second.end_s > ended_s) return false;
    if (WorldObject* object = find(force.second.object_id)) object->wake();
    return true;
  });
}

// Gathers forces and springs at the start of the substep.
void World::State::gather_loads(double start_s, double duration_s) {
  std::fill(loads.begin(), loads.end(), RigidLoad{});
  for (ElasticObject* elastic : elastic_objects) elastic->forces.clear();

  const auto push = [&](WorldObject& object, const Eigen::Vector3d& rest_point,
                        const Eigen::Vector3d& force) {
    if (ElasticObject* elastic = object.elastic()) elastic->forces.push_back({rest_point, force});
    if (RigidObject* rigid = object.rigid()) {
      RigidBody& body = rigid->body_with(rest_point);
      RigidLoad& load = loads[rigid_index(body.body_id())];
      load.impulse_n_s += duration_s * force;
      // A sleeping body's load is unchanged, and its record is not read.
      if (!body.asleep) body.record_force(duration_s * force, body.arm_of(rest_point));
      load.angular_impulse += duration_s * body.arm_of(rest_point).cross(force);
    }
  };
  for (const auto& [id, held] : forces) {
    const double share = std::clamp((held.end_s - start_s) / duration_s, 0.0, 1.0);
    if (WorldObject* object = find(held.object_id); object && share > 0.0)
      push(*object, held.force.point_m, share * held.force.force_n);
  }
  gather_springs(duration_s);
}

// Steps elastic bodies that nothing else touches in this tick for the whole tick, before the substeps of all
// others.
void World::State::step_on_device(double start_s, double tick_s) {
  for (ElasticObject* elastic : elastic_objects) elastic->stepped = false;
  ElasticDevice* device = elastic_device();
  if (!device || elastic_objects.empty()) return;
  std::set<uint32_t> pulled;
  for (const auto& [id, force] : forces) pulled.insert(force.object_id);
  for (const auto& [id, spring] : springs) pulled.insert(spring.object_id);
  for (const auto& [id, grab] : grabs) pulled.insert(grab.object_id);

  build_elastic_groups(tick_s);  // for the neighbours within the tick
  std::vector<DeviceBody> bodies;
  std::vector<ElasticObject*> objects_of_bodies;
  for (ElasticObject* elastic : elastic_objects) {
    auto* flat = dynamic_cast<FlatBody*>(elastic->body.get());
    const bool alone =
        elastic->near_bodies.empty() && elastic->near_elastic.empty() && !pulled.contains(elastic->object_id);
    if (!flat || !alone || elastic->body->asleep()) continue;
    bodies.push_back({flat, {}});
    objects_of_bodies.push_back(elastic);
  }
  if (bodies.empty()) return;
  device->step(bodies, {.start_s = start_s,
                        .duration_s = tick_s,
                        .substeps = settings.substeps,
                        .gravity_m_s2 = settings.gravity_m_s2,
                        .colliders = colliders,
                        .forces = {}});
  for (size_t i = 0; i < bodies.size(); ++i) objects_of_bodies[i]->stepped = !bodies[i].reason;
}

// Groups run on different threads.
void World::State::step_elastic(double start_s, double duration_s) {
  const auto groups = build_elastic_groups(duration_s);
  parallel_for(groups.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      for (const CoupledBodies& together : groups[i]) {
        std::vector<SteppedBody> stepped;
        for (ElasticObject* elastic : together) {
          const SubstepContext context{start_s,
                                       duration_s,
                                       settings.gravity_m_s2,
                                       colliders,
                                       elastic->near_bodies,
                                       elastic->near_elastic,
                                       elastic->forces,
                                       &elastic->contacts_this_tick};
          stepped.push_back({elastic->body.get(), context, &elastic->contact_rows});
        }
        step_elastic_bodies(stepped);  // sleeping bodies wake on contact
      }
    }
  });
  apply_elastic_impulses(duration_s);
}

void World::State::step_rigid(double duration_s) {
  if (elastic_objects.empty()) {
    step_rigid_bodies(rigid_bodies, loads, colliders, settings.gravity_m_s2, duration_s, broad_phase);
    return;
  }
  for (size_t i = 0; i < rigid_bodies.size(); ++i) {
    // Excludes the impulses of elastic bodies.
    const RigidBody& body = *rigid_bodies[i];
    velocity_changes[i].velocity_m_s = body.velocity_m_s + rigid_proxies[i].impulse_n_s / body.mass_kg;
    velocity_changes[i].spin_rad_s =
        body.angular_velocity_rad_s + body.inverse_inertia * rigid_proxies[i].angular_impulse;
  }
  step_rigid_bodies(rigid_bodies, loads, colliders, settings.gravity_m_s2, duration_s, broad_phase);
  for (size_t i = 0; i < rigid_bodies.size(); ++i) {
    velocity_changes[i].velocity_m_s = rigid_bodies[i]->velocity_m_s - velocity_changes[i].velocity_m_s;
    velocity_changes[i].spin_rad_s = rigid_bodies[i]->angular_velocity_rad_s - velocity_changes[i].spin_rad_s;
  }
}

void World::State::report_contacts() {
  const auto report = [&](uint32_t id, double impulse, const Eigen::Vector3d& moment) {
    if (impulse > kReportedImpulse_n_s) {
      events.push_back({tick, WorldEventKind::Contact, id, impulse, moment / impulse});
    }
  };
  for (const auto& [id, object] : listed_objects) {
    if (RigidObject* rigid = object->rigid()) {
      double impulse = 0.0;
      Eigen::Vector3d moment = Eigen::Vector3d::Zero();
      for (const auto& body : rigid->bodies) {
        body->last_tick_contact_impulse_n_s = std::exchange(body->contact_impulse_n_s, 0.0);
        impulse += std::exchange(body->external_contact_impulse_n_s, 0.0);
        moment += std::exchange(body->external_contact_moment, Eigen::Vector3d::Zero());
      }
      report(id, impulse, moment);
    } else if (ElasticObject* elastic = object->elastic()) {
      const ContactTotal total = elastic->body->take_contact_total();
      elastic->last_tick_contact_impulse_n_s = total.impulse_n_s;
      report(id, total.impulse_n_s, total.moment);
    }
  }
}

void World::State::report_sleep() {
  for (const auto& [id, object] : listed_objects) {
    const bool asleep = object->asleep();
    if (asleep == object->reported_asleep) continue;
    object->reported_asleep = asleep;
    WorldEvent event{tick, asleep ? WorldEventKind::Sleep : WorldEventKind::Wake, id};
    if (const RigidObject* rigid = object->rigid())
      event.point_m = rigid->bodies[0]->world_from_body.position_m;
    if (const ElasticObject* elastic = object->elastic()) event.point_m = elastic->body->centre_m();
    events.push_back(event);
  }
}

void World::step() {
  State& state = *state_;
  const int64_t begin_ns = now_ns();
  const double tick_s = 1.0 / state.settings.rate_hz;
  const double duration_s = tick_s / state.settings.substeps;
  const double now_s = static_cast<double>(state.tick) * tick_s;
  state.times = {};
  state.clear_ended_forces(now_s);
  ++state.tick;
  state.wake_islands();
  for (RigidBody* body : state.rigid_bodies) body->tick_energy_j = state.energy_j(*body);
  const int64_t device_ns = now_ns();
  state.step_on_device(now_s, tick_s);
  state.times.elastic_ms += milliseconds_from_ns(now_ns() - device_ns);
  for (int substep = 0; substep < state.settings.substeps; ++substep) {
    const double start_s = now_s + substep * duration_s;
    state.gather_loads(start_s, duration_s);
    const int64_t elastic_ns = now_ns();
    state.step_elastic(start_s, duration_s);
    const int64_t rigid_ns = now_ns();
    state.step_rigid(duration_s);
    state.times.elastic_ms += milliseconds_from_ns(rigid_ns - elastic_ns);
    state.times.rigid_ms += milliseconds_from_ns(now_ns() - rigid_ns);
  }
  const int64_t end_ns = now_ns();
  parallel_for(state.elastic_objects.size(), 1, [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) state.elastic_objects[i]->body->end_frame(tick_s);
  });
  state.times.elastic_ms += milliseconds_from_ns(now_ns() - end_ns);
  state.process_impacts();
  state.sleep_islands(tick_s);
  state.report_contacts();
  state.report_sleep();
  // The oldest pending events are discarded.
  if (state.events.size() > 65536) state.events.erase(state.events.begin(), state.events.end() - 65536);
  state.times.total_ms = milliseconds_from_ns(now_ns() - begin_ns);
}

}  // namespace livegs
