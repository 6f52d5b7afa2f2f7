// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "analysis/model/conversation.h"
#include "core/result.h"

namespace livegs {

// What a person said about which model to ask; what is left empty comes from the environment
// (OPENAI_BASE_URL, LIVEGS_MODEL, OPENAI_API_KEY).
struct EndpointChoice {
  bool offline = false;  // ask nobody
  std::string url, model;
  std::filesystem::path recorded;  // answers of this folder and no others
  std::filesystem::path record;    // ask, and keep the answers here
  std::filesystem::path prompts;   // a folder whose files take the place of the prompts of the same names
  std::string price;  // "0.15,0.60": US dollars a million tokens, in and out; empty: LIVEGS_PRICE
  double deadline_s =
      0;  // of one question with all its repeats; 0: LIVEGS_MODEL_DEADLINE_S, else the endpoint's own
  bool web_search = false;  // one search an object before the answer, where the server has one
};

// nullptr when nobody is to be asked. Touches no network. Errors are the user's words.
Result<std::unique_ptr<ModelEndpoint>> choose_endpoint(const EndpointChoice& choice);

// Where this user's caches go: $XDG_CACHE_HOME/livegs or ~/.cache/livegs; empty when neither is set.
std::filesystem::path cache_folder();

}  // namespace livegs
