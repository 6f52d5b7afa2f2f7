// SPDX-License-Identifier: Apache-2.0
#include "viewer/author/scene_editor.h"

#include <algorithm>
#include <cmath>

#include "core/text/format_text.h"
#include "viewer/author/object_pose.h"

namespace livegs {
namespace {

constexpr double kDuplicateShift_m = 0.3;  // of a copy, along x
// Below this the estimate is shown as a question.
constexpr double kMinConfidence = 0.25;
constexpr std::array<v1::Physics::Behavior, 4> kBehaviors{v1::Physics::AUTO, v1::Physics::STATIC,
                                                          v1::Physics::RIGID, v1::Physics::ELASTIC};

void write_pose(const Pose& pose, v1::PlacedAt& message) {
  message.Clear();
  for (int axis = 0; axis < 3; ++axis) message.add_position_m(pose.position_m[axis]);
  const Eigen::Quaterniond& q = pose.orientation;
  for (const double part : {q.w(), q.x(), q.y(), q.z()}) message.add_orientation(part);
}

v1::ObjectEdit pose_edit(const std::string& name, const Pose& pose) {
  v1::ObjectEdit edit;
  edit.set_object(name);
  write_pose(pose, *edit.mutable_value()->mutable_pose());
  edit.add_fields("pose");
  return edit;
}

v1::ObjectEdit added_at(const std::string& asset, const Eigen::Vector3d& floor_m) {
  v1::ObjectEdit edit;
  v1::Object& object = *edit.mutable_value();
  object.set_asset(asset);
  object.set_standing(true);
  for (int axis = 0; axis < 3; ++axis) object.mutable_pose()->add_position_m(floor_m[axis]);
  edit.set_drop(true);
  return edit;
}

}  // namespace

const v1::Object* SceneEditor::described(const std::string& name) const {
  for (const v1::Object& object : document_.scene().objects()) {
    if (object.name() == name) return &object;
  }
  return nullptr;
}

ScenePanel SceneEditor::shown(const Objects& objects) const {
  ScenePanel panel;
  panel.available = document_.revision() > 0;
  if (!panel.available) return panel;
  panel.file = document_.file();
  panel.unsaved = document_.unsaved() || document_.file().empty();
  panel.undo = document_.undo();
  panel.redo = document_.redo();
  panel.notice = notice_;
  panel.progress = progress_;
  panel.suggested_file = document_.file().empty() ? "room.scene.json" : document_.file();
  panel.tool = tool_;
  panel.room = has_room();
  panel.snap = snap_;
  panel.grid = grid_;
  for (const v1::Object& object : document_.scene().objects()) {
    panel.entries.push_back(
        {object.name(), object.group(), selected_.contains(object.name()), object.hidden(), object.locked()});
    panel.selected += selected_.contains(object.name()) ? 1 : 0;
  }
  panel.labels.assign(assets_.labels().begin(), assets_.labels().end());
  panel.materials.assign(assets_.materials().begin(), assets_.materials().end());
  for (const auto& asset : assets_.assets()) panel.assets.push_back(asset.path());
  for (const v1::Bookmark& view : document_.scene().bookmarks()) panel.bookmarks.push_back(view.name());
  if (document_.scene().background_rgb_size() == 3) {
    const auto& rgb = document_.scene().background_rgb();
    panel.background = {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
  }
  if (selected_.size() != 1) return panel;
  const v1::Object* object = described(*selected_.begin());
  const auto now = objects.find(*selected_.begin());
  if (!object || now == objects.end()) return panel;
  ScenePanel::Fields fields;
  fields.name = object->name();
  fields.label = object->label();
  const EditedObject& running = now->second;
  fields.label_hint =
      running.confidence < kMinConfidence || running.estimated_label.empty()
          ? "unknown: say what it is"
          : format_text("%s? (%.0f %%)", running.estimated_label.c_str(), 100 * running.confidence);
  fields.group = object->group();
  fields.taken = object->part() > 0;
  fields.material = object->material();
  const auto behavior = std::find(kBehaviors.begin(), kBehaviors.end(), object->physics().behavior());
  fields.behavior = static_cast<int>(behavior - kBehaviors.begin()) % 4;
  if (object->has_asset()) fields.longest_side_m = running.longest_side_m;
  const Eigen::Vector3d angles = yaw_pitch_roll_deg(running.pose.orientation);
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<size_t>(axis);
    fields.position_m[at] = running.pose.position_m[axis];
    fields.angles_deg[at] = std::abs(angles[axis]) < 0.05 ? 0.0 : angles[axis];  // as shown, not -0.0
  }
  panel.fields = std::move(fields);
  return panel;
}

void SceneEditor::begin_edit(const std::string& what) {
  notice_.clear();
  progress_ = what;
}

v1::EditSceneRequest SceneEditor::edit_of_selection(const v1::Object& value,
                                                    const std::vector<std::string>& fields) const {
  v1::EditSceneRequest request;
  for (const std::string& name : selected_) {
    v1::ObjectEdit& edit = *request.add_objects();
    edit.set_object(name);
    *edit.mutable_value() = value;
    for (const std::string& field : fields) edit.add_fields(field);
  }
  return request;
}

std::vector<EditorCall> SceneEditor::save(const std::string& file, bool replace) {
  if (file.empty() && document_.file().empty()) {
    notice_ = "This scene has no file yet: use Save as.";
    return {};
  }
  begin_edit("saving");
  v1::SaveSceneRequest request;
  request.set_file(file);
  request.set_replace(replace);
  return {request};
}

std::vector<EditorCall> SceneEditor::act(Shortcut shortcut, const Objects& objects) {
  if (document_.revision() == 0) return {};
  SceneActions actions;
  switch (shortcut) {
    case Shortcut::Undo:
      actions.undo = true;
      break;
    case Shortcut::Redo:
      actions.redo = true;
      break;
    case Shortcut::Save:
      actions.save = true;
      break;
    case Shortcut::Duplicate:
      actions.duplicate = true;
      break;
    case Shortcut::Remove:
      actions.remove = true;
      break;
  }
  return act(actions, objects, Eigen::Vector3d::Zero(), {});
}

std::vector<EditorCall> SceneEditor::act(const SceneActions& actions, const Objects& objects,
                                         const Eigen::Vector3d& floor_m, const v1::Bookmark& view) {
  std::vector<EditorCall> calls;
  const auto edit = [&](v1::EditSceneRequest request, const std::string& what) {
    if (request.objects_size() == 0 && !request.bookmarks() && !request.background()) return;
    begin_edit(what);
    calls.emplace_back(std::move(request));
  };
  const auto name_at = [&](size_t index) {
    const auto& scene = document_.scene();
    return index < static_cast<size_t>(scene.objects_size()) ? scene.objects(static_cast<int>(index)).name()
                                                             : std::string();
  };
  if (actions.clicked) select(name_at(*actions.clicked), actions.extends);
  const auto set_flag = [&](const std::optional<std::pair<size_t, bool>>& flag, const char* field,
                            auto setter) {
    if (!flag) return;
    v1::EditSceneRequest request;
    v1::ObjectEdit& one = *request.add_objects();
    one.set_object(name_at(flag->first));
    (one.mutable_value()->*setter)(flag->second);
    one.add_fields(field);
    request.set_title((flag->second ? "" : "un") +
                      std::string(field == std::string("hidden") ? "hide " : "lock ") + one.object());
    edit(std::move(request), field);
  };
  set_flag(actions.hidden, "hidden", &v1::Object::set_hidden);
  set_flag(actions.locked, "locked", &v1::Object::set_locked);
  if (actions.undo || actions.redo) {
    begin_edit(actions.redo ? "redo" : "undo");
    calls.emplace_back(UndoEditCall{actions.redo});
  }
  if (actions.save || actions.save_as) {
    for (EditorCall& call : save(actions.save_as.value_or(""), actions.replace))
      calls.push_back(std::move(call));
  }
  if (actions.opened_assets) calls.emplace_back(ListAssetsCall{});
  if (actions.add && *actions.add < static_cast<size_t>(assets_.assets_size())) {
    v1::EditSceneRequest request;
    *request.add_objects() = added_at(assets_.assets(static_cast<int>(*actions.add)).path(), floor_m);
    edit(std::move(request), "adding an object");
  }
  if (actions.duplicate) {
    v1::EditSceneRequest request;
    for (const std::string& name : selected_) {
      const auto now = objects.find(name);
      if (now == objects.end()) continue;
      Pose pose = now->second.pose;
      pose.position_m.x() += std::max(kDuplicateShift_m, now->second.longest_side_m);
      v1::ObjectEdit copy = pose_edit("", pose);
      copy.set_copy_of(name);
      *request.add_objects() = std::move(copy);
    }
    edit(std::move(request), "duplicating");
  }
  if (actions.remove) {
    v1::EditSceneRequest request;
    for (const std::string& name : selected_) {
      v1::ObjectEdit& gone = *request.add_objects();
      gone.set_object(name);
      gone.set_remove(true);
    }
    edit(std::move(request), "deleting");
  }
  if (actions.put_back && selected_.size() == 1) {
    begin_edit("putting back");
    v1::PutBackRequest request;
    request.set_object(*selected_.begin());
    calls.emplace_back(std::move(request));
  }
  if (actions.drop) {
    v1::EditSceneRequest request;
    for (const std::string& name : selected_) {
      const auto now = objects.find(name);
      if (now == objects.end()) continue;
      v1::ObjectEdit dropped = pose_edit(name, now->second.pose);  // from where it is now
      dropped.set_drop(true);
      *request.add_objects() = std::move(dropped);
    }
    edit(std::move(request), "dropping");
  }
  if (actions.tool) set_tool(*actions.tool);
  if (actions.snap) snap_ = *actions.snap;
  if (actions.grid) grid_ = *actions.grid;
  v1::Object value;
  if (actions.name) {
    value.set_name(*actions.name);
    edit(edit_of_selection(value, {"name"}), "renaming");
  }
  if (actions.label) {
    value.set_label(*actions.label);
    edit(edit_of_selection(value, {"label"}), "estimating as " + *actions.label);
  }
  if (actions.group) {
    value.set_group(*actions.group);
    edit(edit_of_selection(value, {"group"}), "grouping");
  }
  if (actions.material) {
    if (!actions.material->empty()) value.set_material(*actions.material);
    edit(edit_of_selection(value, {"material"}), "setting the material");
  }
  if (actions.behavior) {
    value.mutable_physics()->set_behavior(kBehaviors[static_cast<size_t>(*actions.behavior)]);
    edit(edit_of_selection(value, {"physics.behavior"}), "building again");
  }
  if (actions.longest_side_m && selected_.size() == 1) {
    v1::EditSceneRequest request = edit_of_selection({}, {});
    request.mutable_objects(0)->set_longest_side_m(*actions.longest_side_m);
    edit(std::move(request), "scaling");
  }
  if ((actions.position_m || actions.angles_deg) && selected_.size() == 1) {
    const auto now = objects.find(*selected_.begin());
    if (now != objects.end()) {
      Pose pose = now->second.pose;
      if (const auto& at = actions.position_m) pose.position_m = {(*at)[0], (*at)[1], (*at)[2]};
      if (const auto& turn = actions.angles_deg)
        pose.orientation = orientation_of({(*turn)[0], (*turn)[1], (*turn)[2]});
      v1::EditSceneRequest request;
      *request.add_objects() = pose_edit(now->first, pose);
      edit(std::move(request), "moving");
    }
  }
  if (actions.keep_bookmark || actions.delete_bookmark) {
    v1::EditSceneRequest request;
    request.set_bookmarks(true);
    auto& views = *request.mutable_scene()->mutable_bookmarks();
    views = document_.scene().bookmarks();
    if (actions.delete_bookmark && *actions.delete_bookmark < static_cast<size_t>(views.size()))
      views.DeleteSubrange(static_cast<int>(*actions.delete_bookmark), 1);
    if (actions.keep_bookmark) {
      v1::Bookmark& kept = *views.Add();
      kept = view;
      kept.set_name(*actions.keep_bookmark);
    }
    request.set_title(actions.keep_bookmark ? "keep view " + *actions.keep_bookmark : "delete a view");
    edit(std::move(request), "saving the view");
  }
  if (actions.background) {
    v1::EditSceneRequest request;
    request.set_background(true);
    for (const float part : *actions.background) request.mutable_scene()->add_background_rgb(part);
    edit(std::move(request), "setting the background");
  }
  return calls;
}

void SceneEditor::set_tool(int tool) {
  tool_ = std::clamp(tool, 0, static_cast<int>(ScenePanel::kTools.size()) - 1);
  gizmo_.end();
}

std::vector<EditorCall> SceneEditor::drop_files(const std::vector<std::string>& files,
                                                const Eigen::Vector3d& at_m) {
  std::vector<EditorCall> calls;
  if (document_.revision() == 0) {
    notice_ = "This client may not edit the scene.";
    return calls;
  }
  Eigen::Vector3d place = at_m;
  for (const std::string& file : files) {
    calls.emplace_back(UploadCall{file, added_at("", place)});
    place.x() += 0.5;  // several files do not stand in each other
  }
  if (!calls.empty()) begin_edit(format_text("sending %zu files", calls.size()));
  return calls;
}

GizmoTool SceneEditor::gizmo_tool() const {
  return tool_ == 1   ? GizmoTool::Move
         : tool_ == 2 ? GizmoTool::Turn
         : tool_ == 3 ? GizmoTool::Scale
                      : GizmoTool::None;
}

std::optional<Eigen::Vector3d> SceneEditor::pivot_m(const Objects& objects) const {
  if (gizmo_.dragging()) return pivot_m_;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const std::string& name : selected_) {
    const auto now = objects.find(name);
    const v1::Object* object = described(name);
    if (now == objects.end() || !object || object->locked()) continue;
    sum += now->second.centre_m;
    ++count;
  }
  return count == 0 ? std::nullopt : std::optional<Eigen::Vector3d>(sum / count);
}

