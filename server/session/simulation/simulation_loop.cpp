// SPDX-License-Identifier: GPL-3.0-or-later
// The thread and the schedule of the simulation. scene_run.cpp advances the scene and numbers its ticks.
#include "session/simulation/simulation_loop.h"

#include <pthread.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "core/assert.h"
#include "core/clock.h"
#include "core/log.h"

namespace livegs {
namespace {

// Longest sleep, so that a loop with a low tick rate stops promptly.
constexpr int64_t kMaxSleep_ns = 50'000'000;

}  // namespace

SimulationLoop::SimulationLoop(Scene scene, TickSink& sink, std::function<void(const Scene&)> observe)
    : scene_run_(std::move(scene)),
      world_settings_(scene_run_.scene().world().settings()),
      sink_(sink),
      observe_(std::move(observe)) {}

SimulationLoop::~SimulationLoop() { stop(); }

void SimulationLoop::start() {
  LIVEGS_ASSERT(!thread_.joinable());
  stopping_ = false;
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "simulation");
    run();
  });
}

void SimulationLoop::stop() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void SimulationLoop::on_input(SessionNumber session, std::span<const InputSample> samples) {
  const int64_t received_ns = now_ns();
  std::lock_guard lock(mutex_);
  Mailbox& mailbox = mailboxes_[session];
  mailbox.last_input_ns = received_ns;
  for (const InputSample& sample : samples) {
    if (sample.sequence <= mailbox.seen_sequence) continue;
    mailbox.seen_sequence = sample.sequence;
    mailbox.samples.push_back(sample);
    if (mailbox.samples.size() > kMaxWaitingSamples) mailbox.samples.pop_front();
  }
}

void SimulationLoop::on_session_closed(SessionNumber session) {
  std::lock_guard lock(mutex_);
  mailboxes_.erase(session);
  closed_sessions_.push_back(session);
}

void SimulationLoop::run() {
  const auto period_ns = static_cast<int64_t>(std::llround(1e9 / scene().world().settings().rate_hz));
  int64_t due_ns = now_ns();
  {
    std::lock_guard lock(summary_mutex_);
    started_ns_ = ended_ns_ = due_ns;
  }
  logged_ns_ = due_ns;
  while (!stopping_) {
    const int64_t wake_ns = std::min(due_ns, now_ns() + kMaxSleep_ns);
    sleep_until_ns(wake_ns);
    if (now_ns() < due_ns) continue;
    tick();
    due_ns += period_ns;
    const int64_t done_ns = now_ns();
    std::lock_guard lock(summary_mutex_);
    ended_ns_ = done_ns;
    if (done_ns > due_ns) ++late_ticks_;
    if (done_ns > due_ns + kMaxPeriodsBehind * period_ns) {
      ++slips_;
      due_ns = done_ns;
    }
  }
}

void SimulationLoop::post(v1::SceneChange change) {
  std::lock_guard lock(mutex_);
  posted_.push_back(std::move(change));
}

void SimulationLoop::post(std::vector<v1::SceneChange> changes) {
  std::lock_guard lock(mutex_);
  posted_.insert(posted_.end(), std::make_move_iterator(changes.begin()),
                 std::make_move_iterator(changes.end()));
}

struct SimulationLoop::Query {
  std::function<void(const Scene&)> read;
  bool begun = false, done = false;  // guarded by SimulationLoop::mutex_
};

bool SimulationLoop::query(const std::function<void(const Scene&)>& read) {
  const auto query = std::make_shared<Query>();
  query->read = read;
  std::unique_lock lock(mutex_);
  if (query_) return false;
  query_ = query;
  queried_.wait_for(lock, std::chrono::seconds(2), [&] { return query->done; });
  if (query->begun) queried_.wait(lock, [&] { return query->done; });  // it reads the caller's values
  if (query_ == query) query_.reset();
  return query->done;
}

void SimulationLoop::answer_query() {
  std::unique_lock lock(mutex_);
  if (!query_) return;
  const std::shared_ptr<Query> query = std::exchange(query_, nullptr);
  query->begun = true;
  lock.unlock();
  query->read(scene());
  lock.lock();
  query->done = true;
  queried_.notify_all();
}

void SimulationLoop::set_edit_revision(uint64_t revision) {
  std::lock_guard lock(mutex_);
  run_.edit_revision = revision;
}

void SimulationLoop::wait_to_start() {
  std::lock_guard lock(mutex_);
  waits_to_start_ = run_.paused = run_.waiting = true;
}

void SimulationLoop::pause(bool paused) {
  std::lock_guard lock(mutex_);
  run_.paused = paused;
  if (!paused) run_.waiting = false;
  steps_left_ = 0;
}

