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
  std::filesystem::path answers;  // where accepted answers are kept between runs; empty: in memory
};

// The analysis of a scene that is running. It has threads of its own that stand behind the simulation's; what
// it finds changes the scene at a tick boundary, one object as one change. Requests are worked off one after
// the other.
class AnalysisController final : public AnalysisControl {
 public:
  // `endpoint` may be nullptr: everything stays offline. `loop` outlives this.
  AnalysisController(SceneAnalysis scene, std::unique_ptr<ModelEndpoint> endpoint, SimulationLoop& loop,
                     const AnalysisControllerOptions& options = {});
  ~AnalysisController() override;  // cancels, within milliseconds

  // Asks about every AUTO object that no model's values are kept for yet, but for those whose answer a person
  // took back or has still to judge. Returns at once.
  void begin();

  // Gives the loop a scene that was loaded anew. What its file says, what was measured of it and what it was
  // built as hold from now on, and what was decided while it was loaded is applied at its first tick.
  void replace(Scene scene);

  Result<void> analyze(std::vector<std::string> objects, Progress progress, std::function<void()> ended,
                       std::stop_token stop = {}) override;
  Result<v1::PhysicsReply> set_physics(const std::string& object, const v1::Physics& physics,
                                       const std::string& name = "") override;
  Result<v1::PhysicsReply> accept_proposal(const std::string& object) override;
  Result<v1::PhysicsReply> decline_proposal(const std::string& object) override;
  Result<v1::PhysicsReply> undo_physics(const std::string& object, bool redo) override;
  void watch_proposals(Proposed proposed) override;

 private:
  struct Known {
    const SceneAnalysis::Object* object;
    std::unique_ptr<PhysicsOverrides> decided;
  };
  struct Request {
    std::vector<AnalysisTarget> targets;
    Progress progress;
    std::function<void()> ended;
    std::stop_token stop;  // of whoever asked for it
  };
  static constexpr size_t kMaxWaiting = 8;

  void run(std::stop_token stop);
  void work(Request& request, std::stop_token stop);
  // What objects have now, in the targets and beside them.
  std::vector<AnalysisNeighbour> refresh(std::vector<AnalysisTarget>& targets);
  // Takes an answer into the object's decided values and the scene; empty, or why not.
  std::string apply_answer(const AnalysisUpdate& update);
  // What the object has with `file`, brought into the scene at the next tick.
  Result<v1::PhysicsReply> apply(const Known& known, const v1::PhysicsFile& file, const std::string& note);
  // The same without the last step.
  Result<v1::PhysicsReply> reply_of(const Known& known, const v1::PhysicsFile& file, const std::string& note);
  static v1::SceneChange change_of(const v1::PhysicsReply& reply);
  // As it was loaded last.
  SceneAnalysis::Object loaded(const Known& known);
  Result<Known*> find(const std::string& name);
  // Proposals that nobody has judged yet: the log tells of them, and whoever watches. They change nothing of
  // the scene.
  void find_proposals();
  void add_proposal(uint32_t object_id, const v1::PhysicsFile& proposal);
  void remove_proposal(uint32_t object_id);
  bool waits(uint32_t object_id);

  SceneAnalysis scene_;
  std::unique_ptr<ModelEndpoint> endpoint_;
  SimulationLoop& loop_;
  AnalysisControllerOptions options_;
  AnswerCache cache_;
  std::map<uint32_t, Known> known_;  // not changed after construction

  // Held from a decision until the loop has it, so that the scene has what was decided last. Before mutex_.
  std::mutex deciding_;
  std::mutex mutex_;                                    // guards the next five
  std::map<uint32_t, SceneAnalysis::Object> reloaded_;  // by the id it had at first
  std::map<uint32_t, v1::PhysicsFile> proposals_;       // proposals, by object
  Proposed proposed_;
  std::condition_variable_any changed_;
  std::deque<Request> requests_;
  std::jthread thread_;
};

}  // namespace livegs
