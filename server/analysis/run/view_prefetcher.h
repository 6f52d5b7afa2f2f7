// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <thread>
#include <vector>

#include "analysis/run/analysis_target.h"

namespace livegs {

// Makes the views of a scene's objects in their order while others wait for their answers, so that drawing
// and waiting overlap. Threads of its own.
class ViewPrefetcher {
 public:
  // How many objects may be drawn and not yet asked about: bounds the memory, about a megabyte an object.
  static constexpr size_t kMaxAhead = 2 * kContextLag;

  // `targets` and `views` outlive this.
  ViewPrefetcher(std::span<const AnalysisTarget> targets, const TargetViews& views,
                 const AnalysisOptions& options, std::stop_token stop);
  ~ViewPrefetcher();  // stops what is being made

  struct Made {
    Result<std::vector<TargetView>> views;
    double wall_s = 0;  // that making them took
  };
  // The views of target `index`, once. Blocks until they are made or a stop is requested, which is an error.
  // Each target is to be taken, in any order that keeps within kContextLag of the first one that is left.
  Made take(size_t index);

 private:
  void work();

  std::span<const AnalysisTarget> targets_;
  const TargetViews& views_;
  const int count_;
  const bool behind_;

  std::mutex mutex_;  // guards what follows, but the threads
  std::condition_variable_any changed_;
  size_t next_ = 0, taken_ = 0;
  std::vector<std::optional<Made>> made_;
  std::stop_token asked_to_stop_;
  std::stop_source ended_;
  std::optional<std::stop_callback<std::function<void()>>> follow_;
  std::vector<std::jthread> threads_;
};

}  // namespace livegs
