// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "scene/scene.h"
#include "session/simulation/scene_run.h"
#include "session/support/duration_histogram.h"
#include "session/tick/tick_result.h"

namespace livegs {

// A session without input for this time releases its objects.
inline constexpr int64_t kInputTimeout_ns = 500'000'000;

// A sample for a tick further ahead than this is applied at the next tick.
inline constexpr uint64_t kMaxTicksAhead = 30;

// Waiting samples per session. At 90 Hz a tick consumes one; more wait while ticks are late or if the client
// sends ahead. The oldest are dropped.
inline constexpr size_t kMaxWaitingSamples = 64;

// A tick that starts later than this many periods resets the schedule, so that no burst of ticks follows.
inline constexpr int kMaxPeriodsBehind = 2;

struct SimulationSummary {
  uint64_t ticks = 0;
  uint64_t late_ticks = 0;  // finished after the next tick was due
  uint64_t slips = 0;       // resets of the schedule
  double run_s = 0;
  double step_ms_p50 = 0, step_ms_p99 = 0, step_ms_max = 0, step_ms_total = 0;
  uint64_t shots = 0;
};

// Runs a Scene on its own thread, at the scene's rate on an absolute schedule. Inputs are queued and ticks
// are values: nothing blocks on a client.
//
// A failed allocation ends the process: scene_memory.h refuses scenes that do not fit, and clients resume
// after a restart.
class SimulationLoop : public InputSink {
 public:
  // `sink` must outlive the loop. `observe`, if given, is called with the scene after each step, on the
  // loop's thread.
  SimulationLoop(Scene scene, TickSink& sink, std::function<void(const Scene&)> observe = {});
  ~SimulationLoop() override;

  void start();
  void stop();  // returns after the current tick; may be called more than once

  void on_input(SessionNumber session, std::span<const InputSample> samples) override;
  void on_session_closed(SessionNumber session) override;

  // Records from the first tick on. `recorder` must outlive the loop. Call before start().
  void record_with(TickRecorder& recorder) { recorder_ = &recorder; }

  // Queues a change for the next tick, in the order of the calls. Any thread; returns at once. Changes after
  // the last tick are dropped.
  void post(v1::SceneChange change);
  void post(std::vector<v1::SceneChange> changes);  // for one tick
  // Calls `read` with the scene between two ticks, on the loop's thread, and waits for it. Returns false,
  // without the call, if the loop does not run or takes longer than two seconds.
  bool query(const std::function<void(const Scene&)>& read);
  // Settings of every scene of this loop. Any thread.
  const WorldSettings& world_settings() const { return world_settings_; }
  void set_edit_revision(uint64_t revision);  // RunStatus::edit_revision
  // Halts before the first tick and after every reset, until pause(false).
  void wait_to_start();

  // While paused, ticks continue with unchanged drivers: inputs and changes are accepted, nothing moves.
  void pause(bool paused);
  void step_paused(uint32_t ticks);  // pauses after this many more ticks
  // Sets the status for clients: loading, or the reason of a failure.
  void set_loading(bool loading, std::string message);
  // Replaces the scene at the next tick, before any posted change. `changes` are applied after the changes
  // posted so far; later ones go to the new scene. All ids are new; ticks and simulated time continue.
  void replace(Scene scene, std::vector<v1::SceneChange> changes = {});
  RunStatus run_status() const;

  // Precondition: the loop is not running.
  const Scene& scene() const { return scene_run_.scene(); }
  SimulationSummary summary() const;  // any thread

 private:
  struct Mailbox {
    std::deque<InputSample> samples;
    int64_t last_input_ns = 0;
    uint64_t seen_sequence = 0;  // newest sequence received
  };

  void run();
  void tick();
  // Takes the posted changes and, if there is one, the next scene.
  std::vector<v1::SceneChange> take_next_scene();
  TickActions take_actions(std::vector<v1::SceneChange> changes);
  // Removes and returns the samples that are due at `tick`, and all before them.
  static std::vector<InputSample> due(std::deque<InputSample>& samples, uint64_t tick);
  void log_every_second(int64_t now_ns);
  void answer_query();

  SceneRun scene_run_;  // loop thread only
  const WorldSettings world_settings_;
  TickSink& sink_;
  std::function<void(const Scene&)> observe_;
  TickRecorder* recorder_ = nullptr;

  mutable std::mutex mutex_;  // guards everything down to closed_sessions_
  RunStatus run_;
  uint32_t steps_left_ = 0;  // while paused
  std::optional<Scene> next_scene_;
  std::vector<v1::SceneChange> posted_;
  struct Query;
  std::shared_ptr<Query> query_;  // the one that waits
  std::condition_variable queried_;
  bool waits_to_start_ = false;
  std::map<SessionNumber, Mailbox> mailboxes_;
  std::vector<SessionNumber> closed_sessions_;

  mutable std::mutex summary_mutex_;  // guards the next five
  DurationHistogram step_ms_;
  uint64_t late_ticks_ = 0;
  uint64_t slips_ = 0;
  uint64_t shots_ = 0;
  int64_t started_ns_ = 0, ended_ns_ = 0;

  int64_t logged_ns_ = 0;  // loop thread only
  uint64_t logged_ticks_ = 0;

  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace livegs
