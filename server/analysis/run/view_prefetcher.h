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

// Renders the views of a scene's objects in order, on its own threads, while queries wait for answers.
// Rendering and waiting overlap.
class ViewPrefetcher {
 public:
  // Maximum number of objects rendered but not yet queried. Bounds the memory, about one megabyte per object.
  static constexpr size_t kMaxAhead = 2 * kContextLag;

  // `targets` and `views` must outlive this.
  ViewPrefetcher(std::span<const AnalysisTarget> targets, const TargetViews& views,
                 const AnalysisOptions& options, std::stop_token stop);
  ~ViewPrefetcher();  // stops the rendering

  struct Made {
    Result<std::vector<TargetView>> views;
    double wall_s = 0;  // of rendering them
  };
  // Returns the views of target `index`; call once per target. Blocks until they are ready; a requested stop
  // is an error. Every target must be taken, in any order within kContextLag of the first one left.
  Made take(size_t index);

 private:
  void work();

  std::span<const AnalysisTarget> targets_;
  const TargetViews& views_;
  const int count_;
  const bool behind_;

  std::mutex mutex_;  // guards all members below except the threads
  std::condition_variable_any changed_;
  size_t next_ = 0, taken_ = 0;
  std::vector<std::optional<Made>> made_;
  std::stop_token asked_to_stop_;
  std::stop_source ended_;
  std::optional<std::stop_callback<std::function<void()>>> follow_;
  std::vector<std::jthread> threads_;
};

}  // namespace livegs
