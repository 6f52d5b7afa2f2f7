// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/chat/chat_endpoint.h"

#include <cstdlib>

#include "analysis/model/chat/chat_exchange.h"
#include "core/log.h"

namespace livegs {
namespace {

constexpr double kRemoteDeadline_s = 60, kLocalDeadline_s = 300;
constexpr int kRemoteInFlight = 4, kLocalInFlight = 1;
constexpr std::size_t kMaxUrlLength = 2000, kMaxKeyLength = 4096;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && static_cast<unsigned char>(text.back()) <= ' ') text.remove_suffix(1);
  while (!text.empty() && static_cast<unsigned char>(text.front()) <= ' ') text.remove_prefix(1);
  return text;
}

bool has_control(std::string_view text) {
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x21 || c == 0x7f) return true;
  }
  return false;
}

// Messages never contain the whole address: a user may have put the key into it.
Result<void> check_url(const std::string& url) {
  if (!url.starts_with("http://") && !url.starts_with("https://")) {
    return invalid_argument("OPENAI_BASE_URL: must begin with http:// or https://");
  }
  if (has_control(url) || url.size() > kMaxUrlLength)
    return invalid_argument("OPENAI_BASE_URL: is not an address; give one such as http://localhost:8080/v1");
  const std::size_t host = url.find("://") + 3;
  const std::string authority = url.substr(host, url.find_first_of("/?#", host) - host);
  if (authority.find('@') != std::string::npos) {
    return invalid_argument(
        "OPENAI_BASE_URL: must not contain a user or password; put the key in OPENAI_API_KEY");
  }
  if (authority.empty())
    return invalid_argument("OPENAI_BASE_URL: has no host; give one such as http://localhost:8080/v1");
  if (url.find_first_of("?#") != std::string::npos) {
    return invalid_argument("OPENAI_BASE_URL: must not contain ? or #");
  }
  return {};
}

}  // namespace

std::optional<EndpointSettings> endpoint_settings_from_environment() {
  EndpointSettings settings;
  settings.base_url = trimmed(environment("OPENAI_BASE_URL"));
  settings.model = trimmed(environment("LIVEGS_MODEL"));
  if (settings.base_url.empty() && settings.model.empty()) return std::nullopt;
  if (settings.base_url.empty()) settings.base_url = kOpenAiUrl;
  if (const char* key = std::getenv("OPENAI_API_KEY")) settings.api_key = Secret(trimmed(key));
  std::filesystem::path cache = environment("XDG_CACHE_HOME");
  if (cache.empty() && !environment("HOME").empty())
    cache = std::filesystem::path(environment("HOME")) / ".cache";
  if (!cache.empty()) settings.quirks_file = cache / "livegs" / "endpoint_quirks.json";
  return settings;
}

Result<std::unique_ptr<ModelEndpoint>> open_model_endpoint(EndpointSettings settings) {
  if (auto checked = check_url(settings.base_url); !checked) return checked.error();
  while (settings.base_url.ends_with('/')) settings.base_url.pop_back();
  // All servers of this interface have it under /v1; an address without a path has lost it.
  if (settings.base_url.find('/', settings.base_url.find("://") + 3) == std::string::npos) {
    settings.base_url += "/v1";
    log_info("model server: the address has no path; %s is used", settings.base_url.c_str());
  }
  if (has_control(settings.api_key.reveal()) || settings.api_key.reveal().size() > kMaxKeyLength) {
    return invalid_argument(
        "OPENAI_API_KEY: has a space or control character, or is too long; copy the key again");
  }
  if (has_control(settings.model))
    return invalid_argument("LIVEGS_MODEL: contains a space or a control character; copy the name again");
  if (settings.base_url == kOpenAiUrl) {
    if (settings.api_key.empty())
      return invalid_argument("OPENAI_API_KEY: is not set, but api.openai.com needs one; set it");
    if (settings.model.empty())
      return invalid_argument("LIVEGS_MODEL: not set; name a model that accepts pictures");
  }
  if (!settings.api_key.empty() && settings.base_url.starts_with("http://") &&
      !is_loopback_url(settings.base_url)) {
    log_warn("%s: the key is sent unencrypted; use https", settings.base_url.c_str());
  }
  Result<PromptSet> prompts = PromptSet::load(settings.prompt_folder);
  if (!prompts) return prompts.error();
  return std::unique_ptr<ModelEndpoint>(
      std::make_unique<ChatEndpoint>(std::move(settings), std::move(*prompts)));
}