bool SceneEditor::press(const Camera& camera, const Eigen::Vector2d& mouse_px, const Objects& objects) {
  const auto at = pivot_m(objects);
  if (!at || gizmo_tool() == GizmoTool::None) return false;
  const auto axis = Gizmo::handle_at(gizmo_tool(), camera, *at, mouse_px);
  if (!axis) return false;
  pivot_m_ = *at;
  begun_.clear();
  for (const std::string& name : selected_) {
    const auto now = objects.find(name);
    const v1::Object* object = described(name);
    if (now != objects.end() && object && !object->locked()) begun_[name] = now->second;
  }
  gizmo_.begin(gizmo_tool(), *axis, camera, *at, mouse_px);
  return true;
}

GizmoChange SceneEditor::change_now(const Camera& camera, const Eigen::Vector2d& mouse_px, bool ctrl) const {
  return gizmo_.drag(camera, mouse_px, snap_ != ctrl);
}

std::vector<EditorCall> SceneEditor::drag(const Camera& camera, const Eigen::Vector2d& mouse_px, bool ctrl) {
  std::vector<EditorCall> calls;
  if (!gizmo_.dragging() || gizmo_tool() == GizmoTool::Scale) return calls;
  const GizmoChange change = change_now(camera, mouse_px, ctrl);
  for (const auto& [name, object] : begun_) {
    v1::CarryObjectRequest request;
    request.set_object(name);
    write_pose(changed_pose(object.pose, change, pivot_m_), *request.mutable_pose());
    calls.emplace_back(std::move(request));
  }
  return calls;
}