void SimulationLoop::step_paused(uint32_t ticks) {
  std::lock_guard lock(mutex_);
  run_.paused = true;
  steps_left_ = ticks;
}

void SimulationLoop::set_loading(bool loading, std::string message) {
  std::lock_guard lock(mutex_);
  run_.loading = loading;
  run_.message = std::move(message);
}

void SimulationLoop::replace(Scene scene, std::vector<v1::SceneChange> changes) {
  std::lock_guard lock(mutex_);
  next_scene_.emplace(std::move(scene));
  posted_.insert(posted_.end(), std::make_move_iterator(changes.begin()),
                 std::make_move_iterator(changes.end()));
}

RunStatus SimulationLoop::run_status() const {
  std::lock_guard lock(mutex_);
  return run_;
}

std::vector<v1::SceneChange> SimulationLoop::take_next_scene() {
  std::optional<Scene> next;
  std::vector<v1::SceneChange> changes;
  {
    std::lock_guard lock(mutex_);
    changes.swap(posted_);
    if (!next_scene_) return changes;
    next.swap(next_scene_);
    run_.loading = false;
    ++run_.resets;
    if (waits_to_start_) run_.paused = run_.waiting = true;
  }
  scene_run_.replace(*std::move(next));
  log_info("reset: %zu objects reloaded", scene().objects().size());
  return changes;
}

void SimulationLoop::tick() {
  answer_query();
  const TickActions actions = take_actions(take_next_scene());
  TickResult stepped = scene_run_.advance(actions);
  {
    std::lock_guard lock(summary_mutex_);
    if (actions.stepped) step_ms_.add(stepped.step_ms);
    shots_ = scene_run_.shots();
  }
  if (observe_) observe_(scene());
  if (recorder_) recorder_->record(actions, stepped, scene());
  const int64_t stepped_ns = stepped.stepped_ns;
  const double simulated_s = stepped.run.simulated_s;
  stepped.run = run_status();
  stepped.run.simulated_s = simulated_s;
  sink_.publish(std::move(stepped));
  log_every_second(stepped_ns);
}

std::vector<InputSample> SimulationLoop::due(std::deque<InputSample>& samples, uint64_t tick) {
  std::vector<InputSample> taken;
  while (!samples.empty()) {
    const uint64_t meant = samples.front().for_tick;
    if (meant > tick && meant - tick <= kMaxTicksAhead) break;
    taken.push_back(samples.front());
    samples.pop_front();
  }
  return taken;
}

TickActions SimulationLoop::take_actions(std::vector<v1::SceneChange> changes) {
  const uint64_t next_tick = scene_run_.tick() + 1;
  TickActions actions;
  actions.changes = std::move(changes);
  std::lock_guard lock(mutex_);
  actions.over.swap(closed_sessions_);
  for (auto& [session, mailbox] : mailboxes_) {
    auto samples = due(mailbox.samples, next_tick);
    if (!samples.empty()) actions.samples.push_back({session, std::move(samples)});
    if (now_ns() - mailbox.last_input_ns > kInputTimeout_ns && scene_run_.holding(session))
      actions.released.push_back(session);
  }
  actions.stepped = !run_.paused || steps_left_ > 0;
  if (run_.paused && steps_left_ > 0) --steps_left_;
  return actions;
}

void SimulationLoop::log_every_second(int64_t stepped_ns) {
  if (stepped_ns - logged_ns_ < 1'000'000'000) return;
  const SimulationSummary now = summary();
  log_debug("simulation: tick %llu, %.1f per second, step p50 %.2f ms p99 %.2f ms, %llu late, %llu slips",
            static_cast<unsigned long long>(scene().world().tick()),
            static_cast<double>(now.ticks - logged_ticks_) / seconds_from_ns(stepped_ns - logged_ns_),
            now.step_ms_p50, now.step_ms_p99, static_cast<unsigned long long>(now.late_ticks),
            static_cast<unsigned long long>(now.slips));
  logged_ns_ = stepped_ns;
  logged_ticks_ = now.ticks;
}

SimulationSummary SimulationLoop::summary() const {
  std::lock_guard lock(summary_mutex_);
  SimulationSummary summary;
  summary.ticks = step_ms_.count();
  summary.late_ticks = late_ticks_;
  summary.slips = slips_;
  summary.run_s = seconds_from_ns(ended_ns_ - started_ns_);
  summary.step_ms_p50 = step_ms_.percentile(0.50);
  summary.step_ms_p99 = step_ms_.percentile(0.99);
  summary.step_ms_max = step_ms_.largest();
  summary.step_ms_total = step_ms_.sum();
  summary.shots = shots_;
  return summary;
}

}  // namespace livegs
