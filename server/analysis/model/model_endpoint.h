// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "analysis/model/conversation.h"
#include "core/result.h"
#include "store/secret.h"

// Endpoints of the language model: a server with OpenAI's chat completions API (OpenAI, vLLM, llama.cpp,
// Ollama, or one with plain text only), or a folder of recorded answers.

namespace livegs {

inline constexpr const char* kOpenAiUrl = "https://api.openai.com/v1";

struct EndpointSettings {
  // "https://api.openai.com/v1"; http or https; from this program's own configuration only.
  std::string base_url;
  std::string model;                    // empty: the first one listed by the server
  Secret api_key;                       // sent to base_url only
  std::filesystem::path prompt_folder;  // overrides the built-in prompts file by file; empty: none
  // Learned server capabilities, kept between runs; empty: kept in memory only.
  std::filesystem::path quirks_file;

  bool tools = true;    // offers tools before the answer; the prompt already contains their results
  bool stream = false;  // server-sent events, which detect a late first byte early
  // One web search before the answer, if the server supports it; its text is quoted data.
  bool web_search = false;
  int max_in_flight = 0;  // 0: 1 for Ollama and llama.cpp, which decode one request at a time, else 4
  double requests_per_s = 4, request_burst = 8;  // of the token bucket

  // Limit of one ask or repair with all its retries; 0: 300 for Ollama and llama.cpp, else 60.
  double deadline_s = 0;
  double connect_timeout_s = 5;
  double probe_timeout_s = 0.5;     // of the request for the list of models
  double first_byte_timeout_s = 0;  // 0: none; only while streaming
  double stall_timeout_s = 0;       // time without a byte; 0: none; only while streaming
  int max_retries = 3;
  double backoff_s = 0.5, max_backoff_s = 8;  // exponential, full jitter
  std::uint64_t jitter_seed = 0;              // 0: from the clock
  int breaker_failures = 5;                   // consecutive failures that open the breaker
  double breaker_s = 30;                      // until one request is allowed again
  double quota_breaker_s = 600;               // the same after exhausted credit or a refused key

  std::int64_t max_answer_tokens = 1200;
  double usd_per_million_prompt_tokens = 0, usd_per_million_completion_tokens = 0;  // 0: unknown
  std::function<void(std::size_t)> progress;  // bytes received so far, while streaming; network thread
};

// Settings from OPENAI_BASE_URL (default kOpenAiUrl), LIVEGS_MODEL and OPENAI_API_KEY. nullopt unless one of
// the first two is set. A key alone does not enable the endpoint, because other programs use the same
// variable.
std::optional<EndpointSettings> endpoint_settings_from_environment();

// Fails on invalid settings (no address, not http, an incomplete prompt folder). Does not access the network.
Result<std::unique_ptr<ModelEndpoint>> open_model_endpoint(EndpointSettings settings);

// Replays answers in `folder` bit for bit, keyed by the SHA-256 over prompt version, schema, model, slots and
// images. A missing answer is requested from `live` and recorded; without `live` it is an error that names
// the missing answer. `prompt_folder` as in EndpointSettings, for replays.
Result<std::unique_ptr<ModelEndpoint>> open_recorded_endpoint(
    const std::filesystem::path& folder, std::unique_ptr<ModelEndpoint> live,
    const std::filesystem::path& prompt_folder = {});

}  // namespace livegs
