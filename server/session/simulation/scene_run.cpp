// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/simulation/scene_run.h"

#include <span>

#include "core/clock.h"
#include "core/log.h"

namespace livegs {
namespace {

// `later`: the changes of the same tick after this one.
void apply(Scene& scene, const v1::SceneChange& change, std::span<const v1::SceneChange> later) {
  if (change.has_edit()) {
    if (auto edited = scene.edit(change.edit()); !edited)
      log_warn("edit: %s", edited.error().message.c_str());
  } else if (change.has_environment()) {
    if (auto replaced = scene.replace_environment(change.environment(), later); !replaced)
      log_warn("environment: %s", replaced.error().message.c_str());
  } else if (change.has_carry()) {
    scene.carry(change.carry());
  } else if (change.has_force()) {
    scene.apply_force(change.force());
  } else if (change.has_set_physics()) {
    const std::string& name = change.set_physics().object();
    const SceneObject* object = scene.find(name);  // by name: a reset assigns new ids
    if (!object) return;
    const auto set = scene.set_physics(object->id, change.set_physics().physics());
    if (!set) log_warn("%s: %s", name.c_str(), set.error().message.c_str());
  }
}

}  // namespace

SceneRun::SceneRun(Scene scene)
    : scene_(std::move(scene)),
      tick_(scene_.world().tick()),
      simulated_ns_(scene_.world().drivers().simulated_ns) {
  for (const SceneObject& object : scene_.objects()) known_ids_.insert(object.id);
}

void SceneRun::replace(Scene next) {
  simulated_before_ns_ = simulated_ns_;
  for (const SceneObject& object : scene_.objects()) controls_.release_object(scene_, object.id);
  replaced_.assign(known_ids_.begin(), known_ids_.end());
  (void)next.take_changes();  // every object of the scene is new
  scene_ = std::move(next);
  scene_is_new_ = true;
}

void SceneRun::apply(const TickActions& actions) {
  const double now_s = static_cast<double>(tick_) / scene_.world().settings().rate_hz;
  const std::span changes(actions.changes);
  for (size_t i = 0; i < changes.size(); ++i) livegs::apply(scene_, changes[i], changes.subspan(i + 1));
  for (const SessionNumber session : actions.over) {
    controls_.on_session_closed(scene_, session);
    applied_.erase(session);
  }
  for (const SessionSamples& one : actions.samples) {
    for (const InputSample& sample : one.samples) controls_.apply(scene_, one.session, sample);
    if (!one.samples.empty()) applied_[one.session] = one.samples.back().sequence;
  }
  controls_.shoot(scene_, now_s);
  for (const SessionNumber session : actions.released) controls_.release(scene_, session);
  scene_.take_cuts(actions.cuts);
}

TickResult SceneRun::advance(const TickActions& actions) {
  apply(actions);
  TickResult tick;
  const int64_t begun_ns = now_ns();
  actions.stepped ? scene_.step() : scene_.place_carried();
  ++tick_;
  tick.stepped_ns = now_ns();
  tick.step_ms = milliseconds_from_ns(tick.stepped_ns - begun_ns);
  tick.drivers = scene_.world().drivers();
  tick.run.simulated_s = seconds_from_ns(tick.drivers.simulated_ns);
  tick.drivers.tick = tick_;
  simulated_ns_ = tick.drivers.simulated_ns += simulated_before_ns_;
  note_changes(tick);
  for (const auto& [session, sequence] : applied_) {
    tick.hands.push_back({session, sequence, controls_.held_points(scene_, session)});
  }
  for (const uint32_t id : tick.removed) known_ids_.erase(id);
  for (const SceneObject& object : tick.added) known_ids_.insert(object.id);
  return tick;
}

void SceneRun::note_changes(TickResult& tick) {
  Scene::Changes changes = scene_.take_changes();
  tick.cuts = std::move(changes.cut);
  for (const uint32_t id : changes.removed) controls_.release_object(scene_, id);
  if (std::exchange(scene_is_new_, false)) {
    tick.scene_is_new = true;
    tick.added.assign(scene_.objects().begin(), scene_.objects().end());
    tick.removed = std::exchange(replaced_, {});
    return;
  }
  for (const uint32_t id : changes.added) {
    if (const SceneObject* object = scene_.find(id)) tick.added.push_back(*object);
  }
  for (const uint32_t id : changes.changed) {
    if (const SceneObject* object = scene_.find(id)) tick.changed.push_back(*object);
  }
  tick.removed = std::move(changes.removed);
}

}  // namespace livegs
