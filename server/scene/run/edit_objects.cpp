// SPDX-License-Identifier: GPL-3.0-or-later
// Edits of a running scene: objects that are added, removed, changed or carried.
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/log.h"
#include "livegs/v1/recording.pb.h"
#include "scene/build/add_joints.h"
#include "scene/build/build_cache.h"
#include "scene/build/build_object.h"
#include "scene/build/fragile_object.h"
#include "scene/check/check_object.h"
#include "scene/check/check_scene.h"
#include "scene/check/joint_parts.h"
#include "scene/check/object_references.h"
#include "scene/check/sidecar_paths.h"
#include "scene/environment/environment.h"
#include "scene/scene.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

// A carried object is released if no call arrives for this time.
constexpr double kCarryTimeout_s = 0.5;
// Fastest turn of a carried object, rad/s.
constexpr double kMaxCarryTurn_rad_s = 2.0 * M_PI;
// A standing object with a wider gap below it is not asleep at the start: it falls.
constexpr double kMaxStandingGap_m = 0.01;

// Whether both are built into the same body and asset, at whatever pose.
bool same_body(v1::Object a, v1::Object b) {
  for (v1::Object* one : {&a, &b}) {
    one->clear_pose();
    one->clear_hidden();
    one->clear_locked();
    one->clear_group();
    one->clear_part();
  }
  return google::protobuf::util::MessageDifferencer::Equals(a, b);
}

// The number of objects if no object has the name.
int object_index(const v1::Scene& file, const std::string& name) {
  int index = 0;
  while (index < file.objects_size() && object_name(file.objects(index), index) != name) ++index;
  return name.empty() ? file.objects_size() : index;
}

bool is_jointed(const v1::Scene& file, const std::string& name) {
  return std::any_of(file.joints().begin(), file.joints().end(), [&](const v1::Joint& joint) {
    const JointParts parts = parts_of(joint);
    return parts.object == name || parts.other == name;
  });
}

}  // namespace

void Scene::settle(std::span<const uint32_t> standing) {
  if (!options_.sleep) return;
  for (const uint32_t id : standing) {
    if (world_->distance_down_m(id, kMaxStandingGap_m)) world_->put_to_sleep(id);
  }
}

void Scene::remove_object(uint32_t object_id) {
  world_->remove(object_id);
  std::erase_if(cutting_, [&](const FragileTask& task) { return task.object_id() == object_id; });
  std::erase_if(objects_, [&](const SceneObject& one) { return one.id == object_id; });
  cuttable_.erase(object_id);
  cut_keys_.erase(object_id);
  standing_.erase(object_id);
  carried_.erase(object_id);
  changes_.removed.push_back(object_id);
}

Pose Scene::pose_of(uint32_t object_id) const {
  const Eigen::Vector3d origin = world_->world_point(object_id, Eigen::Vector3d::Zero());
  if (const ElasticBody* body = world_->elastic_body(object_id)) {
    // The best-fit rotation, through the middle of the body, which a bent part does not move.
    const Eigen::Quaterniond rotation = body->centre_pose().orientation;
    const Eigen::Vector3d middle = centre_of(object_id);
    return {world_->world_point(object_id, middle) - rotation * middle, rotation};
  }
  Eigen::Matrix3d axes;
  for (int axis = 0; axis < 3; ++axis)
    axes.col(axis) = world_->world_point(object_id, Eigen::Vector3d::Unit(axis)) - origin;
  return {origin, Eigen::Quaterniond(axes).normalized()};
}

