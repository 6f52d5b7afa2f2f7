// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/run/view_prefetcher.h"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

#include "core/clock.h"
#include "core/serial_here.h"

namespace livegs {
namespace {

// At most one core per thread; with `behind`, a small part of it while others need it. The idle class is
// unsuitable: next to busy programs it may get no time for minutes.
constexpr int kBackgroundNice = 15;
void become_drawer(bool behind) {
  pthread_setname_np(pthread_self(), "views");
  if (behind) (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kBackgroundNice);
  set_serial_here(true);
}

}  // namespace

ViewPrefetcher::ViewPrefetcher(std::span<const AnalysisTarget> targets, const TargetViews& views,
                               const AnalysisOptions& options, std::stop_token stop)
    : targets_(targets),
      views_(views),
      count_(options.views),
      behind_(options.behind),
      made_(targets.size()),
      asked_to_stop_(std::move(stop)) {
  follow_.emplace(asked_to_stop_, [this] { ended_.request_stop(); });
  // Next to a simulation, half of the cores are reserved for the threads of the tick.
  const size_t cores = std::max(1u, std::thread::hardware_concurrency() / (behind_ ? 2 : 1));
  for (size_t i = 0; i < std::min({cores, kContextLag, targets.size()}); ++i) {
    threads_.emplace_back([this] { work(); });
  }
}

ViewPrefetcher::~ViewPrefetcher() { ended_.request_stop(); }

void ViewPrefetcher::work() {
  become_drawer(behind_);
  const std::stop_token stop = ended_.get_token();
  for (;;) {
    size_t index = 0;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return next_ >= targets_.size() || next_ < taken_ + kMaxAhead; });
      if (stop.stop_requested() || next_ >= targets_.size()) return;
      index = next_++;
    }
    const std::int64_t begun_ns = now_ns();
    Made made{views_(targets_[index].object_id, count_, stop)};
    made.wall_s = seconds_from_ns(now_ns() - begun_ns);
    std::lock_guard lock(mutex_);
    made_[index] = std::move(made);
    changed_.notify_all();
  }
}

ViewPrefetcher::Made ViewPrefetcher::take(size_t index) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait(lock, ended_.get_token(), [&] { return made_[index].has_value(); })) {
    return {Error{ErrorCode::Unavailable, "cancelled"}};
  }
  Made made = std::move(*made_[index]);
  made_[index].reset();
  ++taken_;
  changed_.notify_all();
  return made;
}

}  // namespace livegs
