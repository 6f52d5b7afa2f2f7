// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace livegs {

inline constexpr const char* kJudgeUsage =
    "--judge BEFORE AFTER [--recorded ANSWERS | --record ANSWERS] [--name label|noun|file|none] [--keep "
    "JUDGED.json]";

// Asks a model about the 26 known objects with the prompts of each of two folders and prints both sets'
// figures, the changes with their intervals, and which set is better. The model is the one of
// OPENAI_BASE_URL, LIVEGS_MODEL and OPENAI_API_KEY, or answers that were recorded (both sets in one folder).
// --name: what the model is told the object is; none unless told, since with a label the estimate alone is
// good already. --keep writes what prompts/judged.json holds. Returns the exit code: 3 where AFTER is worse.
int judge_prompts(const std::vector<std::string>& words);

}  // namespace livegs