Result<void> Scene::edit(const v1::SceneChange::Edit& edit) {
  const int index = object_index(file_, edit.object());
  const bool exists = !edit.object().empty() && index < file_.objects_size();
  if (!edit.object().empty() && !exists)
    return not_found("object \"" + edit.object() + "\": is not in the scene");
  if (edit.has_after()) {  // a recording may say anything
    if (auto checked = check_object(edit.after(), "edit"); !checked) return checked;
  }
  const SceneObject* present = exists ? find_in_file(edit.object()) : nullptr;
  // Standing objects sleep without contacts that would wake them.
  std::vector<uint32_t> supported;
  for (const auto& [id, standing] : standing_) {
    if (standing && (!present || id != present->id) && world_->distance_down_m(id, kMaxStandingGap_m))
      supported.push_back(id);
  }
  const auto wake_unsupported = [&] {
    for (const uint32_t id : supported) {
      // An object that is set where it is wakes.
      if (!world_->distance_down_m(id, kMaxStandingGap_m)) (void)world_->place(id, pose_of(id));
    }
  };
  if (!edit.has_after()) {
    if (!present) return invalid_argument("edit: names no object and has none to add");
    remove_object(present->id);
    file_.mutable_objects()->DeleteSubrange(index, 1);
    report_mass_ratios();
    wake_unsupported();
    return {};
  }

  v1::Object after = edit.after();
  const std::string name = object_name(after, index);
  if (present && same_body(file_.objects(index), after) && !is_jointed(file_, edit.object())) {
    const v1::Object before = file_.objects(index);
    SceneObject& object = drawn(present->id);
    const bool moved = !google::protobuf::util::MessageDifferencer::Equals(before.pose(), after.pose());
    const bool placed = !moved || world_->place(object.id, body_pose(after, object.lift_m));
    if (placed) {
      *file_.mutable_objects(index) = after;
      object.hidden = after.hidden();
      changes_.changed.push_back(object.id);
      carried_.erase(object.id);
      if (moved && standing_.at(object.id)) settle(std::array{object.id});
      if (moved) wake_unsupported();
      return {};
    }
  }

  // The object is built again, or for the first time.
  v1::Scene next = file_;
  if (exists) {
    if (name != edit.object()) rename_references(next, edit.object(), name);
    *next.mutable_objects(index) = after;
  } else {
    *next.add_objects() = after;
  }
  const std::vector<std::filesystem::path> kept_in = sidecar_paths(next, folder_, name_);
  const ObjectSidecar sidecar{kept_in[static_cast<size_t>(index)], &edit.sidecar()};
  const std::string field = "objects[" + std::to_string(index) + "]";
  const WorldSettings& settings = world_->settings();
  auto built = options_.cache
                   ? build_cached_object(*options_.cache, after, folder_, index, field, settings, sidecar)
                   : build_object(after, folder_, index, field, settings, sidecar);
  if (!built) return built.error();
  if (auto* elastic = std::get_if<ElasticBodyDescription>(&built->body); elastic && !elastic->own_budget) {
    // The unused part of the scene's budget, or an equal share of the budget.
    double used = 0.0, bodies = 1.0;
    for (const SceneObject& object : objects_) {
      const ElasticBody* body = world_->elastic_body(object.id);
      if (!body || (present && object.id == present->id)) continue;
      used += body->node_substeps();
      bodies += 1.0;
    }
    elastic->scene_node_substeps = settings.elastic_node_substeps;
    elastic->max_node_substeps =
        std::max(settings.elastic_node_substeps - used, settings.elastic_node_substeps / bodies);
  }
  std::swap(file_, next);  // the cut of a fragile object is seeded by its place in the file
  const std::optional<uint32_t> old_id = present ? std::optional(present->id) : std::nullopt;
  const auto id = add_built(*built);
  if (!id) {
    std::swap(file_, next);
    return id.error();
  }
  if (old_id) remove_object(*old_id);
  report_mass_ratios();
  if (options_.wait_for_pieces && !cutting_.empty() && cutting_.back().object_id() == *id) {
    finish_cut(cutting_.back());
    cutting_.pop_back();
  }
  v1::Scene joined;
  for (const v1::Joint& joint : file_.joints()) {
    const JointParts parts = parts_of(joint);
    if (parts.object == name || parts.other == name) *joined.add_joints() = joint;
  }
  const auto by_name = [&](const std::string& object) { return find_in_file(object); };
  if (auto added = add_joints(joined, by_name, *world_); !added)
    log_warn("%s: %s", name.c_str(), added.error().message.c_str());
  if (standing_.at(*id)) settle(std::array{*id});
  wake_unsupported();
  return {};
}