std::vector<EditorCall> SceneEditor::release(const Camera& camera, const Eigen::Vector2d& mouse_px,
                                             bool ctrl) {
  std::vector<EditorCall> calls;
  if (!gizmo_.dragging()) return calls;
  const GizmoChange change = change_now(camera, mouse_px, ctrl);
  const bool scales = gizmo_tool() == GizmoTool::Scale;
  gizmo_.end();
  const bool moved = !change.shift_m.isZero(1e-9) ||
                     change.rotation.angularDistance(Eigen::Quaterniond::Identity()) > 1e-9 ||
                     std::abs(change.scale - 1.0) > 1e-9;
  if (!moved) return calls;
  v1::EditSceneRequest request;
  for (const auto& [name, object] : begun_) {
    v1::ObjectEdit edit = pose_edit(name, changed_pose(object.pose, change, pivot_m_));
    if (scales) edit.set_longest_side_m(object.longest_side_m * change.scale);
    if (scales && begun_.size() == 1) edit.clear_fields();  // its base stays where it is
    *request.add_objects() = std::move(edit);
  }
  const char* what = scales ? "scale" : gizmo_tool() == GizmoTool::Turn ? "turn" : "move";
  request.set_title(begun_.size() == 1 ? std::string(what) + " " + begun_.begin()->first
                                       : format_text("%s %zu objects", what, begun_.size()));
  begin_edit("");
  calls.emplace_back(std::move(request));
  return calls;
}

