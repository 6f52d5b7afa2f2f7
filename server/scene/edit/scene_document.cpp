// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/edit/scene_document.h"

#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <map>

#include "analysis/gate/answer.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text/path_ending.h"
#include "core/text/shown_text.h"
#include "scene/check/check_object.h"
#include "scene/check/check_scene.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using google::protobuf::util::MessageDifferencer;

constexpr size_t kMaxFileName = 120;
constexpr std::string_view kEnding = ".scene.json";

// A name that stays in the scene's folder.
Result<std::string> scene_file_name(std::string name) {
  if (!has_ending(name, kEnding)) name += kEnding;
  const bool plain = name.size() > kEnding.size() && name.size() <= kMaxFileName && name.front() != '.' &&
                     std::all_of(name.begin(), name.end(), [](unsigned char letter) {
                       return letter >= 32 && letter != 127 && letter != '/' && letter != '\\';
                     });
  if (plain) return name;
  return invalid_argument("file: \"" + shown_text(name, 80) +
                          "\" is not a plain file name; give one such as room.scene.json, without a folder");
}

}  // namespace

Result<std::string> scene_text(const v1::Scene& scene) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  std::string text;
  const auto written = google::protobuf::util::MessageToJsonString(scene, &text, options);
  if (!written.ok()) return Error{ErrorCode::Internal, "scene: " + std::string(written.message())};
  return text + "\n";
}

Result<SceneDocument> SceneDocument::open(SceneText text) {
  SceneDocument document;
  document.folder_ = text.folder;
  document.name_ = text.name;
  if (text.of_file) document.file_ = text.name;
  document.scene_ = std::move(text.file);
  name_objects(document.scene_);
  document.note_file_time();
  std::error_code ignored;
  const fs::path journal = document.journal_path();
  if (!fs::exists(journal, ignored)) return document;
  auto kept = read_scene_file(journal);
  if (!kept) {
    log_warn("scene: the changes of an earlier run cannot be read (%s); delete %s to discard them",
             kept.error().message.c_str(), journal.c_str());
    return document;
  }
  // A file that was changed after the journal is not overwritten without a question.
  std::error_code error;
  if (fs::last_write_time(journal, error) < document.file_time_.value_or(fs::file_time_type::min()))
    document.file_time_.reset();
  Step step{"changes of the last run", document.scene_, std::move(*kept), {}, ""};
  document.scene_ = step.after;
  document.undo_.push_back(std::move(step));
  document.unsaved_ = true;
  log_info("scene: unsaved changes of the last run are loaded; undo reverts them, saving keeps them");
  return document;
}

void SceneDocument::describe(v1::SceneDocument& message) const {
  *message.mutable_scene() = scene_;
  message.set_revision(revision_);
  message.set_file(file_);
  message.set_unsaved(unsaved_);
  if (!undo_.empty()) message.set_undo(undo_.back().title);
  if (!redo_.empty()) message.set_redo(redo_.back().title);
}

Result<SceneDocument::Step> SceneDocument::prepare(const v1::EditSceneRequest& request,
                                                   const MeasureObject& measure,
                                                   std::vector<std::string>& names) const {
  Step step{title_of(request), scene_, scene_, {}, ""};
  for (const v1::ObjectEdit& edit : request.objects()) {
    auto name = apply_edit(step.after, edit, measure);
    if (!name) return name.error();
    if (!edit.object().empty() && !edit.remove() && edit.object() != *name)
      step.renames.emplace_back(edit.object(), *name);
    names.push_back(std::move(*name));
  }
  if (request.bookmarks()) *step.after.mutable_bookmarks() = request.scene().bookmarks();
  if (request.background()) *step.after.mutable_background_rgb() = request.scene().background_rgb();
  if (MessageDifferencer::Equals(step.before, step.after))
    return invalid_argument("edit: changes nothing; give the fields to set");
  if (auto checked = check_scene(step.after); !checked) return checked.error();
  return step;
}

const SceneDocument::Step* SceneDocument::next(bool redo) const {
  const std::vector<Step>& steps = redo ? redo_ : undo_;
  return steps.empty() ? nullptr : &steps.back();
}

std::string SceneDocument::commit(Step step) {
  scene_ = step.after;
  undo_.push_back(std::move(step));
  if (undo_.size() > kMaxSteps) undo_.erase(undo_.begin());
  redo_.clear();
  return write_journal();
}

