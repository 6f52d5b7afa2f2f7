// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scene_analysis.h"

#include <algorithm>
#include <map>

#include "analysis/physics_file.h"
#include "scene/scene_drawing.h"
#include "scene/target_views.h"

namespace livegs {

struct SceneAnalysis::Snapshot {
  std::vector<Object> objects;
  ViewedScene viewed;
};

Result<SceneAnalysis> SceneAnalysis::of(const Scene& scene, bool with_kernels) {
  auto snapshot = std::make_shared<Snapshot>();
  SceneDrawing drawing;
  std::map<uint32_t, Eigen::Vector3d> centres_m;  // of what is drawn; the origin without kernels
  if (with_kernels) {
    auto drawn = drawing.pose(scene);
    if (!drawn) return drawn.error();
    for (const DrawnObject& one : *drawn) {
      snapshot->viewed.objects.push_back({one.object_id, scene.find(one.object_id)->asset, *one.kernels});
      Eigen::AlignedBox3d bounds;
      for (const Eigen::Vector3f& at : one.kernels->positions_m) bounds.extend(at.cast<double>());
      if (!bounds.isEmpty()) centres_m[one.object_id] = bounds.center();
    }
  }
  for (const SceneObject& object : scene.objects()) {
    if (!object.facts) continue;
    Object known;
    known.name = object.name;
    known.written = object.written;
    known.built = scene.built_as(object);
    known.physics_file = object.physics_file;
    known.target.object_id = object.id;
    known.target.facts = object.facts;
    known.target.offline = estimate_offline(*object.facts);
    *known.target.offline.mutable_longest_side_m() = object.physics.longest_side_m();
    known.target.position_m = centres_m.contains(object.id) ? centres_m[object.id] : Eigen::Vector3d::Zero();
    snapshot->objects.push_back(std::move(known));
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
                     "\" that can be analysed; it has: " + (all.empty() ? "nothing" : all));
  }
  for (const Object& one : snapshot_->objects) {
    const bool wanted = names.empty() ? one.written.behavior() == v1::Physics::AUTO
                                      : std::find(names.begin(), names.end(), one.name) != names.end();
    if (wanted) targets.push_back(one.target);
  }
  return targets;
}

const std::vector<SceneAnalysis::Object>& SceneAnalysis::objects() const { return snapshot_->objects; }

TargetViews SceneAnalysis::views() const {
  return [snapshot = snapshot_](uint32_t object_id, int count, std::stop_token stop) {
    return target_views(snapshot->viewed, object_id, count, std::move(stop));
  };
}

Result<v1::PhysicalParameters> layered_physics(const v1::PhysicsFile& file, const v1::Physics& written,
                                               const ObjectFacts& facts, std::string& note) {
  auto kept = with_physics_file(estimate_offline(facts), file, facts, note);
  if (!kept) return kept.error();
  return merge_scene_physics(*kept, written, facts);
}

}  // namespace livegs
