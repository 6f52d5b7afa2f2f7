// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>

#include "scene/edit/scene_document.h"
#include "session/live/analysis_controller.h"
#include "session/live/room_things.h"
#include "session/simulation/simulation_loop.h"
#include "session/tick/author_control.h"

namespace livegs {

// Applies edits of authors to the document and to the running scene. Edits are prepared on one thread, in the
// order of their arrival: objects are built into the cache first, so that an edit that cannot be built
// changes nothing, and the simulation takes it within a tick.
class SceneAuthor final : public AuthorControl {
 public:
  // `options`: those that the scene was loaded with; they have a cache. `loop` and `analysis` must outlive
  // this.
  SceneAuthor(SceneDocument document, const SceneOptions& options, SimulationLoop& loop,
              AnalysisController& analysis);
  ~SceneAuthor() override;  // ends after the current edit

  void edit(v1::EditSceneRequest request, Answer<v1::EditSceneReply> answer) override;
  void undo(bool redo, Answer<v1::EditSceneReply> answer) override;
  void save(v1::SaveSceneRequest request, Answer<v1::SaveSceneReply> answer) override;
  Result<void> carry(const v1::CarryObjectRequest& request) override;
  v1::SceneDocument document() override;
  v1::ListAssetsReply assets() override;
  v1::RoomParts room_parts() override;
  void take_part(v1::TakePartRequest request, Answer<v1::TakePartReply> answer) override;
  void put_back(const std::string& object, Answer<v1::EditSceneReply> answer) override;
  void note_physics(const std::string& object) override;
  Result<std::unique_ptr<Upload>> upload(const std::string& name) override;

  // The scene as edited, built again for a reset. If another program changed the scene file and there are no
  // unsaved steps, the file is read again. Edits wait until installed() is called on the same thread, once
  // the simulation has the scene; after an error they do not.
  Result<Scene> build(uint32_t first_object_id);
  void installed();

  // Largest file that a client may upload, bytes, and number of edits that may wait.
  static constexpr size_t kMaxUploadBytes = size_t{1} << 30;
  static constexpr size_t kMaxWaiting = 64;

 private:
  void run(std::stop_token stop);
  bool post(std::function<void()> task);
  // Builds the objects of the step and passes them to the simulation.
  Result<std::vector<std::string>> apply(const v1::Scene& before, const v1::Scene& after,
                                         const Renames& renames);
  void keep_sidecars(const v1::Scene& before, const v1::Scene& after, const Renames& renames) const;
  // Builds the environment and keeps it for the simulation.
  Result<void> build_environment_of(const v1::Scene& scene) const;
  Result<BuiltObject> built(const v1::Scene& scene, int index, v1::PhysicsFile* sidecar) const;
  Result<ObjectMeasures> measure(const v1::Object& object) const;
  Result<v1::EditSceneReply> edited(const v1::EditSceneRequest& request);
  Result<v1::EditSceneReply> undone(bool redo);
  // Takes a prepared step: builds, applies and commits it. Returns the warnings.
  Result<std::vector<std::string>> done(SceneDocument::Step step);
  Result<v1::TakePartReply> taken(const v1::TakePartRequest& request);
  Result<v1::EditSceneReply> returned(const std::string& object);
  Result<v1::EditSceneReply> restored(const std::string& object, std::span<const std::string> fields);
  // Adds a revision of an object's sidecar to the steps.
  std::string commit_physics(const std::string& title, const std::string& object);
  void show_revision();

  const SceneOptions options_;
  SimulationLoop& loop_;
  AnalysisController& analysis_;
  std::mutex editing_;  // held by each task of the author's thread, and from build() to installed()
  std::unique_lock<std::mutex> resetting_;
  mutable std::mutex document_mutex_;
  RoomThings things_;
  SceneDocument document_;  // written by the holder of editing_, under the mutex
  std::mutex mutex_;        // guards tasks_
  std::condition_variable_any changed_;
  std::deque<std::function<void()>> tasks_;
  std::jthread thread_;  // last: uses all members above
};

}  // namespace livegs
