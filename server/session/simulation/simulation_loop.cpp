// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/simulation/simulation_loop.h"

#include <pthread.h>

#include <cmath>
#include <new>
#include <utility>

#include "core/assert.h"
#include "core/clock.h"
#include "core/log.h"
#include "session/simulation/memory_reserve.h"

namespace livegs {
namespace {

// A scene of one tick a second still stops at once.
constexpr int64_t kLongestSleep_ns = 50'000'000;

}  // namespace

SimulationLoop::SimulationLoop(Scene scene, TickSink& sink, std::function<void(const Scene&)> observe)
    : scene_run_(std::move(scene)), sink_(sink), observe_(std::move(observe)) {}

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
  const auto period_ns = static_cast<int64_t>(std::llround(1e9 / scene().world().settings().rate_hz));
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

void SimulationLoop::post(v1::SceneChange change) {
  std::lock_guard lock(mutex_);
  posted_.push_back(std::move(change));
}

Result<void> SimulationLoop::pause(bool paused) {
  std::lock_guard lock(mutex_);
  if (!paused) {
    if (auto may = may_go_on(); !may) return may;
    halt_ = Halt::None;
  }
  run_.paused = paused;
  steps_left_ = 0;
  return {};
}

Result<void> SimulationLoop::step_paused(uint32_t ticks) {
  std::lock_guard lock(mutex_);
  if (auto may = may_go_on(); !may) return may;
  run_.paused = true;
  steps_left_ = ticks;
  return {};
}

Result<void> SimulationLoop::may_go_on() const {
  if (halt_ != Halt::GivenUp) return {};
  return Error{ErrorCode::Unavailable, halted_text()};
}

std::string SimulationLoop::halted_text() const {
  const std::string tick = std::to_string(halt_tick_);
  if (halt_ == Halt::GivenUp) {
    return "the scene ended in tick " + tick + ", for which there was no memory; reset loads it anew, with all that was decided";
  }
  return "paused after tick " + tick + ": memory is short; nothing is lost, and it can go on once there is more";
}

void SimulationLoop::set_loading(bool loading, std::string message) {
  std::lock_guard lock(mutex_);
  run_.loading = loading;
  run_.message = std::move(message);
}

void SimulationLoop::replace(Scene scene, std::vector<v1::SceneChange> changes) {
  std::lock_guard lock(mutex_);
  next_scene_.emplace(std::move(scene));
  posted_.insert(posted_.end(), std::make_move_iterator(changes.begin()), std::make_move_iterator(changes.end()));
}

RunStatus SimulationLoop::run_status() const {
  std::lock_guard lock(mutex_);
  RunStatus status = run_;
  if (halt_ == Halt::None) return status;
  status.paused = true;
  if (status.message.empty()) status.message = halted_text();
  return status;
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
    halt_ = Halt::None;
  }
  scene_run_.replace(*std::move(next));
  log_info("reset: %zu objects are as they were loaded", scene().objects().size());
  return changes;
}

void SimulationLoop::tick() {
  // A tick that cannot be told of waits, and none begins that could not be finished.
  if ((unsent_ && !send()) || !MemoryReserve::fill()) {
    std::lock_guard lock(summary_mutex_);
    ++waits_;
    return;
  }
  const MemoryReserve::Lent lent;
  TickActions actions;
  if (!advance(actions)) return;
  const bool was_short = lent.used();
  if (was_short) halt(Halt::MemoryWasShort);
  {
    std::lock_guard lock(summary_mutex_);
    if (actions.stepped) step_ms_.add(unsent_->step_ms);
    shots_ = scene_run_.shots();
  }
  if (observe_ && !scene_run_.given_up()) observe_(scene());
  if (recorder_) recorder_->record(actions, *unsent_, scene());
  const int64_t stepped_ns = unsent_->stepped_ns;
  (void)send();
  // For that alone; who was told already may have resumed it.
  if (!was_short && lent.used()) halt(Halt::MemoryWasShort);
  try {
    log_every_second(stepped_ns);
  } catch (const std::bad_alloc&) {  // a line of the log
  }
}

bool SimulationLoop::advance(TickActions& actions) {
  try {
    std::vector<v1::SceneChange> changes = take_next_scene();
    if (scene_run_.given_up()) {  // what is changed now is decided, and comes with the next scene
      std::vector<SessionNumber> over;
      {
        std::lock_guard lock(mutex_);
        over.swap(gone_);
        for (auto& [session, mailbox] : mailboxes_) mailbox.samples.clear();
      }
      actions.stepped = false;
      unsent_ = scene_run_.hold(over);
    } else {
      actions = take_actions(std::move(changes));
      unsent_ = scene_run_.advance(actions);
    }
    return true;
  } catch (const std::bad_alloc&) {  // the reserve is gone too
    scene_run_.give_up();
    halt(Halt::GivenUp);
    return false;
  }
}

bool SimulationLoop::send() {
  try {
    const double simulated_s = unsent_->run.simulated_s;
    unsent_->run = run_status();
    unsent_->run.simulated_s = simulated_s;
    sink_.publish(std::move(*unsent_));
  } catch (const std::bad_alloc&) {
    return false;
  }
  unsent_.reset();
  return true;
}

void SimulationLoop::halt(Halt why) {
  {
    std::lock_guard lock(mutex_);
    if (halt_ == why || halt_ == Halt::GivenUp) return;  // what was given up is so until a reset
    halt_ = why;
    halt_tick_ = scene_run_.tick() + (why == Halt::GivenUp ? 1 : 0);
    steps_left_ = 0;
  }
  try {
    log_warn("%s", run_status().message.c_str());
  } catch (const std::bad_alloc&) {  // clients are told as soon as there is memory for that
  }
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

TickActions SimulationLoop::take_actions(std::vector<v1::SceneChange> changes) {
  const uint64_t next_tick = scene_run_.tick() + 1;
  TickActions actions;
  actions.changes = std::move(changes);
  std::lock_guard lock(mutex_);
  actions.over.swap(gone_);
  for (auto& [session, mailbox] : mailboxes_) {
    auto samples = due(mailbox.samples, next_tick);
    if (!samples.empty()) actions.samples.push_back({session, std::move(samples)});
    if (now_ns() - mailbox.heard_ns > kStalledAfter_ns && scene_run_.holding(session)) actions.released.push_back(session);
  }
  actions.stepped = (!run_.paused && halt_ == Halt::None) || steps_left_ > 0;
  if (run_.paused && steps_left_ > 0) --steps_left_;
  return actions;
}

void SimulationLoop::log_every_second(int64_t stepped_ns) {
  if (stepped_ns - logged_ns_ < 1'000'000'000) return;
  const SimulationSummary now = summary();
  log_debug("simulation: tick %llu, %.1f a second, step p50 %.2f ms p99 %.2f ms, %llu late, %llu slips",
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
  summary.waits = waits_;
  return summary;
}

}  // namespace livegs
