// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "analysis/model/conversation.h"
#include "analysis/model/secret.h"
#include "core/result.h"

// Where the answers come from: a server that speaks OpenAI's chat completions (OpenAI, vLLM, llama.cpp,
// Ollama, or one that knows plain text only), or a folder of recorded answers.

namespace livegs {

inline constexpr const char* kOpenAiUrl = "https://api.openai.com/v1";

struct EndpointSettings {
  std::string
      base_url;       // "https://api.openai.com/v1"; http or https, from the server's own configuration only
  std::string model;  // empty: the first one that the server lists
  Secret api_key;     // sent to base_url and to nothing else
  std::filesystem::path
      prompt_folder;  // overrides the prompts that are compiled in, file by file; empty: none
  std::filesystem::path
      quirks_file;  // what was learned of servers, between runs; empty: forgotten at the end

  bool tools = true;        // offer tools before the answer; their results are in the prompt anyway
  bool stream = false;      // server-sent events: a late first byte is noticed early
  bool web_search = false;  // one search before the answer, where the server has one; its text is quoted data
  int max_in_flight = 0;    // 0: 1 for Ollama and llama.cpp, which decode one at a time, else 4
  double requests_per_s = 4, request_burst = 8;  // the token bucket

  double deadline_s =
      0;  // of one ask or repair with all its retries; 0: 300 for Ollama and llama.cpp, else 60
  double connect_timeout_s = 5;
  double probe_timeout_s = 0.5;     // of the one look at the list of models
  double first_byte_timeout_s = 0;  // 0: none; only while streaming
  double stall_timeout_s = 0;       // no byte for so long; 0: none; only while streaming
  int max_retries = 3;
  double backoff_s = 0.5, max_backoff_s = 8;  // exponential, full jitter
  std::uint64_t jitter_seed = 0;              // 0: from the clock
  int breaker_failures = 5;                   // in a row open the breaker
  double breaker_s = 30;                      // until one request is let through again
  double quota_breaker_s = 600;               // the same after "no money left" or a refused key

  std::int64_t max_answer_tokens = 1200;
  double usd_per_million_prompt_tokens = 0, usd_per_million_completion_tokens = 0;  // 0: unknown
  std::function<void(std::size_t)> progress;  // bytes received so far, while streaming; network thread
};

// OPENAI_BASE_URL (left out: kOpenAiUrl), LIVEGS_MODEL, OPENAI_API_KEY. Nothing is set, and nothing is ever
// sent anywhere, unless one of the first two is: a key alone, which many people have for other programs, does
// not count.
std::optional<EndpointSettings> endpoint_settings_from_environment();

// Fails on settings that cannot work (no address, not http, a folder of prompts that is incomplete); does not
// touch the network.
Result<std::unique_ptr<ModelEndpoint>> open_model_endpoint(EndpointSettings settings);

// Answers kept in `folder` are given back bit for bit, found by the SHA-256 over prompt version, schema,
// model, slots and images. What is not there is asked of `live` and kept; without one it is an error that
// says what is missing. `prompt_folder` as in EndpointSettings, for replays.
Result<std::unique_ptr<ModelEndpoint>> open_recorded_endpoint(
    const std::filesystem::path& folder, std::unique_ptr<ModelEndpoint> live,
    const std::filesystem::path& prompt_folder = {});

}  // namespace livegs
