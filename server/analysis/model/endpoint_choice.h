// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "analysis/model/conversation.h"
#include "core/result.h"

namespace livegs {

// User options that select the model. Empty ones are read from the environment (OPENAI_BASE_URL,
// LIVEGS_MODEL, OPENAI_API_KEY).
struct EndpointChoice {
  bool offline = false;  // disables the language model
  std::string url, model;
  std::filesystem::path recorded;  // answers from this folder only
  std::filesystem::path record;    // sends questions and records the answers here
  std::filesystem::path prompts;   // folder with replacements of prompt files of the same names
  std::string price;  // "0.15,0.60": US dollars per million tokens, sent and received; empty: LIVEGS_PRICE
  // Limit of one question with all its retries; 0: LIVEGS_MODEL_DEADLINE_S, else the endpoint's default.
  double deadline_s = 0;
  bool web_search = false;  // one web search per object before the answer, if the server supports it
};

// Creates the selected endpoint, or nullptr if the language model is disabled. Does not access the network.
// Errors are written for users.
Result<std::unique_ptr<ModelEndpoint>> choose_endpoint(const EndpointChoice& choice);

// Cache folder of this user: $XDG_CACHE_HOME/livegs or ~/.cache/livegs; empty if neither is set.
std::filesystem::path cache_folder();

}  // namespace livegs
