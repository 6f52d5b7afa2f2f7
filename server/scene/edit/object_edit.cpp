// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/edit/object_edit.h"

#include <google/protobuf/util/field_mask_util.h>

#include <filesystem>
#include <set>

#include "analysis/gate/answer.h"
#include "core/text/shown_text.h"
#include "scene/check/check_object.h"
#include "scene/check/object_references.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

using google::protobuf::util::FieldMaskUtil;

constexpr size_t kMaxNameLength = 120;
// Height above the given place from which a new object is dropped: more than a drawn floor's thickness.
constexpr double kDropFrom_m = 0.05;

int index_of(const v1::Scene& scene, const std::string& name) {
  for (int i = 0; i < scene.objects_size(); ++i) {
    if (object_name(scene.objects(i), i) == name) return i;
  }
  return -1;
}

// `wanted`, with a number if another object has that name.
std::string free_name(const v1::Scene& scene, const std::string& wanted, int except) {
  std::set<std::string> taken;
  for (int i = 0; i < scene.objects_size(); ++i) {
    if (i != except) taken.insert(object_name(scene.objects(i), i));
  }
  if (!taken.contains(wanted)) return wanted;
  // "cup 2" and its copy "cup 3", not "cup 2 2".
  std::string stem = wanted;
  const size_t space = stem.rfind(' ');
  if (space != std::string::npos && space + 1 < stem.size() &&
      stem.find_first_not_of("0123456789", space + 1) == std::string::npos)
    stem.resize(space);
  for (int number = 2;; ++number) {
    std::string name = stem + " " + std::to_string(number);
    if (!taken.contains(name)) return name;
  }
}

void set_position(v1::Object& object, const Eigen::Vector3d& position_m) {
  object.mutable_pose()->clear_position_m();
  for (const double coordinate : position_m) object.mutable_pose()->add_position_m(coordinate);
}

Result<void> set_fields(v1::Object& object, const v1::ObjectEdit& edit) {
  google::protobuf::FieldMask mask;
  for (const std::string& path : edit.fields()) {
    if (!FieldMaskUtil::IsValidPath<v1::Object>(path))
      return invalid_argument("fields: \"" + shown_text(path, 60) +
                              "\" is not a field of an object; see Object in scene.proto");
    mask.add_paths(path);
  }
  FieldMaskUtil::MergeOptions options;
  options.set_replace_message_fields(true);
  options.set_replace_repeated_fields(true);
  FieldMaskUtil::MergeMessageTo(edit.value(), mask, options, &object);
  return {};
}

// Whether an edit of an asset may change its scale. A guessed scale depends on the kind of the object.
bool may_resize(const v1::ObjectEdit& edit) {
  bool resizes = edit.has_longest_side_m();
  for (const std::string& field : edit.fields()) {
    if (field == "pose") return false;  // the author gives the place
    resizes |=
        field == "label" || field == "name" || field == "scale" || field == "up" || field == "material";
  }
  return resizes;
}

// A remote author names files of the scene's folder only.
bool stays_in_folder(const std::string& path) {
  const std::filesystem::path plain = std::filesystem::path(path).lexically_normal();
  return plain.is_relative() && (plain.empty() || *plain.begin() != "..");
}

bool only_unlocks(const v1::ObjectEdit& edit) {
  return !edit.remove() && !edit.has_longest_side_m() && !edit.drop() && edit.fields_size() == 1 &&
         edit.fields(0) == "locked";
}

}  // namespace

void name_objects(v1::Scene& scene) {
  for (int i = 0; i < scene.objects_size(); ++i) {
    if (scene.objects(i).name().empty()) scene.mutable_objects(i)->set_name(object_name(scene.objects(i), i));
  }
}

