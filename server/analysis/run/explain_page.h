// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "analysis/analyze_scene.h"

namespace livegs {

// One object's analysis as one self-contained HTML page, for a person: the views, what was asked, the raw
// answer, what the gate did, and the values with their ranges. Nothing in it is fetched or run: pictures are
// data URLs, and all text that came from a model, a file or a person is escaped. `views` are the looks at the
// object, those that the model was shown if it was asked; none: what went with the questions is shown. The
// values are update.parameters: hand over what the object has in the end, a person's edits and the scene's
// words in it. Precondition: stage Finished.
std::string explain_page(const AnalysisTarget& target, const AnalysisUpdate& update,
                         std::span<const TargetView> views = {});

}  // namespace livegs
