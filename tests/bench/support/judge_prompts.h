// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace livegs {

inline constexpr const char* kJudgeUsage =
    "--judge BEFORE AFTER [--recorded ANSWERS | --record ANSWERS] [--name label|noun|file|none] [--keep "
    "JUDGED.json]";

// Queries a model about the 26 known objects with the prompts of two folders. Prints the figures of both, the
// changes with their intervals, and which folder is better. The model is given by OPENAI_BASE_URL,
// LIVEGS_MODEL and OPENAI_API_KEY, or by recorded answers (both sets in one folder). --name: the object name
// in the prompt; default `none`, because with a label the estimate alone is accurate. --keep writes the
// contents of prompts/judged.json. Returns the exit code: 3 if AFTER is worse.
int judge_prompts(const std::vector<std::string>& words);

}  // namespace livegs
