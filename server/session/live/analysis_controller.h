// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "analysis/model/answer_cache.h"
#include "scene/views/scene_analysis.h"
#include "session/live/physics_overrides.h"
#include "session/simulation/simulation_loop.h"
#include "session/tick/analysis_control.h"

namespace livegs {

struct AnalysisControllerOptions {
  int views = 1;
  std::filesystem::path answers;  // folder of accepted answers; empty: in memory
};

// Analyses the objects of a running scene on its own threads, with lower priority than the simulation.
// Results are applied at a tick boundary, one object at a time. Requests are processed in order.
class AnalysisController final : public AnalysisControl {
 public:
  // `endpoint` may be null: offline estimates only. `loop` must outlive this.
  AnalysisController(SceneAnalysis scene, std::unique_ptr<ModelEndpoint> endpoint, SimulationLoop& loop,
                     const AnalysisControllerOptions& options = {});
  ~AnalysisController() override;  // cancels the current request within milliseconds

  // Starts the analysis of every AUTO object without values from a model, except those whose answer was
  // undone or waits for a decision. Returns at once.
  void begin();

  // Updates the set of objects after an edit: removed names and newly built objects. Values and proposals of
  // an object that was built again are read from its sidecar.
  void change(const std::vector<std::string>& gone, std::span<const BuiltObject> fresh);

  // Passes a reloaded scene to the loop. Its file, measurements and body types are used from now on.
  // Decisions made during loading are applied at its first tick.
  void replace(Scene scene);

  Result<void> analyze(std::vector<std::string> objects, Progress progress, std::function<void()> ended,
                       std::stop_token stop = {}) override;
  Result<v1::PhysicsReply> set_physics(const std::string& object, const v1::Physics& physics,
                                       const std::string& name = "") override;
  Result<v1::PhysicsReply> accept_proposal(const std::string& object) override;
  Result<v1::PhysicsReply> decline_proposal(const std::string& object) override;
  Result<v1::PhysicsReply> undo_physics(const std::string& object, bool redo) override;
  // Removes fields of Physics that were set by hand; the estimate, or the scene file, determines them again.
  Result<v1::PhysicsReply> restore_estimate(const std::string& object, std::span<const std::string> fields);
  void watch_proposals(Proposed proposed) override;

 private:
  struct Known {
    SceneAnalysis::Object object;
    std::unique_ptr<PhysicsOverrides> decided;
    bool gone = false;  // removed by an edit; kept for running analyses
  };
  struct Request {
    std::vector<AnalysisTarget> targets;
    Progress progress;
    std::function<void()> ended;
    std::stop_token stop;  // requested by the caller
  };
  static constexpr size_t kMaxWaiting = 8;

  void run(std::stop_token stop);
  void work(Request& request, std::stop_token stop);
  // Updates the targets with their current values and returns the other objects.
  std::vector<AnalysisNeighbour> refresh(std::vector<AnalysisTarget>& targets);
  // Applies an answer to the stored values and to the scene. Returns the error or warnings; empty without
  // any.
  std::string apply_answer(const AnalysisUpdate& update);
  // Applies `file` to the object at the next tick; returns its resulting values.
  Result<v1::PhysicsReply> apply(const Known& known, const v1::PhysicsFile& file, const std::string& note);
  // The resulting values only, without applying them.
  Result<v1::PhysicsReply> reply_of(const Known& known, const v1::PhysicsFile& file, const std::string& note);
  static v1::SceneChange change_of(const v1::PhysicsReply& reply);
  // The object as last loaded.
  SceneAnalysis::Object loaded(const Known& known);
  Result<Known*> find(const std::string& name);
  // Proposals that wait for a decision. They are logged and reported to the watcher, and do not change the
  // scene.
  void find_proposals();
  void add_proposal(uint32_t object_id, const v1::PhysicsFile& proposal);
  void remove_proposal(uint32_t object_id);
  bool waits(uint32_t object_id);
  Known& at(uint32_t object_id);
  std::vector<std::pair<uint32_t, Known*>> present();  // objects of the scene now
  SceneAnalysis snapshot();

  std::unique_ptr<ModelEndpoint> endpoint_;
  SimulationLoop& loop_;
  AnalysisControllerOptions options_;
  AnswerCache cache_;

  // Locked from a decision until the loop has received it, so that the last decision applies. Locked before
  // mutex_.
  std::mutex deciding_;
  std::mutex mutex_;  // guards the next eight
  // Entries are added and never erased, so that references stay valid.
  std::map<uint32_t, Known> known_;
  SceneAnalysis scene_;
  uint32_t next_id_ = 1u << 31;  // of objects that authors add; above the ids of scenes
  std::map<uint32_t, SceneAnalysis::Object> reloaded_;  // by initial id
  std::map<uint32_t, v1::PhysicsFile> proposals_;       // by object id
  Proposed proposed_;
  std::condition_variable_any changed_;
  std::deque<Request> requests_;
  std::jthread thread_;
};

}  // namespace livegs
