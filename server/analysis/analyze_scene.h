// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>

#include "analysis/run/analysis_target.h"

// The objects of a scene, worked out: each has its offline answer at once; then the model is asked about
// them, several at a time, and every answer goes through the gate. A model that fails, hangs or lies leaves
// the offline answer where it is.

namespace livegs {

// Views of an object that take longer than this, wall time, are told: the machine is slow or busy, and the
// ten seconds that an object may take are in danger.
inline constexpr double kViewTimeWarning_s = 2;

struct AnalysisSummary {
  size_t objects = 0, accepted = 0, review = 0, refused = 0, failed = 0, cached = 0;
  std::int64_t prompt_tokens = 0, completion_tokens = 0;
  double cost_usd = 0;
  double slowest_views_s = 0;  // of the objects that were asked about; wall time
  std::string failure;  // the first reason why the model could not be asked; empty when it always could
};

// Blocks until every object is finished or `stop` is requested, which ends it within milliseconds. Never call
// it on the simulation's thread. `endpoint` may be nullptr: everything stays offline. `update` is called by
// one thread at a time, for every object first with Offline (before this asks anything) and last with
// Finished. Given the same answers, the same result to the bit, however they come.
AnalysisSummary analyze_scene(std::span<const AnalysisTarget> targets, ModelEndpoint* endpoint,
                              const TargetViews& views, const AnalysisOptions& options,
                              const std::function<void(const AnalysisUpdate&)>& update,
                              std::stop_token stop = {});

}  // namespace livegs
