// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>

#include "analysis/run/analysis_target.h"

// Material analysis of all objects of a scene. Each object gets its offline estimate at once. The language
// model is then queried for several objects concurrently, and every answer passes the acceptance gate. If the
// model fails, times out or answers wrongly, the offline estimate stays in effect.

namespace livegs {

// Rendering the views of an object for longer than this (seconds, wall time) is logged as a warning. The time
// budget of an object is ten seconds; slow views mean a slow or busy machine.
inline constexpr double kViewTimeWarning_s = 2;

struct AnalysisSummary {
  size_t objects = 0, accepted = 0, review = 0, refused = 0, failed = 0, cached = 0;
  std::int64_t prompt_tokens = 0, completion_tokens = 0;
  double cost_usd = 0;
  double slowest_views_s = 0;  // over the queried objects; wall time
  std::string failure;         // the first reason why a query failed; empty if none failed
};

// Blocks until every object is finished or `stop` is requested; a stop takes milliseconds.
// Must not be called on the simulation thread. `endpoint` may be nullptr: the analysis is then offline only.
// `update` is called from one thread at a time: first with Offline for every object, before any query, and
// last with Finished.
// The result is bitwise reproducible for the same answers, in whatever order they arrive.
AnalysisSummary analyze_scene(std::span<const AnalysisTarget> targets, ModelEndpoint* endpoint,
                              const TargetViews& views, const AnalysisOptions& options,
                              const std::function<void(const AnalysisUpdate&)>& update,
                              std::stop_token stop = {});

}  // namespace livegs
