// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"
#include "server/analysis/model/prompt_trial.h"

// Reads and checks prompts/judged.json: the judged prompts, the model, and the measurements. A changed prompt
// that is not judged again no longer matches.

namespace livegs {

// Prefix of the model name for synthetic answers of tests. They exercise the judging but are not evidence.
inline constexpr const char* kMadeUpModel = "made-up";

// SHA-256 over the names and bytes of the prompt files in `folder`, and the number in its version.txt.
// README.md and judged.json are excluded. Fails without a version.txt.
struct PromptFiles {
  std::string version, sha256;
};
Result<PromptFiles> prompt_files(const std::filesystem::path& folder);

// Text of judged.json for prompts `after`, compared with `before`. Fails for synthetic answers.
Result<std::string> judgement_text(const std::filesystem::path& before_folder,
                                   const std::filesystem::path& after_folder, const PromptTrial& before,
                                   const PromptTrial& after, const std::string& name_given);

// Checks that `folder`/judged.json matches the prompts in `folder` and permits them. The error is one line
// with the remedy. Version 3 may be without measurements.
Result<void> check_judgement(const std::filesystem::path& folder);

}  // namespace livegs
