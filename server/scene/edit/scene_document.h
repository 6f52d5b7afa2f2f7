// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result.h"
#include "livegs/v1/author.pb.h"
#include "livegs/v1/recording.pb.h"
#include "scene/edit/object_edit.h"
#include "scene/scene.h"

namespace livegs {

// Names of objects before and after.
using Renames = std::vector<std::pair<std::string, std::string>>;

// The edited scene: a Scene message, one log of steps for undo, and the files in which it is stored. One
// thread at a time.
//
// The journal .FILE.unsaved (.NAME.unsaved without a file) holds the whole document as a scene file. It is
// replaced after every step and removed by a save, so a killed server loses at most the current step.
class SceneDocument {
 public:
  // `text`: the scene as read. Continues from the journal of an earlier run if there is one: its changes are
  // then one step that can be undone.
  static Result<SceneDocument> open(SceneText text);

  const v1::Scene& scene() const { return scene_; }
  const std::filesystem::path& folder() const { return folder_; }
  const std::string& name() const { return name_; }  // of the scene, as Scene::name()
  const std::string& file() const { return file_; }  // in folder(); empty if the scene has none
  uint64_t revision() const { return revision_; }    // starts at 1
  bool unsaved() const { return unsaved_; }
  void describe(v1::SceneDocument& message) const;

  struct Step {
    std::string title;
    v1::Scene before, after;
    Renames renames;  // from before to after
    // The step is a revision of this object's sidecar; before and after are equal. Empty: it is not.
    std::string physics_object;
  };
  // Returns the checked step of a request, without changing the document. `names`: of the request's objects
  // after the step.
  Result<Step> prepare(const v1::EditSceneRequest& request, const MeasureObject& measure,
                       std::vector<std::string>& names) const;
  // The next step of undo or redo; nullptr if there is none.
  const Step* next(bool redo) const;

  // Each returns a warning if the journal could not be written. The document has changed even then.
  std::string commit(Step step);  // a new step; undone steps are discarded
  std::string take(bool redo);    // precondition: next(redo)

  // Writes the scene file: `file` in the scene's folder, or if empty the scene's own. An earlier version of
  // an existing file is kept as FILE.bak. Returns the file's name.
  Result<std::string> save(const std::string& file, bool replace);

  // Whether the scene file was changed by another program since it was read or saved.
  bool changed_on_disk() const;
  // Replaces the document by a scene that was read again; all steps are discarded.
  void reload(v1::Scene scene);

  // Maximum number of steps that can be undone; older ones are discarded. A step has two copies of the scene,
  // some kB.
  static constexpr size_t kMaxSteps = 500;

 private:
  std::filesystem::path journal_path() const;
  std::string write_journal();
  void note_file_time();

  std::filesystem::path folder_;
  std::string name_, file_;  // file_: empty if the scene has none
  v1::Scene scene_;
  std::vector<Step> undo_, redo_;
  uint64_t revision_ = 1;
  bool unsaved_ = false;
  std::optional<std::filesystem::file_time_type> file_time_;
};

// The edits that turn one scene into another, object by object. A renamed object is one edit.
std::vector<v1::SceneChange::Edit> edits_between(const v1::Scene& before, const v1::Scene& after,
                                                 const Renames& renames);

// A scene as the text of a scene file.
Result<std::string> scene_text(const v1::Scene& scene);

}  // namespace livegs
