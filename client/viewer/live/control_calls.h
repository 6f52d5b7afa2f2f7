// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "stream/session/scene_control.h"

namespace livegs {

// Asynchronous calls to the server. Calls run one after the other on internal threads, analyses on a separate
// thread from quick calls; replies are collected with take(). Any thread.
class ControlCalls {
 public:
  // `control` must outlive this object. `wake` is called on internal threads after each reply.
  explicit ControlCalls(
      SceneControl& control, std::function<void()> wake = [] {});
  ~ControlCalls();  // cancels running calls

  void set_physics(std::string object, v1::Physics physics);
  // Removes fields of Physics that were set by hand; answered as Physics.
  void restore_estimate(std::string object, std::vector<std::string> fields);
  void accept_proposal(std::string object, bool decline = false);
  void undo_physics(std::string object, bool redo);
  void analyze(std::vector<std::string> objects);
  void control_run(v1::ControlRunRequest request);
  void apply_force(v1::Event::Force force);
  void edit_scene(v1::EditSceneRequest request);
  void undo_edit(bool redo);
  void carry_object(v1::CarryObjectRequest request);  // dropped while an earlier one waits
  void take_part(v1::TakePartRequest request);
  void put_back(std::string object);
  void get_scene();
  void save_scene(v1::SaveSceneRequest request);
  void list_assets();
  // Sends the file, then adds its object with the `edit` as for a new object.
  void upload_asset(std::filesystem::path file, v1::ObjectEdit edit);

  // At most one of the optional values is set; none for an accepted call without a result.
  struct Answer {
    enum class Kind { Physics, Analysis, Run, Force, Edit, Scene, Save, Assets, Preview };
    Kind kind = Kind::Physics;
    std::string object;  // for Physics and Force
    std::optional<v1::PhysicsReply> physics;
    std::optional<v1::AnalysisProgress> progress;
    std::optional<v1::EditSceneReply> edited;
    std::optional<v1::TakePartReply> preview;
    std::optional<v1::SceneDocument> scene;
    std::optional<v1::ListAssetsReply> assets;
    std::string saved;  // name of the scene file
    std::optional<Error> refused;
    uint64_t tick = 0;  // Force: the newest tick at acceptance
    bool last = true;   // the final reply to this call
  };
  std::vector<Answer> take();  // since the last call, in order of arrival

 private:
  class Lane {
   public:
    ~Lane();
    void post(std::function<void()> call);

   private:
    void run(std::stop_token stop);
    std::mutex mutex_;  // guards calls_
    std::condition_variable_any changed_;
    std::deque<std::function<void()>> calls_;
    std::jthread thread_{[this](std::stop_token stop) { run(stop); }};
  };
  void answer(Answer answer);

  SceneControl& control_;
  const std::function<void()> wake_;
  std::mutex mutex_;  // guards answers_
  std::vector<Answer> answers_;
  std::atomic<int> carries_waiting_ = 0;
  Lane quick_, analyses_, edits_;  // last: their threads use all members above
};

}  // namespace livegs