void SceneEditor::select(const std::string& name, bool extends) {
  const v1::Object* object = described(name);
  if (!extends) selected_.clear();
  if (!object) return;
  std::set<std::string> together{name};
  if (!object->group().empty()) {
    for (const v1::Object& other : document_.scene().objects()) {
      if (other.group() == object->group()) together.insert(other.name());
    }
  }
  const bool takes_out = extends && selected_.contains(name);
  for (const std::string& one : together)
    takes_out ? void(selected_.erase(one)) : void(selected_.insert(one));
}

std::optional<EditorCall> SceneEditor::see_revision(uint64_t revision) {
  if (revision == 0 || revision == document_.revision() || revision == asked_revision_) return std::nullopt;
  asked_revision_ = revision;
  return EditorCall(GetSceneCall{});
}

void SceneEditor::take(v1::SceneDocument document) {
  document_ = std::move(document);
  std::erase_if(selected_, [&](const std::string& name) { return !described(name); });
}

void SceneEditor::take(const v1::EditSceneReply& reply) {
  progress_.clear();
  notice_.clear();
  for (const std::string& warning : reply.warnings()) notice_ += (notice_.empty() ? "" : "\n") + warning;
  if (reply.objects_size() == 0) return;
  // Selects the added, renamed or edited objects, because the user probably continues with them.
  std::set<std::string> edited(reply.objects().begin(), reply.objects().end());
  selected_ = std::move(edited);
}

EditorCall SceneEditor::take_thing(const Pose& ray, bool preview) {
  v1::TakePartRequest request;
  v1::PickRay& pick = *request.add_rays();
  const Eigen::Vector3d towards = ray.orientation * -Eigen::Vector3d::UnitZ();
  for (int axis = 0; axis < 3; ++axis) {
    pick.add_from_m(ray.position_m[axis]);
    pick.add_towards(towards[axis]);
  }
  request.set_preview(preview);
  if (!preview) begin_edit("taking a thing");
  return request;
}

void SceneEditor::take_saved(const std::string& file) {
  progress_ = "saved " + file;
  notice_.clear();
}

void SceneEditor::take_refusal(const std::string& why) {
  progress_.clear();
  notice_ = why;
}

}  // namespace livegs
