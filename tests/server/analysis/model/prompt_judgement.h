// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"
#include "server/analysis/model/prompt_trial.h"

// prompts/judged.json: which prompts were judged, by whose answers, and with what figures. A prompt that
// changes without being judged anew no longer fits it.

namespace livegs {

// Answers that a test made up are by a model whose name begins so. They show that the judging works; they
// judge nothing.
inline constexpr const char* kMadeUpModel = "made-up";

// SHA-256 over the names and bytes of the prompt files of `folder`, and the number in its version.txt.
// README.md and judged.json do not count. Fails on a folder without a version.txt.
struct PromptFiles {
  std::string version, sha256;
};
Result<PromptFiles> prompt_files(const std::filesystem::path& folder);

// The text of judged.json for prompts `after`, compared with `before`. Fails for answers that were made up.
Result<std::string> judgement_text(const std::filesystem::path& before_folder,
                                   const std::filesystem::path& after_folder, const PromptTrial& before,
                                   const PromptTrial& after, const std::string& name_given);

// Whether `folder`/judged.json speaks of the prompts in `folder` and lets them land. One line with the
// remedy. Version 3, as it stood before any model could be asked, may stand without figures.
Result<void> check_judgement(const std::filesystem::path& folder);

}  // namespace livegs