Result<std::string> apply_edit(v1::Scene& scene, const v1::ObjectEdit& edit, const MeasureObject& measure) {
  int index = 0;
  std::optional<v1::Object> before_edit;
  if (edit.object().empty()) {
    v1::Object added = edit.value();
    if (!edit.copy_of().empty()) {
      const int original = index_of(scene, edit.copy_of());
      if (original < 0)
        return not_found("copy_of: \"" + shown_text(edit.copy_of(), 80) +
                         "\" is not in the scene; name one that is");
      added = scene.objects(original);
      before_edit = added;
      added.clear_locked();
      added.clear_part();
      if (auto set = set_fields(added, edit); !set) return set.error();
    }
    index = scene.objects_size();
    const std::string name = free_name(scene, object_name(added, index), index);
    added.set_name(name);
    *scene.add_objects() = std::move(added);
  } else {
    index = index_of(scene, edit.object());
    if (index < 0)
      return not_found("object: \"" + shown_text(edit.object(), 80) +
                       "\" is not in the scene; it may have been deleted");
    const std::string before = object_name(scene.objects(index), index);
    if (scene.objects(index).locked() && !only_unlocks(edit))
      return invalid_argument("object \"" + before + "\": is locked; unlock it first");
    if (edit.remove()) {
      if (const std::string user = reference_to(scene, before); !user.empty())
        return invalid_argument("object \"" + before + "\": is named by " + user +
                                " of the scene; remove that first");
      scene.mutable_objects()->DeleteSubrange(index, 1);
      return before;
    }
    v1::Object& object = *scene.mutable_objects(index);
    before_edit = object;
    if (auto set = set_fields(object, edit); !set)
      return Error{set.error().code, "object \"" + before + "\": " + set.error().message};
    if (object.name().empty()) object.set_name(before);
    if (object.name() != before) {
      // A new name does not change the kind of the object.
      if (object.label().empty()) object.set_label(before);
      object.set_name(free_name(scene, object.name(), index));
      rename_references(scene, before, object.name());
    }
  }
  v1::Object& object = *scene.mutable_objects(index);
  if (object.name().size() > kMaxNameLength)
    return invalid_argument("object \"" + shown_text(object.name(), 80) +
                            "\": name: is longer than 120 characters; shorten it");
  for (const std::string& path : {object.asset(), object.points()}) {
    if (!path.empty() && !stays_in_folder(path) &&
        !(before_edit && (path == before_edit->asset() || path == before_edit->points())))
      return invalid_argument("object \"" + object.name() + "\": asset: \"" + shown_text(path, 80) +
                              "\" is outside the scene's folder; give a path within it");
  }
  if (edit.has_longest_side_m()) {
    if (object.form_case() != v1::Object::kAsset)
      return invalid_argument("object \"" + object.name() +
                              "\": longest_side_m: only an asset has a scale; edit the shape's size");
    if (!(edit.longest_side_m() >= 1e-4 && edit.longest_side_m() <= 1e4))
      return invalid_argument("object \"" + object.name() +
                              "\": longest_side_m: is out of range; give 1e-4 to 1e4 m");
    auto measures = measure(object);
    if (!measures) return measures.error();
    object.set_scale(measures->scale * edit.longest_side_m() / measures->longest_side_m);
    object.clear_assumed_scale();
  }
  if (!edit.object().empty() && object.has_asset() && may_resize(edit)) {
    // An asset of another size keeps its lowest point where it was.
    const auto was = measure(*before_edit), is = measure(object);
    if (!is) return is.error();
    auto pose = pose_value(object.pose(), "pose");
    const auto gravity = vector_value(scene.gravity_m_s2(), Eigen::Vector3d(0, -9.81, 0), "gravity_m_s2");
    if (was && pose && gravity && was->bottom_m != is->bottom_m)
      set_position(object, pose->position_m + (is->bottom_m - was->bottom_m) * gravity->normalized());
  }
  if (edit.drop()) {
    auto measures = measure(object);
    if (!measures) return measures.error();
    if (edit.object().empty() && edit.copy_of().empty()) {
      // The position of a new object is where it should stand: its lowest point is put there first.
      auto pose = pose_value(object.pose(), "pose");
      if (!pose) return pose.error();
      const auto gravity = vector_value(scene.gravity_m_s2(), Eigen::Vector3d(0, -9.81, 0), "gravity_m_s2");
      if (!gravity) return gravity.error();
      set_position(object, pose->position_m + (measures->bottom_m - kDropFrom_m) * gravity->normalized());
      measures = measure(object);
      if (!measures) return measures.error();
    }
    if (!measures->way_down_m)
      return invalid_argument("object \"" + object.name() +
                              "\": nothing is below it; move it above the floor");
    auto pose = pose_value(object.pose(), "pose");
    if (!pose) return pose.error();
    const auto gravity = vector_value(scene.gravity_m_s2(), Eigen::Vector3d(0, -9.81, 0), "gravity_m_s2");
    if (!gravity) return gravity.error();
    set_position(object, pose->position_m + *measures->way_down_m * gravity->normalized());
  }
  return object.name();
}

std::string title_of(const v1::EditSceneRequest& request) {
  if (!request.title().empty()) return shown_text(request.title(), 80);
  if (request.objects_size() == 0) return request.background() ? "set background" : "set bookmarks";
  const v1::ObjectEdit& edit = request.objects(0);
  std::string what = "edit";
  if (edit.object().empty())
    what = edit.copy_of().empty() ? "add" : "duplicate";
  else if (edit.remove())
    what = "delete";
  else if (edit.drop())
    what = "drop";
  else if (edit.has_longest_side_m())
    what = "scale";
  else if (edit.fields_size() == 1)
    what = edit.fields(0) == "pose"   ? "move"
           : edit.fields(0) == "name" ? "rename"
                                      : "set " + edit.fields(0) + " of";
  if (request.objects_size() > 1) return what + " " + std::to_string(request.objects_size()) + " objects";
  const std::string name = !edit.object().empty()    ? edit.object()
                           : !edit.copy_of().empty() ? edit.copy_of()
                                                     : object_name(edit.value(), 0);
  return what + " " + shown_text(name, 60);
}

}  // namespace livegs
