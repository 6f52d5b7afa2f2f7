// SPDX-License-Identifier: GPL-3.0-or-later
// Elastic bodies that a device steps for a whole tick, before the substeps of all others.
#include <set>
#include <vector>

#include "physics/elastic_device.h"
#include "physics/world/world_state.h"

namespace livegs {

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
  FlatTick flat_tick;
  flat_tick.start_s = start_s;
  flat_tick.duration_s = tick_s;
  flat_tick.substeps = settings.substeps;
  flat_tick.gravity_m_s2 = settings.gravity_m_s2;
  flat_tick.colliders = colliders;
  device->step(bodies, flat_tick);
  for (size_t i = 0; i < bodies.size(); ++i) objects_of_bodies[i]->stepped = !bodies[i].reason;
}

}  // namespace livegs