Result<void> Scene::replace_environment(const v1::Environment& environment,
                                        std::span<const v1::SceneChange> later) {
  v1::Scene next = file_;
  *next.mutable_environment() = environment;
  if (auto checked = check_scene(next); !checked) return checked;  // a recording may say anything
  auto made = kept_environment(options_.cache.get(), environment, folder_);
  if (!made) {
    v1::Scene around = next;
    std::map<std::string, const v1::PhysicsFile*> sidecars;  // by name of the object
    for (const SceneObject& object : objects_)
      if (object.sidecar) sidecars[object.name] = object.sidecar.get();
    for (const v1::SceneChange& change : later) {
      if (!change.has_edit()) continue;
      const v1::SceneChange::Edit& edit = change.edit();
      if (edit.has_after()) {
        if (auto checked = check_object(edit.after(), "edit"); !checked) return checked;
        sidecars[edit.after().name()] = &edit.sidecar();
      }
      auto& all = *around.mutable_objects();
      const int index = object_index(around, edit.object());
      if (!edit.has_after() && index < all.size())
        all.DeleteSubrange(index, 1);
      else if (edit.has_after())
        *(index < all.size() ? &all[index] : all.Add()) = edit.after();
    }
    const std::vector<std::filesystem::path> kept_in = sidecar_paths(around, folder_, name_);
    std::vector<std::optional<Result<BuiltObject>>> built;
    for (int i = 0; i < around.objects_size(); ++i) {
      const std::string field = "objects[" + std::to_string(i) + "]";
      const auto known = sidecars.find(object_name(around.objects(i), i));
      const ObjectSidecar sidecar{kept_in[static_cast<size_t>(i)],
                                  known == sidecars.end() ? nullptr : known->second};
      built.emplace_back(
          options_.cache ? build_cached_object(*options_.cache, around.objects(i), folder_, i, field,
                                               world_->settings(), sidecar)
                         : build_object(around.objects(i), folder_, i, field, world_->settings(), sidecar));
      if (!*built.back()) return built.back()->error();
    }
    auto fresh = build_environment(options_.cache.get(), environment, folder_, built);
    if (!fresh) return fresh.error();
    made = *std::move(fresh);
  }
  file_ = std::move(next);
  world_->remove_colliders(0);
  if (environment_id_) {
    world_->remove(*environment_id_);
    std::erase_if(objects_, [&](const SceneObject& one) { return one.id == *environment_id_; });
    changes_.removed.push_back(*environment_id_);
  }
  return add_environment(*made);
}

void Scene::carry(const v1::SceneChange::Carry& carry) {
  const SceneObject* object = find_in_file(carry.object());
  if (!object || object->physics.behavior() == v1::Physics::STATIC) return;
  if (!carry.has_pose()) {
    if (const auto held = carried_.find(object->id); held != carried_.end()) {
      (void)world_->place(object->id, held->second.at);
      carried_.erase(held);
    }
    return;
  }
  if (!pose_value(carry.pose(), "pose")) return;
  v1::Object at;
  *at.mutable_pose() = carry.pose();
  const auto [held, fresh] = carried_.try_emplace(object->id);
  if (fresh) held->second.at = pose_of(object->id);
  held->second.target = body_pose(at, object->lift_m);
  held->second.until_tick =
      world_->tick() + static_cast<uint64_t>(std::ceil(kCarryTimeout_s * world_->settings().rate_hz));
}

void Scene::place_carried() {
  for (auto& [id, held] : carried_) {
    held.at = held.target;
    (void)world_->place(id, held.at);
  }
}

void Scene::move_carried() {
  const double tick_s = 1.0 / world_->settings().rate_hz;
  for (auto at = carried_.begin(); at != carried_.end();) {
    const uint32_t id = at->first;
    Carried& held = at->second;
    if (world_->tick() >= held.until_tick) {
      (void)world_->place(id, held.at);
      at = carried_.erase(at);
      continue;
    }
    Eigen::Vector3d way = held.target.position_m - held.at.position_m;
    way *= std::min(1.0, kMaxCarrySpeed_m_s * tick_s / std::max(way.norm(), 1e-12));
    const Eigen::AngleAxisd turn(held.target.orientation * held.at.orientation.conjugate());
    const double full = std::remainder(turn.angle(), 2.0 * M_PI);
    const double angle = std::clamp(full, -kMaxCarryTurn_rad_s * tick_s, kMaxCarryTurn_rad_s * tick_s);
    const Pose next{held.at.position_m + way,
                    (Eigen::AngleAxisd(angle, turn.axis()) * held.at.orientation).normalized()};
    // The body's own velocity is that of its centre of mass, which turns about the frame's origin.
    const Eigen::Vector3d spin = angle / tick_s * turn.axis();
    const Eigen::Vector3d arm = world_->world_point(id, centre_of(id)) - held.at.position_m;
    if (!world_->place(id, held.at, way / tick_s + spin.cross(arm), spin)) {
      at = carried_.erase(at);  // a broken object; the edit at the end of the drag reports it
      continue;
    }
    held.at = next;
    ++at;
  }
}

Eigen::Vector3d Scene::centre_of(uint32_t object_id) const {
  const SceneObject& object = *find(object_id);
  if (!object.rest.bodies.empty()) return object.rest.bodies.front().position_m;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : object.rest_particles_m) middle += point;
  return middle / std::max<double>(1.0, static_cast<double>(object.rest_particles_m.size()));
}

}  // namespace livegs
