// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "analysis/analyze_scene.h"

namespace livegs {

// Renders one object's analysis as a self-contained HTML page: views, question, raw answer, actions of the
// gate, and values with ranges.
//
// The page fetches and runs nothing: pictures are data URLs, and all text from a model, a file or a user is
// escaped. `views` are the views sent to the model; if empty, those of the questions are used. The values are
// update.parameters and should include the user's edits and the scene's values.
// Precondition: stage Finished.
std::string explain_page(const AnalysisTarget& target, const AnalysisUpdate& update,
                         std::span<const TargetView> views = {});

}  // namespace livegs
