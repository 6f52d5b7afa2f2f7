// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/run/analysis_target.h"

namespace livegs {

// Queries the model about one object: views, a question for each, the gate, and one repair if the answer is
// faulty. `known` is the state of the endpoint before the first query, so that a question's hash does not
// depend on later state. Fills all of `update` except its index; calls `staged` when a question or repair is
// sent. Blocks.
void ask_model(const AnalysisTarget& target, const std::vector<SceneObjectFacts>& neighbours,
               ModelEndpoint& endpoint, const EndpointState& known, const TargetViews& views,
               const AnalysisOptions& options, const std::function<void(AnalysisStage)>& staged,
               std::stop_token stop, AnalysisUpdate& update);

}  // namespace livegs
