// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "scene/scene.h"
#include "session/simulation/scene_run.h"
#include "session/support/duration_histogram.h"
#include "session/tick/tick_result.h"

namespace livegs {

// A session that was silent for so long holds nothing any more.
inline constexpr int64_t kInputTimeout_ns = 500'000'000;

// A sample that is meant for a tick further ahead is not believed and goes into the next.
inline constexpr uint64_t kMaxTicksAhead = 30;

// Samples of one session that wait for their tick. At 90 Hz a tick sees one; more wait while ticks are late
// or the client sends ahead.
inline constexpr size_t kMaxWaitingSamples = 64;

// A tick that starts later than this many periods gives up the schedule: time slips, and no burst of ticks
// follows.
inline constexpr int kMaxPeriodsBehind = 2;

struct SimulationSummary {
  uint64_t ticks = 0;
  uint64_t late_ticks = 0;  // whose step was not done before the next tick was due
  uint64_t slips = 0;       // times the schedule was given up
  double run_s = 0;
  double step_ms_p50 = 0, step_ms_p99 = 0, step_ms_max = 0, step_ms_total = 0;
  uint64_t shots = 0;
};

// Runs a Scene on a thread of its own, at the scene's rate against an absolute schedule. Inputs come by
// queue, ticks go out as values: nothing in here waits for a client.
//
// A failed allocation ends the process: scene_memory.h refuses scenes that do not fit, and a restarted server
// gets its clients back.
class SimulationLoop : public InputSink {
 public:
  // `sink` outlives the loop. `observe`, if given, sees the scene after each step, on the loop's thread.
  SimulationLoop(Scene scene, TickSink& sink, std::function<void(const Scene&)> observe = {});
  ~SimulationLoop() override;

  void start();
  void stop();  // returns when the tick that is running is done; more than once is fine

  void on_input(SessionNumber session, std::span<const InputSample> samples) override;
  void on_session_closed(SessionNumber session) override;

  // From the first tick on; it outlives the loop. Before start().
  void record_with(TickRecorder& recorder) { recorder_ = &recorder; }

  // Changes the scene at the beginning of the next tick, on the loop's thread, in the order of the calls. Any
  // thread; returns at once. What is posted after the last tick is dropped.
  void post(v1::SceneChange change);

  // Halted, ticks go on with the same drivers, inputs and changes are taken, and nothing moves.
  void pause(bool paused);
  void step_paused(uint32_t ticks);  // halts after this many more ticks
  // What clients are told: a scene is being loaded, or why that failed.
  void set_loading(bool loading, std::string message);
  // At the next tick this scene takes the place of the one that runs, before anything that was posted and
  // before `changes`, which come after that; what is posted from now on goes to it. Its ids are all new;
  // ticks and the clients' simulated time go on.
  void replace(Scene scene, std::vector<v1::SceneChange> changes = {});
  RunStatus run_status() const;

  // Precondition: not running.
  const Scene& scene() const { return scene_run_.scene(); }
  SimulationSummary summary() const;  // any thread

 private:
  struct Mailbox {
    std::deque<InputSample> samples;
    int64_t heard_ns = 0;
    uint64_t seen_sequence = 0;  // the newest ever put in
  };

  void run();
  void tick();
  // What was posted up to the moment at which the scene of this tick was settled.
  std::vector<v1::SceneChange> take_next_scene();
  TickActions take_actions(std::vector<v1::SceneChange> changes);
  // Of a session's samples those whose tick has come, and all before them.
  static std::vector<InputSample> due(std::deque<InputSample>& samples, uint64_t tick);
  void log_every_second(int64_t now_ns);

  SceneRun scene_run_;  // the loop's thread only
  TickSink& sink_;
  std::function<void(const Scene&)> observe_;
  TickRecorder* recorder_ = nullptr;

  mutable std::mutex mutex_;  // guards everything down to closed_sessions_
  RunStatus run_;
  uint32_t steps_left_ = 0;  // while halted
  std::optional<Scene> next_scene_;
  std::vector<v1::SceneChange> posted_;
  std::map<SessionNumber, Mailbox> mailboxes_;
  std::vector<SessionNumber> closed_sessions_;

  mutable std::mutex summary_mutex_;  // guards the next five
  DurationHistogram step_ms_;
  uint64_t late_ticks_ = 0;
  uint64_t slips_ = 0;
  uint64_t shots_ = 0;
  int64_t started_ns_ = 0, ended_ns_ = 0;

  int64_t logged_ns_ = 0;  // the loop's thread only
  uint64_t logged_ticks_ = 0;

  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace livegs