ChatEndpoint::ChatEndpoint(EndpointSettings settings, PromptSet prompts)
    : settings_(std::move(settings)),
      prompts_(std::move(prompts)),
      memory_(settings_.quirks_file),
      model_(settings_.model),
      quirks_(profile_of(dialect_of_url(settings_.base_url))),
      server_(settings_) {
  if (!model_.empty() && memory_.recall(memory_key(), quirks_)) known_ = true;
  if (!model_.empty() && quirks_.dialect != Dialect::Unknown) known_ = true;
}

std::unique_ptr<Conversation> ChatEndpoint::start(ToolBox tools) {
  return std::make_unique<ChatConversation>(*this, std::move(tools));
}

Result<void> ChatEndpoint::identify_server(std::stop_token stop) {
  std::lock_guard one(probing_);
  {
    std::lock_guard lock(mutex_);
    if (known_) return {};
  }
  int status = 0;
  const std::string list = server_.probe(stop, status);
  std::string first_model;
  const Dialect dialect = dialect_of_models(list, first_model);
  std::lock_guard lock(mutex_);
  if (model_.empty()) model_ = first_model.size() < 300 && !has_control(first_model) ? first_model : "";
  if (model_.empty()) {
    if (status == 401 || status == 403) {
      return Error{ErrorCode::PermissionDenied, "OPENAI_API_KEY: refused by the server; check the key"};
    }
    return Error{
        ErrorCode::Unavailable,
        settings_.base_url + (status == 0 ? ": no reply; start the server, or correct OPENAI_BASE_URL"
                                          : ": no model is listed; set LIVEGS_MODEL")};
  }
  if (!memory_.recall(memory_key(), quirks_) && dialect != Dialect::Unknown) quirks_ = profile_of(dialect);
  known_ = true;
  log_info("model server: %s, model %s, dialect %s", settings_.base_url.c_str(), model_.c_str(),
           dialect_name(quirks_.dialect));
  return {};
}

EndpointState ChatEndpoint::state() const {
  EndpointState state;
  state.name = settings_.base_url + (settings_.web_search ? " with web search" : "");
  state.prompt_version = prompts_.version();
  state.model = model();
  state.breaker_open = server_.breaker_open(state.breaker_reason);
  state.in_flight = server_.in_flight();
  state.max_in_flight = max_in_flight();
  return state;
}

std::string ChatEndpoint::model() const {
  std::lock_guard lock(mutex_);
  return model_;
}

EndpointQuirks ChatEndpoint::quirks() const {
  std::lock_guard lock(mutex_);
  return quirks_;
}

void ChatEndpoint::keep(const EndpointQuirks& quirks) {
  std::lock_guard lock(mutex_);
  if (quirks == quirks_) return;
  quirks_ = quirks;
  memory_.keep(memory_key(), quirks);
}

bool ChatEndpoint::decodes_one_at_a_time() const {
  const Dialect dialect = quirks().dialect;
  return dialect == Dialect::Ollama || dialect == Dialect::LlamaCpp;
}

int ChatEndpoint::max_in_flight() const {
  if (settings_.max_in_flight > 0) return settings_.max_in_flight;
  return decodes_one_at_a_time() ? kLocalInFlight : kRemoteInFlight;
}

double ChatEndpoint::deadline_s() const {
  if (settings_.deadline_s > 0) return settings_.deadline_s;
  return decodes_one_at_a_time() ? kLocalDeadline_s : kRemoteDeadline_s;
}

void ChatEndpoint::warn_once(const std::string& warning) {
  std::lock_guard lock(mutex_);
  if (!warned_.insert(warning).second) return;
  log_warn("%s: %s", settings_.base_url.c_str(), warning.c_str());
}

}  // namespace livegs
