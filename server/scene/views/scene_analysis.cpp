// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/views/scene_analysis.h"

#include <algorithm>
#include <map>

#include "analysis/physics_file.h"
#include "core/text/shown_text.h"
#include "scene/check/check_object.h"
#include "scene/values/scene_values.h"
#include "scene/views/target_views.h"
#include "skin/skin_kernels.h"

namespace livegs {

struct SceneAnalysis::Snapshot {
  std::vector<Object> objects;
  ViewedScene viewed;
  bool with_kernels = false;
};

namespace {

// Poses the kernels as at the start of the scene, undeformed. The drivers of the body are not used: they
// depend on the material (centre of mass, cells), and a query must not depend on its answer.
Result<PosedKernels> placed_kernels(const SceneObject& object, const Similarity& object_from_asset,
                                    const Pose& world_from_object) {
  RestBody rest;
  rest.object_from_asset = object_from_asset;
  rest.bodies.emplace_back();
  auto bindings = bind_kernels(*object.asset, rest);
  if (!bindings) return Error{bindings.error().code, object.name + ": " + bindings.error().message};
  ObjectDrivers drivers;
  drivers.poses = {world_from_object};
  PosedKernels kernels;
  skin_kernels(*object.asset, rest, *bindings, drivers, kernels);
  return kernels;
}

Result<SceneAnalysis::Object> known_of(const SceneObject& object, const BodyTypeLock& built) {
  SceneAnalysis::Object known;
  known.name = object.name;
  known.written = object.written;
  known.built = built;
  known.physics_file = object.physics_file;
  known.target.facts = object.facts;
  known.target.position_m.setZero();
  known.known = object.physics;
  v1::PhysicsFile file;
  if (!object.physics_file.empty()) {
    auto kept = read_physics_file(object.physics_file);
    if (!kept) return kept.error();
    file = std::move(*kept);
  }
  auto offline = offline_physics(file, object.written, *object.facts);
  if (!offline) return Error{offline.error().code, object.name + ": " + offline.error().message};
  known.target.offline = std::move(*offline);
  *known.target.offline.mutable_longest_side_m() = object.physics.longest_side_m();
  return known;
}

// Returns world_from_object of all objects, in the scene's order. Objects of the file are at their initial
// poses. The environment and balls are at their current poses, which do not depend on estimated parameters.
std::vector<Pose> places_of(const Scene& scene) {
  std::vector<Pose> places;
  const DriverFrame now = scene.world().drivers();
  std::map<std::string, Pose> initial;  // checked when the file was read
  for (int i = 0; i < scene.file().objects_size(); ++i) {
    const v1::Object& object = scene.file().objects(i);
    initial[object_name(object, i)] = pose_value(object.pose(), "").value();
  }
  for (const SceneObject& object : scene.objects()) {
    Pose place;
    if (object.facts) {
      place = initial[object.name];
    } else {
      for (const ObjectDrivers& drivers : now.objects) {
        if (drivers.object_id == object.id) place = drivers.poses.at(0) * object.rest.bodies.at(0).inverse();
      }
    }
    places.push_back(place);
  }
  return places;
}

}  // namespace

Result<SceneAnalysis> SceneAnalysis::of(const Scene& scene, bool with_kernels) {
  auto snapshot = std::make_shared<Snapshot>();
  std::map<uint32_t, Eigen::Vector3d> centres_m;  // empty without kernels: all objects are at the origin
  if (with_kernels) {
    const std::vector<Pose> places = places_of(scene);
    for (size_t i = 0; i < places.size(); ++i) {
      const SceneObject& object = scene.objects()[i];
      auto kernels = placed_kernels(object, object.rest.object_from_asset, places[i]);
      if (!kernels) return kernels.error();
      Eigen::AlignedBox3d bounds;
      for (const Eigen::Vector3f& at : kernels->positions_m) bounds.extend(at.cast<double>());
      if (!bounds.isEmpty()) centres_m[object.id] = bounds.center();
      snapshot->viewed.objects.push_back({object.id, object.asset, std::move(*kernels)});
    }
  }
  for (const SceneObject& object : scene.objects()) {
    if (!object.facts) continue;
    auto known = known_of(object, scene.body_type_lock(object));
    if (!known) return known.error();
    known->target.object_id = object.id;
    if (centres_m.contains(object.id)) known->target.position_m = centres_m[object.id];
    snapshot->objects.push_back(std::move(*known));
  }
  snapshot->with_kernels = with_kernels;
  SceneAnalysis analysis;
  analysis.snapshot_ = std::move(snapshot);
  return analysis;
}

Result<SceneAnalysis> SceneAnalysis::changed(const std::vector<std::string>& gone,
                                             std::span<const BuiltObject> fresh, uint32_t first_id) const {
  auto snapshot = std::make_shared<Snapshot>(*snapshot_);
  for (const std::string& name : gone) {
    const auto found = std::find_if(snapshot->objects.begin(), snapshot->objects.end(),
                                    [&](const Object& one) { return one.name == name; });
    if (found == snapshot->objects.end()) continue;
    std::erase_if(snapshot->viewed.objects,
                  [&](const auto& one) { return one.object_id == found->target.object_id; });
    snapshot->objects.erase(found);
  }
  for (const BuiltObject& one : fresh) {
    const bool rigid = std::holds_alternative<RigidBodyDescription>(one.body);
    auto known = known_of(one.drawn, {one.drawn.physics.behavior(), rigid, one.drawn.physics.parts()});
    if (!known) return known.error();
    known->target.object_id = first_id++;
    const Pose pose = std::visit([](const auto& body) { return body.world_from_object; }, one.body);
    known->target.position_m = pose.position_m;
    if (snapshot->with_kernels) {
      auto kernels = placed_kernels(one.drawn, one.object_from_asset, pose);
      if (!kernels) return kernels.error();
      snapshot->viewed.objects.push_back({known->target.object_id, one.drawn.asset, std::move(*kernels)});
    }
    snapshot->objects.push_back(std::move(*known));
  }
  SceneAnalysis analysis;
  analysis.snapshot_ = std::move(snapshot);
  return analysis;
}

Result<std::vector<AnalysisTarget>> SceneAnalysis::targets(const std::vector<std::string>& names) const {
  std::vector<AnalysisTarget> targets;
  for (const std::string& name : names) {
    const bool known = std::any_of(snapshot_->objects.begin(), snapshot_->objects.end(),
                                   [&](const Object& one) { return one.name == name; });
    if (known) continue;
    std::string all;
    for (const Object& one : snapshot_->objects) all += (all.empty() ? "" : ", ") + one.name;
    return not_found("object: the scene has no \"" + shown_text(name, 80) +
                     "\" that can be analysed; available: " + (all.empty() ? "none" : all));
  }
  for (const Object& one : snapshot_->objects) {
    const bool wanted = names.empty() ? one.written.behavior() == v1::Physics::AUTO
                                      : std::find(names.begin(), names.end(), one.name) != names.end();
    if (wanted) targets.push_back(one.target);
  }
  return targets;
}

const std::vector<SceneAnalysis::Object>& SceneAnalysis::objects() const { return snapshot_->objects; }

std::vector<AnalysisNeighbour> SceneAnalysis::neighbours(std::span<const AnalysisTarget> targets) const {
  std::vector<AnalysisNeighbour> others;
  for (const Object& one : snapshot_->objects) {
    const bool asked = std::any_of(targets.begin(), targets.end(), [&](const AnalysisTarget& target) {
      return target.object_id == one.target.object_id;
    });
    if (!asked) others.push_back({one.target.facts, one.known, one.target.position_m});
  }
  return others;
}

TargetViews SceneAnalysis::views() const {
  return [snapshot = snapshot_](uint32_t object_id, int count, std::stop_token stop) {
    return target_views(snapshot->viewed, object_id, count, std::move(stop));
  };
}

std::shared_ptr<const ObjectFacts> facts_by_name(const SceneAnalysis::Object& object,
                                                 const v1::PhysicsFile& file) {
  const std::string& name = file.name().empty() ? object.name : file.name();
  if (object.target.facts->name == name) return object.target.facts;
  ObjectFacts facts = *object.target.facts;
  facts.name = name;
  return std::make_shared<const ObjectFacts>(std::move(facts));
}

Result<v1::PhysicalParameters> layered_physics(const v1::PhysicsFile& file, const v1::Physics& written,
                                               const ObjectFacts& facts, std::string& note) {
  auto kept = with_physics_file(estimate_offline(facts), file, facts, note);
  if (!kept) return kept.error();
  return merge_scene_physics(*kept, written, facts);
}

Result<v1::PhysicalParameters> offline_physics(const v1::PhysicsFile& file, const v1::Physics& written,
                                               const ObjectFacts& facts) {
  v1::PhysicsFile edits;
  *edits.mutable_edits() = file.edits();
  std::string note;
  return layered_physics(edits, written, facts, note);
}

}  // namespace livegs
