// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/simulation_loop.h"

#include <pthread.h>

#include <cmath>
#include <utility>

#include "core/assert.h"
#include "core/clock.h"
#include "core/log.h"

namespace livegs {
namespace {

// A scene of one tick a second still stops at once.
constexpr int64_t kLongestSleep_ns = 50'000'000;

}  // namespace

SimulationLoop::SimulationLoop(Scene scene, TickSink& sink, std::function<void(const Scene&)> observe)
    : scene_(std::move(scene)), sink_(sink), observe_(std::move(observe)), tick_(scene_.world().tick()) {}

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

void SimulationLoop::hear(SessionNumber session, std::span<const InputSample> samples) {
  const int64_t heard_ns = now_ns();
  std::lock_guard lock(mutex_);
  Mailbox& mailbox = mailboxes_[session];
  mailbox.heard_ns = heard_ns;
  for (const InputSample& sample : samples) {
    if (sample.sequence <= mailbox.seen_sequence) continue;
    mailbox.seen_sequence = sample.sequence;
    mailbox.samples.push_back(sample);
    if (mailbox.samples.size() > kMaxWaitingSamples) mailbox.samples.pop_front();
  }
}

void SimulationLoop::forget(SessionNumber session) {
  std::lock_guard lock(mutex_);
  mailboxes_.erase(session);
  gone_.push_back(session);
}

void SimulationLoop::run() {
  const auto period_ns = static_cast<int64_t>(std::llround(1e9 / scene_.world().settings().rate_hz));
  int64_t due_ns = now_ns();
  {
    std::lock_guard lock(summary_mutex_);
    started_ns_ = ended_ns_ = due_ns;
  }
  logged_ns_ = due_ns;
  while (!stopping_) {
    const int64_t wake_ns = std::min(due_ns, now_ns() + kLongestSleep_ns);
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

void SimulationLoop::post(std::function<void(Scene&)> change) {
  std::lock_guard lock(mutex_);
  posted_.push_back(std::move(change));
}

void SimulationLoop::pause(bool paused) {
  std::lock_guard lock(mutex_);
  run_.paused = paused;
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

void SimulationLoop::replace(Scene scene) {
  std::lock_guard lock(mutex_);
  next_scene_.emplace(std::move(scene));
}

RunStatus SimulationLoop::run_status() const {
  std::lock_guard lock(mutex_);
  return run_;
}

bool SimulationLoop::takes_step() {
  std::lock_guard lock(mutex_);
  if (!run_.paused) return true;
  if (steps_left_ == 0) return false;
  --steps_left_;
  return true;
}

void SimulationLoop::take_next_scene() {
  std::optional<Scene> next;
  {
    std::lock_guard lock(mutex_);
    if (!next_scene_) return;
    next.swap(next_scene_);
    run_.loading = false;
    ++run_.resets;
  }
  simulated_before_ns_ += scene_.world().drivers().simulated_ns;
  for (const SceneObject& object : scene_.objects()) {
    controls_.drop_object(scene_, object.id);
    replaced_.push_back(object.id);
  }
  (void)next->take_changes();  // all of it is new
  scene_ = *std::move(next);
  scene_is_new_ = true;
  log_info("reset: %zu objects are as they were loaded", scene_.objects().size());
}

void SimulationLoop::apply_changes() {
  take_next_scene();
  std::vector<std::function<void(Scene&)>> changes;
  {
    std::lock_guard lock(mutex_);
    changes.swap(posted_);
  }
  for (const auto& change : changes) change(scene_);
}

void SimulationLoop::tick() {
  apply_changes();
  apply_inputs();
  const int64_t begun_ns = now_ns();
  const bool steps = takes_step();
  if (steps) scene_.step();
  ++tick_;
  const int64_t stepped_ns = now_ns();
  const double step_ms = milliseconds_from_ns(stepped_ns - begun_ns);
  {
    std::lock_guard lock(summary_mutex_);
    if (steps) step_ms_.add(step_ms);
    shots_ = controls_.shots();
  }
  if (observe_) observe_(scene_);
  sink_.publish(stepped_tick(stepped_ns, step_ms));
  log_every_second(stepped_ns);
}

std::vector<InputSample> SimulationLoop::due(std::deque<InputSample>& samples, uint64_t tick) {
  std::vector<InputSample> taken;
  while (!samples.empty()) {
    const uint64_t meant = samples.front().for_tick;
    if (meant > tick && meant - tick <= kMostTicksAhead) break;
    taken.push_back(samples.front());
    samples.pop_front();
  }
  return taken;
}

void SimulationLoop::apply_inputs() {
  const double now_s = static_cast<double>(tick_) / scene_.world().settings().rate_hz;
  const uint64_t next_tick = tick_ + 1;
  std::map<SessionNumber, std::vector<InputSample>> arrived;
  std::vector<SessionNumber> gone, stalled;
  {
    std::lock_guard lock(mutex_);
    gone.swap(gone_);
    for (auto& [session, mailbox] : mailboxes_) {
      arrived[session] = due(mailbox.samples, next_tick);
      if (now_ns() - mailbox.heard_ns > kStalledAfter_ns) stalled.push_back(session);
    }
  }
  for (SessionNumber session : gone) {
    controls_.forget(scene_, session);
    applied_.erase(session);
  }
  for (const auto& [session, samples] : arrived) {
    for (const InputSample& sample : samples) controls_.apply(scene_, session, sample, now_s);
    uint64_t& applied = applied_[session];
    if (!samples.empty()) applied = samples.back().sequence;
  }
  for (SessionNumber session : stalled) controls_.release(scene_, session);
}

SteppedTick SimulationLoop::stepped_tick(int64_t stepped_ns, double step_ms) {
  SteppedTick tick;
  tick.drivers = scene_.world().drivers();
  tick.run = run_status();
  tick.run.simulated_s = seconds_from_ns(tick.drivers.simulated_ns);
  tick.drivers.tick = tick_;
  tick.drivers.simulated_ns += simulated_before_ns_;
  tick.stepped_ns = stepped_ns;
  tick.step_ms = step_ms;
  const Scene::Changes changes = scene_.take_changes();
  if (std::exchange(scene_is_new_, false)) {
    tick.added.assign(scene_.objects().begin(), scene_.objects().end());
    tick.removed = std::exchange(replaced_, {});
    for (const auto& [session, sequence] : applied_) tick.hands.push_back({session, sequence, {}});
    return tick;
  }
  for (uint32_t id : changes.added) {
    if (const SceneObject* object = scene_.find(id)) tick.added.push_back(*object);
  }
  for (uint32_t id : changes.changed) {
    if (const SceneObject* object = scene_.find(id)) tick.changed.push_back(*object);
  }
  tick.removed = changes.removed;
  for (uint32_t id : changes.removed) controls_.drop_object(scene_, id);
  for (const auto& [session, sequence] : applied_) {
    tick.hands.push_back({session, sequence, controls_.held_points(scene_, session)});
  }
  return tick;
}

void SimulationLoop::log_every_second(int64_t stepped_ns) {
  if (stepped_ns - logged_ns_ < 1'000'000'000) return;
  const SimulationSummary now = summary();
  log_debug("simulation: tick %llu, %.1f a second, step p50 %.2f ms p99 %.2f ms, %llu late, %llu slips",
            static_cast<unsigned long long>(scene_.world().tick()),
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
