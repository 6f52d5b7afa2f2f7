// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/endpoint_choice.h"

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string_view>

#include "analysis/model/model_endpoint.h"
#include "analysis/model/prompt_set.h"
#include "core/log.h"

namespace livegs {
namespace {

constexpr double kMaxDeadline_s = 3600;

Result<void> read_price(const std::string& text, EndpointSettings& settings) {
  std::istringstream cells(text);
  double in = 0, out = 0;
  char comma = 0;
  if (!(cells >> in >> comma >> out) || comma != ',' || !(cells >> std::ws).eof() || !(in >= 0 && in < 1e6) ||
      !(out >= 0 && out < 1e6)) {
    return invalid_argument(
        "LIVEGS_PRICE: must be two numbers, US dollars per million tokens sent and received, as in "
        "0.15,0.60");
  }
  settings.usd_per_million_prompt_tokens = in;
  settings.usd_per_million_completion_tokens = out;
  return {};
}

// Seconds; 0 if unset.
Result<double> read_deadline(double option_s) {
  const char* text = std::getenv("LIVEGS_MODEL_DEADLINE_S");
  const char* name = option_s != 0 ? "--model-deadline" : "LIVEGS_MODEL_DEADLINE_S";
  if (option_s == 0 && (!text || !*text)) return 0.0;
  char* end = nullptr;
  const double seconds = option_s != 0 ? option_s : std::strtod(text, &end);
  if ((end && *end != '\0') || !(seconds >= 1 && seconds <= kMaxDeadline_s)) {
    return invalid_argument(std::string(name) + ": must be 1 to 3600 seconds");
  }
  return seconds;
}

std::string_view without_slashes(std::string_view url) {
  while (url.ends_with('/')) url.remove_suffix(1);
  return url;
}

// The key belongs to one address: that of OPENAI_BASE_URL, or OpenAI's if unset, as in other programs.
void take_url(const std::string& url, EndpointSettings& settings) {
  const char* key = std::getenv("OPENAI_API_KEY");
  const std::string home = settings.base_url.empty() ? kOpenAiUrl : settings.base_url;
  settings.base_url = url;
  if (without_slashes(url) == without_slashes(home)) {
    if (key && settings.api_key.empty()) settings.api_key = Secret(key);
    return;
  }
  settings.api_key = {};
  if (!key || !*key) return;
  log_warn("--endpoint: OPENAI_API_KEY belongs to %s and is not sent; set OPENAI_BASE_URL to send it",
           home == kOpenAiUrl ? "api.openai.com" : "the address in OPENAI_BASE_URL");
}

// Validates a given prompt folder even if the language model is disabled.
Result<std::unique_ptr<ModelEndpoint>> unused_prompts(const EndpointChoice& choice,
                                                      std::unique_ptr<ModelEndpoint> none) {
  if (choice.prompts.empty()) return none;
  const auto prompts = PromptSet::load(choice.prompts);
  if (!prompts) return prompts.error();
  log_warn("--prompts: %s: valid, but no language model is in use; %s", choice.prompts.c_str(),
           choice.offline ? "leave out --offline" : "give --endpoint or set OPENAI_BASE_URL");
  return none;
}

}  // namespace

std::filesystem::path cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache && *cache) return std::filesystem::path(cache) / "livegs";
  const char* home = std::getenv("HOME");
  return home && *home ? std::filesystem::path(home) / ".cache" / "livegs" : std::filesystem::path();
}

Result<std::unique_ptr<ModelEndpoint>> choose_endpoint(const EndpointChoice& choice) {
  const bool endpoint_given = !choice.url.empty() || !choice.model.empty() || !choice.record.empty();
  if (choice.offline && (endpoint_given || !choice.recorded.empty())) {
    return invalid_argument(
        "--offline: disables the language model; leave it out, or leave out --endpoint, --model, "
        "--record-answers and --recorded");
  }
  if (!choice.recorded.empty() && endpoint_given) {
    return invalid_argument(
        "--recorded: replays a folder; leave out --endpoint, --model and --record-answers");
  }
  std::unique_ptr<ModelEndpoint> none;
  if (choice.offline) return unused_prompts(choice, std::move(none));
  if (!choice.recorded.empty()) return open_recorded_endpoint(choice.recorded, nullptr, choice.prompts);
  auto settings = endpoint_settings_from_environment();
  if (!settings && !endpoint_given) return unused_prompts(choice, std::move(none));
  if (!settings) settings.emplace();
  if (!choice.url.empty()) take_url(choice.url, *settings);
  if (!choice.model.empty()) settings->model = choice.model;
  if (settings->base_url.empty()) {
    return invalid_argument(
        "--record-answers, --model: no endpoint is set; give --endpoint URL or set OPENAI_BASE_URL");
  }
  settings->prompt_folder = choice.prompts;
  settings->web_search = choice.web_search;
  const auto deadline_s = read_deadline(choice.deadline_s);
  if (!deadline_s) return deadline_s.error();
  settings->deadline_s = *deadline_s;
  const char* environment_price = std::getenv("LIVEGS_PRICE");
  const std::string price = !choice.price.empty() ? choice.price : environment_price ? environment_price : "";
  if (!price.empty()) {
    if (auto read = read_price(price, *settings); !read) return read.error();
  }
  if (const auto folder = cache_folder(); !folder.empty())
    settings->quirks_file = folder / "endpoint_quirks.json";
  auto live = open_model_endpoint(std::move(*settings));
  if (!live || choice.record.empty()) return live;
  return open_recorded_endpoint(choice.record, std::move(*live), choice.prompts);
}

}  // namespace livegs
