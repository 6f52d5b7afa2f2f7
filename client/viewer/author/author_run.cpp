// SPDX-License-Identifier: Apache-2.0
#include "viewer/author/author_run.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/text/format_text.h"
#include "viewer/author/object_pose.h"
#include "viewer/author/scene_lines.h"

namespace livegs {
namespace {

constexpr int kMeasureTool = 4;  // of ScenePanel::kTools
constexpr int kTakeTool = ScenePanel::kTakeTool;
constexpr int kGridHalf = 10;       // squares of a metre to each side
constexpr double kFarFloor_m = 50;  // an object is not put farther away

v1::Bookmark bookmark_of(const Camera& camera, const Eigen::Vector3d& target_m) {
  v1::Bookmark view;
  for (int axis = 0; axis < 3; ++axis) {
    view.add_position_m(camera.world_from_camera.position_m[axis]);
    view.add_look_at_m(target_m[axis]);
  }
  return view;
}

}  // namespace

void AuthorRun::see(const ReceivedFrame& frame, const std::map<uint32_t, StreamedObject>& objects,
                    const SceneView& view) {
  if (auto call = editor_.see_revision(frame.run.edit_revision())) perform({std::move(*call)});
  objects_.clear();
  ids_.clear();
  for (const ObjectDrivers& drivers : frame.drivers->objects) {
    const auto described = objects.find(drivers.object_id);
    if (described == objects.end() || described->second.environment) continue;
    const StreamedObject& object = described->second;
    ids_[object.name] = object.id;
    if (!editor_.selected().contains(object.name)) continue;  // bounds read every kernel
    const Eigen::AlignedBox3d box = view.bounds(object.id);
    EditedObject edited;
    edited.pose = scene_pose(object.rest, drivers, object.lift_m);
    edited.centre_m = box.isEmpty() ? edited.pose.position_m : Eigen::Vector3d(box.center());
    edited.longest_side_m = object.physics.longest_side_m().best();
    edited.estimated_label = object.physics.label();
    edited.confidence = object.physics.confidence();
    objects_[object.name] = std::move(edited);
  }
}

std::string AuthorRun::selected() const {
  return editor_.selected().size() == 1 ? *editor_.selected().begin() : std::string();
}

void AuthorRun::perform(std::vector<EditorCall> calls) {
  for (EditorCall& call : calls) {
    if (auto* edit = std::get_if<v1::EditSceneRequest>(&call))
      calls_.edit_scene(std::move(*edit));
    else if (auto* undo = std::get_if<UndoEditCall>(&call))
      calls_.undo_edit(undo->redo);
    else if (auto* save = std::get_if<v1::SaveSceneRequest>(&call))
      calls_.save_scene(std::move(*save));
    else if (auto* carry = std::get_if<v1::CarryObjectRequest>(&call))
      calls_.carry_object(std::move(*carry));
    else if (auto* upload = std::get_if<UploadCall>(&call))
      calls_.upload_asset(std::move(upload->file), std::move(upload->edit));
    else if (auto* take = std::get_if<v1::TakePartRequest>(&call))
      calls_.take_part(std::move(*take));
    else if (auto* back = std::get_if<v1::PutBackRequest>(&call))
      calls_.put_back(back->object());
    else if (std::holds_alternative<ListAssetsCall>(call))
      calls_.list_assets();
    else
      calls_.get_scene();
  }
}

void AuthorRun::act(const WindowInput& input, const SceneActions& actions, const Camera& window,
                    const SceneView& view, OrbitCamera& camera) {
  mouse_px_ = input.mouse_px;
  if (!available()) return;
  const Eigen::Vector2d middle(0.5 * window.width, 0.5 * window.height);
  const Eigen::Vector3d floor_m = floor_at(window, middle, view).value_or(camera.target_m());
  perform(editor_.act(actions, objects_, floor_m, bookmark_of(window, camera.target_m())));
  if (actions.frame || input.frame) frame(view, camera);
  if (actions.go_bookmark) {
    const auto& views = scene().bookmarks();
    if (*actions.go_bookmark < static_cast<size_t>(views.size())) {
      const v1::Bookmark& kept = views[static_cast<int>(*actions.go_bookmark)];
      const auto vector = [](const auto& numbers) {
        return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
      };
      if (kept.position_m_size() == 3 && kept.look_at_m_size() == 3)
        camera.look(vector(kept.position_m()), vector(kept.look_at_m()));
    }
  }
  using Shortcut = SceneEditor::Shortcut;
  for (const auto& [times, shortcut] : {std::pair(input.undo, Shortcut::Undo),
                                        {input.redo, Shortcut::Redo},
                                        {input.save, Shortcut::Save},
                                        {input.duplicate, Shortcut::Duplicate},
                                        {input.remove, Shortcut::Remove}}) {
    for (int i = 0; i < times; ++i) perform(editor_.act(shortcut, objects_));
  }
  if (input.tool) editor_.set_tool(*input.tool);
  if (!input.dropped.empty())
    perform(editor_.drop_files(input.dropped, floor_at(window, input.mouse_px, view).value_or(floor_m)));
  drag(input, window);
  measure(input, window, view);
  take_things(input, window);
  was_left_ = input.left;
}

void AuthorRun::drag(const WindowInput& input, const Camera& window) {
  if (input.left && !was_left_ && !input.over_panel) editor_.press(window, input.mouse_px, objects_);
  if (!editor_.dragging()) return;
  perform(input.left ? editor_.drag(window, input.mouse_px, input.ctrl)
                     : editor_.release(window, input.mouse_px, input.ctrl));
}

void AuthorRun::measure(const WindowInput& input, const Camera& window, const SceneView& view) {
  if (editor_.tool() != kMeasureTool) {
    measured_m_.clear();
    return;
  }
  if (!input.left || was_left_ || input.over_panel) return;
  const auto at = floor_at(window, input.mouse_px, view);
  if (!at) return;
  if (measured_m_.size() == 2) measured_m_.clear();
  measured_m_.push_back(*at);
}

void AuthorRun::take_things(const WindowInput& input, const Camera& window) {
  if (editor_.tool() != kTakeTool || !editor_.has_room() || input.over_panel) {
    hovered_m_.setEmpty();
    asked_.reset();
    return;
  }
  const Pose ray = ray_through(window, input.mouse_px);
  if (input.left && !was_left_) {
    perform({editor_.take_thing(ray, false)});
    hovered_m_.setEmpty();
    asked_.reset();
    return;
  }
  const bool same = asked_ && asked_->first == input.mouse_px &&
                    asked_->second.position_m == window.world_from_camera.position_m &&
                    asked_->second.orientation.coeffs() == window.world_from_camera.orientation.coeffs();
  if (same || asking_ || input.left) return;
  asked_ = {input.mouse_px, window.world_from_camera};
  asking_ = true;
  perform({editor_.take_thing(ray, true)});
}

void AuthorRun::frame(const SceneView& view, OrbitCamera& camera) const {
  Eigen::AlignedBox3d box;
  for (const auto& [name, id] : ids_) {
    if (editor_.selected().empty() || editor_.selected().contains(name)) box.extend(view.bounds(id));
  }
  if (!box.isEmpty()) camera.frame(box);
}

std::optional<Eigen::Vector3d> AuthorRun::floor_at(const Camera& window, const Eigen::Vector2d& pixel,
                                                   const SceneView& view) const {
  const Pose ray = ray_through(window, pixel);
  const Eigen::Vector3d direction = ray.orientation * -Eigen::Vector3d::UnitZ();
  if (const auto met = view.pick(ray.position_m, direction)) return met->point_m;
  if (direction.y() > -1e-3) return std::nullopt;
  const double way = -ray.position_m.y() / direction.y();
  if (!(way > 0.0 && way < kFarFloor_m)) return std::nullopt;
  return ray.position_m + way * direction;
}

void AuthorRun::take(const ControlCalls::Answer& answer) {
  using Kind = ControlCalls::Answer::Kind;
  if (answer.kind == Kind::Preview) {
    asking_ = false;
    hovered_m_.setEmpty();
    if (!answer.preview || !asked_) return;
    for (const auto* corner : {&answer.preview->min_m(), &answer.preview->max_m()}) {
      if (corner->size() == 3) hovered_m_.extend(Eigen::Vector3d((*corner)[0], (*corner)[1], (*corner)[2]));
    }
  } else if (answer.refused) {
    // A client that may not edit, or a server without editing, shows no panel and needs no message.
    if (answer.kind != Kind::Scene) editor_.take_refusal(answer.refused->message);
  } else if (answer.edited) {
    editor_.take(*answer.edited);
  } else if (answer.scene) {
    const bool first = !available();
    editor_.take(*answer.scene);
    if (first) calls_.list_assets();
  } else if (answer.assets) {
    editor_.take(*answer.assets);
  } else if (answer.kind == Kind::Save) {
    editor_.take_saved(answer.saved);
  }
}

void AuthorRun::draw(const Camera& window, const SceneView& view, WindowOverlay& overlay) const {
  if (!available()) return;
  std::vector<WindowLine>& lines = overlay.lines;
  if (editor_.grid()) {
    for (int i = -kGridHalf; i <= kGridHalf; ++i) {
      const WindowLine::Ink ink = i == 0 ? WindowLine::Ink::Axis : WindowLine::Ink::Grid;
      add_line(window, {i * 1.0, 0, -kGridHalf}, {i * 1.0, 0, kGridHalf}, ink, 1.0f, lines);
      add_line(window, {-kGridHalf, 0, i * 1.0}, {kGridHalf, 0, i * 1.0}, ink, 1.0f, lines);
    }
  }
  for (const std::string& name : editor_.selected()) {
    if (const auto id = ids_.find(name); id != ids_.end())
      add_box(window, view.bounds(id->second), {}, WindowLine::Ink::Selection, lines);
  }
  add_box(window, hovered_m_, {}, WindowLine::Ink::Selection, lines);
  if (const auto at = editor_.pivot_m(objects_)) {
    const auto under =
        editor_.dragging() ? std::nullopt : Gizmo::handle_at(editor_.gizmo_tool(), window, *at, mouse_px_);
    for (const GizmoHandle& handle : Gizmo::handles(editor_.gizmo_tool(), window, *at)) {
      const bool lit = editor_.dragging() ? handle.axis == editor_.gizmo().axis() : under == handle.axis;
      static constexpr std::array kInks{WindowLine::Ink::X, WindowLine::Ink::Y, WindowLine::Ink::Z,
                                        WindowLine::Ink::Plane};
      lines.push_back(
          {handle.line_px, kInks[static_cast<size_t>(handle.axis)], lit ? 5.0f : 3.0f, handle.arrow, ""});
    }
  }
  for (const Eigen::Vector3d& point : measured_m_) {
    if (const auto at = pixel_of(window, point))
      lines.push_back({{*at, *at + Eigen::Vector2d(1, 0)}, WindowLine::Ink::Selection, 7.0f, false, ""});
  }
  if (measured_m_.size() == 2) {
    const auto before = lines.size();
    add_line(window, measured_m_[0], measured_m_[1], WindowLine::Ink::Selection, 2.0f, lines);
    if (lines.size() > before)
      lines.back().label = format_text("%.3g m", (measured_m_[1] - measured_m_[0]).norm());
  }
}

}  // namespace livegs
