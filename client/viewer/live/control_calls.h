// SPDX-License-Identifier: Apache-2.0
#pragma once

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

// Calls to the server that a drawer makes without waiting: they are made one after the other on threads of
// their own, analyses on another than what is quick, and answers are fetched when it is convenient. Any
// thread.
class ControlCalls {
 public:
  explicit ControlCalls(SceneControl& control);  // which outlives this
  ~ControlCalls();                               // cancels what is under way

  void set_physics(std::string object, v1::Physics physics);
  void accept_proposal(std::string object, bool decline = false);
  void undo_physics(std::string object, bool redo);
  void analyze(std::vector<std::string> objects);
  void control_run(v1::ControlRunRequest request);
  void apply_force(v1::Event::Force force);

  // One of `physics`, `progress` and `refused` is there, or none for a call that was taken and says nothing.
  struct Answer {
    enum class Kind { Physics, Analysis, Run, Force };
    Kind kind = Kind::Physics;
    std::string object;  // of Physics and Force
    std::optional<v1::PhysicsReply> physics;
    std::optional<v1::AnalysisProgress> progress;
    std::optional<Error> refused;
    uint64_t tick = 0;  // of Force: the newest when it was taken
    bool last = true;   // no further answer of this call comes
  };
  std::vector<Answer> take();  // since the last call, in the order they came

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
  std::mutex mutex_;  // guards answers_
  std::vector<Answer> answers_;
  Lane quick_, analyses_;  // last: their threads use all of the above
};

}  // namespace livegs