std::string SceneDocument::take(bool redo) {
  std::vector<Step>& from = redo ? redo_ : undo_;
  std::vector<Step>& to = redo ? undo_ : redo_;
  Step step = std::move(from.back());
  from.pop_back();
  scene_ = redo ? step.after : step.before;
  to.push_back(std::move(step));
  return write_journal();
}

fs::path SceneDocument::journal_path() const {
  return folder_ / ("." + (file_.empty() ? name_ : file_) + ".unsaved");
}

std::string SceneDocument::write_journal() {
  ++revision_;
  unsaved_ = true;
  const auto text = scene_text(scene_);
  const Result<void> written = text ? write_file_atomically(journal_path(), *text) : text.error();
  return written ? ""
                 : "the change is lost if the server is killed before the scene is saved: " +
                       written.error().message;
}

void SceneDocument::note_file_time() {
  std::error_code error;
  const auto time = fs::last_write_time(folder_ / file_, error);
  file_time_ = error || file_.empty() ? std::nullopt : std::optional(time);
}

bool SceneDocument::changed_on_disk() const {
  if (file_.empty()) return false;
  std::error_code error;
  const auto time = fs::last_write_time(folder_ / file_, error);
  return !error && (!file_time_ || time != *file_time_);
}

void SceneDocument::reload(v1::Scene scene) {
  scene_ = std::move(scene);
  name_objects(scene_);
  undo_.clear();
  redo_.clear();
  unsaved_ = false;
  ++revision_;
  note_file_time();
}

Result<std::string> SceneDocument::save(const std::string& file, bool replace) {
  if (file.empty() && file_.empty())
    return invalid_argument("file: the scene has none yet; give a name such as room.scene.json");
  auto name = file.empty() ? Result<std::string>(file_) : scene_file_name(file);
  if (!name) return name;
  const fs::path path = folder_ / *name;
  std::error_code error;
  const bool exists = fs::exists(path, error);
  if (exists && *name != file_ && !replace)
    return invalid_argument("file: " + *name + " exists; replace it, or give another name");
  if (*name == file_ && changed_on_disk() && !replace)
    return invalid_argument("file: " + *name +
                            " was changed by another program; replace it, or save under another name");
  // Comments and layout of a file that was written by hand are lost in a new version.
  if (exists) fs::copy_file(path, path.string() + ".bak", fs::copy_options::overwrite_existing, error);
  if (error)
    return Error{ErrorCode::Unavailable, *name + ".bak: cannot be written: " + error.message() +
                                             "; make the folder of the scene writable on the server"};
  const auto text = scene_text(scene_);
  if (!text) return text.error();
  if (auto written = write_file_atomically(path, *text); !written) return written.error();
  fs::remove(journal_path(), error);
  file_ = *name;
  unsaved_ = false;
  ++revision_;
  note_file_time();
  return file_;
}

std::vector<v1::SceneChange::Edit> edits_between(const v1::Scene& before, const v1::Scene& after,
                                                 const Renames& renames) {
  std::map<std::string, const v1::Object*> old, now;
  for (int i = 0; i < before.objects_size(); ++i) old[object_name(before.objects(i), i)] = &before.objects(i);
  for (int i = 0; i < after.objects_size(); ++i) now[object_name(after.objects(i), i)] = &after.objects(i);
  std::vector<v1::SceneChange::Edit> removed, changed;
  std::map<std::string, std::string> renamed;  // from, by the new name
  for (const auto& [from, to] : renames) {
    if (old.contains(from) && now.contains(to)) renamed[to] = from;
  }
  for (int i = 0; i < before.objects_size(); ++i) {
    const std::string name = object_name(before.objects(i), i);
    const bool goes =
        !now.contains(name) &&
        std::none_of(renamed.begin(), renamed.end(), [&](const auto& one) { return one.second == name; });
    if (goes) removed.emplace_back().set_object(name);
  }
  for (int i = 0; i < after.objects_size(); ++i) {
    const v1::Object& object = after.objects(i);
    const std::string name = object_name(object, i);
    const std::string from = renamed.contains(name) ? renamed[name] : old.contains(name) ? name : "";
    if (!from.empty() && MessageDifferencer::Equals(*old.at(from), object)) continue;
    v1::SceneChange::Edit& edit = changed.emplace_back();
    edit.set_object(from);
    *edit.mutable_after() = object;
  }
  removed.insert(removed.end(), changed.begin(), changed.end());
  return removed;
}

}  // namespace livegs
