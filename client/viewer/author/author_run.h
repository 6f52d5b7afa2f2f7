// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/scene_view.h"
#include "stream/received/received.h"
#include "viewer/author/scene_editor.h"
#include "viewer/camera/orbit_camera.h"
#include "viewer/live/control_calls.h"
#include "xr/window_display.h"

namespace livegs {

// Editing of the scene in a desktop window: connects the editor with the input, the calls and the overlay of
// a picture. Renderer thread.
class AuthorRun {
 public:
  explicit AuthorRun(ControlCalls& calls) : calls_(calls) {}

  // The newest state of the scene; once a picture, before act().
  void see(const ReceivedFrame& frame, const std::map<uint32_t, StreamedObject>& objects,
           const SceneView& view);
  // Applies the input and the actions on the panel. May move the camera.
  void act(const WindowInput& input, const SceneActions& actions, const Camera& window, const SceneView& view,
           OrbitCamera& camera);
  void take(const ControlCalls::Answer& answer);
  // Gizmo, outline of the selection, grid and measured distance.
  void draw(const Camera& window, const SceneView& view, WindowOverlay& overlay) const;

  // Whether the left button edits and does not pull.
  bool uses_left_button() const { return editor_.tool() != 0 || editor_.dragging(); }
  void select(const std::string& name, bool extends) { editor_.select(name, extends); }
  // The selected object if it is only one.
  std::string selected() const;
  ScenePanel shown() const { return editor_.shown(objects_); }
  bool available() const { return editor_.document().revision() > 0; }
  const v1::Scene& scene() const { return editor_.document().scene(); }
  void undo(bool redo) { perform({UndoEditCall{redo}}); }

 private:
  void perform(std::vector<EditorCall> calls);
  void drag(const WindowInput& input, const Camera& window);
  void measure(const WindowInput& input, const Camera& window, const SceneView& view);
  void take_things(const WindowInput& input, const Camera& window);
  void frame(const SceneView& view, OrbitCamera& camera) const;
  // The point at which the ray through a pixel hits a drawn surface, else the floor.
  std::optional<Eigen::Vector3d> floor_at(const Camera& window, const Eigen::Vector2d& pixel,
                                          const SceneView& view) const;

  ControlCalls& calls_;
  SceneEditor editor_;
  SceneEditor::Objects objects_;  // the selected ones
  std::map<std::string, uint32_t> ids_;
  bool was_left_ = false;
  Eigen::Vector2d mouse_px_{0, 0};
  std::vector<Eigen::Vector3d> measured_m_;  // up to two points
  // With the Take tool: the thing under the mouse, and the mouse and camera that were asked for it.
  Eigen::AlignedBox3d hovered_m_;
  std::optional<std::pair<Eigen::Vector2d, Pose>> asked_;
  bool asking_ = false;
};

}  // namespace livegs
