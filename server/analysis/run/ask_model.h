// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/run/analysis_target.h"

namespace livegs {

// One object and the model: a look, a question, an answer through the gate, once more if it would not do; for
// each view. `known` is the endpoint's state before anything was asked, so that a question's hash does not
// depend on what was learned since. Fills in all of `update` but its index, and calls `staged` when the
// question or the repair is under way. Blocks.
void ask_model(const AnalysisTarget& target, const std::vector<SceneObjectFacts>& neighbours,
               ModelEndpoint& endpoint, const EndpointState& known, const TargetViews& views,
               const AnalysisOptions& options, const std::function<void(AnalysisStage)>& staged,
               std::stop_token stop, AnalysisUpdate& update);

}  // namespace livegs
