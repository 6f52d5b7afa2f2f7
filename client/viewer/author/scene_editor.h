// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "livegs/v1/author.pb.h"
#include "viewer/author/gizmo.h"
#include "xr/window/window_panels.h"

namespace livegs {

// Calls to the server that the user's actions ask for.
struct UndoEditCall {
  bool redo = false;
};
struct ListAssetsCall {};
struct GetSceneCall {};
struct UploadCall {
  std::filesystem::path file;
  v1::ObjectEdit edit;  // that adds its object
};
using EditorCall =
    std::variant<v1::EditSceneRequest, UndoEditCall, v1::SaveSceneRequest, v1::CarryObjectRequest,
                 ListAssetsCall, GetSceneCall, UploadCall, v1::TakePartRequest, v1::PutBackRequest>;

// An object of the running scene, as the editor needs it.
struct EditedObject {
  Pose pose;                 // scene_pose()
  Eigen::Vector3d centre_m;  // of the drawn kernels
  double longest_side_m = 0;
  std::string estimated_label;  // label estimated by the analysis
  double confidence = 0;
};

// State of the Scene panel and of the gizmo: the document as the server last sent it, selection, tool. Makes
// no calls. Renderer thread.
class SceneEditor {
 public:
  using Objects = std::map<std::string, EditedObject>;  // of the newest frame, by name

  ScenePanel shown(const Objects& objects) const;
  // The calls for the actions on the panel. `floor_m`: where a new object is put. `view`: as bookmarks keep
  // it.
  std::vector<EditorCall> act(const SceneActions& actions, const Objects& objects,
                              const Eigen::Vector3d& floor_m, const v1::Bookmark& view);

  enum class Shortcut { Undo, Redo, Save, Duplicate, Remove };
  std::vector<EditorCall> act(Shortcut shortcut, const Objects& objects);
  void set_tool(int tool);
  int tool() const { return tool_; }
  bool grid() const { return grid_; }
  std::vector<EditorCall> drop_files(const std::vector<std::string>& files, const Eigen::Vector3d& at_m);

  // The mouse on the gizmo. `press`: whether a handle was taken, so that the press is not a pull.
  GizmoTool gizmo_tool() const;
  std::optional<Eigen::Vector3d> pivot_m(const Objects& objects) const;
  bool press(const Camera& camera, const Eigen::Vector2d& mouse_px, const Objects& objects);
  bool dragging() const { return gizmo_.dragging(); }
  std::vector<EditorCall> drag(const Camera& camera, const Eigen::Vector2d& mouse_px, bool ctrl);
  std::vector<EditorCall> release(const Camera& camera, const Eigen::Vector2d& mouse_px, bool ctrl);
  const Gizmo& gizmo() const { return gizmo_; }

  // Takes the thing of the captured room under a ray. `preview`: only requests its description.
  EditorCall take_thing(const Pose& ray, bool preview);
  bool has_room() const { return !document_.scene().environment().asset().empty(); }

  // Selects an object and those of its group; none for an empty name.
  void select(const std::string& name, bool extends);
  const std::set<std::string>& selected() const { return selected_; }
  const v1::SceneDocument& document() const { return document_; }

  // News from the server.
  std::optional<EditorCall> see_revision(uint64_t revision);  // RunState.edit_revision
  void take(v1::SceneDocument document);
  void take(const v1::EditSceneReply& reply);
  void take(v1::ListAssetsReply assets) { assets_ = std::move(assets); }
  void take_saved(const std::string& file);
  void take_refusal(const std::string& why);

 private:
  const v1::Object* described(const std::string& name) const;
  v1::EditSceneRequest edit_of_selection(const v1::Object& value,
                                         const std::vector<std::string>& fields) const;
  std::vector<EditorCall> save(const std::string& file, bool replace);
  GizmoChange change_now(const Camera& camera, const Eigen::Vector2d& mouse_px, bool ctrl) const;
  void begin_edit(const std::string& what);

  v1::SceneDocument document_;
  v1::ListAssetsReply assets_;
  uint64_t asked_revision_ = 0;
  std::set<std::string> selected_;
  int tool_ = 0;
  bool snap_ = false, grid_ = false;
  std::string notice_, progress_;
  Gizmo gizmo_;
  Eigen::Vector3d pivot_m_ = Eigen::Vector3d::Zero();
  Objects begun_;  // the selected objects when the drag began
};

}  // namespace livegs
