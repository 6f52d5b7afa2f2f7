// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/chat/endpoint_quirks.h"

#include <algorithm>
#include <array>
#include <ctime>

#include "core/file.h"
#include "core/log.h"
#include "core/text/lower_case.h"

namespace livegs {
namespace {

constexpr std::int64_t kQuirkLifetime_s = 30 * 24 * 3600;
constexpr int kExamplesOfShortContext = 2;  // fits 4096 tokens together with two pictures
constexpr std::size_t kMaxEntries = 200;
constexpr std::uint64_t kMaxFileBytesOfQuirks = 1 << 20;

constexpr std::array kDialectNames = {"unknown", "openai", "vllm", "llama.cpp", "ollama", "plain"};
constexpr std::array kFormNames = {"json_schema", "json_object", "text"};
constexpr std::array kLimitNames = {"max_completion_tokens", "max_tokens", "none"};

template <class Enum, std::size_t Count>
Enum read_name(const Json& object, const char* key, const std::array<const char*, Count>& names,
               Enum fallback) {
  const std::string text = text_member(object, key);
  for (std::size_t i = 0; i < Count; ++i) {
    if (text == names[i]) return static_cast<Enum>(i);
  }
  return fallback;
}

// Names of the switches in the file. `images` is excluded: a server may gain vision (a projector is loaded,
// another model takes the name), and a month without pictures costs more than one refusal per run.
constexpr std::pair<const char*, bool EndpointQuirks::*> kSwitches[] = {
    {"limit_key_swapped", &EndpointQuirks::limit_key_swapped},
    {"tools", &EndpointQuirks::tools},
    {"tool_choice", &EndpointQuirks::tool_choice},
    {"strict_tools", &EndpointQuirks::strict_tools},
    {"temperature", &EndpointQuirks::temperature},
    {"seed", &EndpointQuirks::seed},
    {"stream", &EndpointQuirks::stream},
    {"stream_options", &EndpointQuirks::stream_options},
    {"web_search", &EndpointQuirks::web_search}};

bool mentions(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return text.find(word) != std::string::npos; });
}

std::string take(bool& feature, const char* what) {
  feature = false;
  return what;
}

std::string swap_limit_key(EndpointQuirks& quirks) {
  const bool was_completion = quirks.limit_key == LimitKey::MaxCompletionTokens;
  quirks.limit_key = quirks.limit_key_swapped ? LimitKey::None
                     : was_completion         ? LimitKey::MaxTokens
                                              : LimitKey::MaxCompletionTokens;
  quirks.limit_key_swapped = true;
  return was_completion ? "max_completion_tokens" : "max_tokens";
}

std::string step_down(EndpointQuirks& quirks) {
  const char* was = kFormNames[static_cast<std::size_t>(quirks.form)];
  quirks.form = quirks.form == AnswerForm::JsonSchema ? AnswerForm::JsonObject : AnswerForm::Text;
  return std::string("response_format ") + was;
}

// Disables the feature named in `words`, the most specific first.
std::string take_named(EndpointQuirks& quirks, const std::string& words, const RequestFeatures& sent) {
  if (mentions(words, {"max_completion_tokens", "max_tokens"}) && quirks.limit_key != LimitKey::None) {
    return swap_limit_key(quirks);
  }
  if (mentions(words, {"temperature"}) && quirks.temperature) return take(quirks.temperature, "temperature");
  if (mentions(words, {"seed"}) && quirks.seed) return take(quirks.seed, "seed");
  if (mentions(words, {"stream_options"}) && sent.stream && quirks.stream_options) {
    return take(quirks.stream_options, "stream_options");
  }
  if (mentions(words, {"web_search"}) && sent.web_search) return take(quirks.web_search, "web search");
  if (mentions(words, {"tool_choice", "tool choice"}) && sent.tools && quirks.tool_choice &&
      !mentions(words, {"enable-auto-tool-choice"})) {
    return take(quirks.tool_choice, "tool_choice");
  }
  if (mentions(words, {"strict"}) && sent.tools && quirks.strict_tools)
    return take(quirks.strict_tools, "strict");
  if (mentions(words, {"tool", "function call", "functions", "jinja"}) && sent.tools) {
    return take(quirks.tools, "tools");
  }
  if (mentions(words, {"response_format", "json_schema", "json_object", "schema", "grammar", "guided",
                       "structured"}) &&
      sent.form != AnswerForm::Text) {
    return step_down(quirks);
  }
  if (mentions(words, {"image", "vision", "multimodal", "multi-modal", "mmproj", "content part"}) &&
      sent.images) {
    return take(quirks.images, "images");
  }
  if (mentions(words, {"stream"}) && sent.stream) return take(quirks.stream, "stream");
  return "";
}

Json to_json(const EndpointQuirks& quirks) {
  Json object = {{"dialect", kDialectNames[static_cast<std::size_t>(quirks.dialect)]},
                 {"form", kFormNames[static_cast<std::size_t>(quirks.form)]},
                 {"limit_key", kLimitNames[static_cast<std::size_t>(quirks.limit_key)]},
                 {"examples", quirks.examples}};
  for (const auto& [name, field] : kSwitches) object[name] = quirks.*field;
  return object;
}

EndpointQuirks from_json(const Json& object) {
  EndpointQuirks quirks;
  quirks.dialect = read_name(object, "dialect", kDialectNames, quirks.dialect);
  quirks.form = read_name(object, "form", kFormNames, quirks.form);
  quirks.limit_key = read_name(object, "limit_key", kLimitNames, quirks.limit_key);
  quirks.examples = static_cast<int>(std::clamp(number_member(object, "examples").value_or(6), 0.0, 100.0));
  for (const auto& [name, field] : kSwitches) {
    if (const Json* value = member(object, name); value && value->is_boolean())
      quirks.*field = value->get<bool>();
  }
  return quirks;
}

}  // namespace

const char* dialect_name(Dialect dialect) { return kDialectNames[static_cast<std::size_t>(dialect)]; }

EndpointQuirks profile_of(Dialect dialect) {
  EndpointQuirks quirks;
  quirks.dialect = dialect;
  if (dialect == Dialect::OpenAi) quirks.limit_key = LimitKey::MaxCompletionTokens;
  if (dialect == Dialect::Ollama) {
    quirks.tool_choice = false;
    quirks.examples = kExamplesOfShortContext;
  }
  if (dialect == Dialect::Plain) {
    quirks.tools = quirks.seed = quirks.web_search = false;
    quirks.form = AnswerForm::Text;
  }
  if (dialect != Dialect::OpenAi && dialect != Dialect::Unknown) quirks.web_search = false;
  return quirks;
}

Dialect dialect_of_url(std::string_view base_url) {
  if (base_url.starts_with("https://api.openai.com/")) return Dialect::OpenAi;
  const std::size_t host = base_url.find("://");
  const std::string_view authority = base_url.substr(host == std::string_view::npos ? 0 : host + 3);
  if (authority.substr(0, authority.find('/')).ends_with(":11434")) return Dialect::Ollama;
  return Dialect::Unknown;
}

Dialect dialect_of_models(std::string_view body, std::string& first_model) {
  const Result<Json> list = parse_json(body);
  const Json* data = list ? member(*list, "data") : nullptr;
  if (!data || !data->is_array() || data->empty()) return Dialect::Unknown;
  first_model = text_member(data->front(), "id");
  const std::string owner = lower_case(text_member(data->front(), "owned_by"));
  if (owner == "vllm") return Dialect::Vllm;
  if (owner == "llamacpp") return Dialect::LlamaCpp;
  if (owner == "library") return Dialect::Ollama;
  return Dialect::Unknown;
}

bool is_context_overflow(const ServerError& error) {
  return mentions(lower_case(error.code + " " + error.type + " " + error.message),
                  {"context_length_exceeded", "context length", "exceed_context_size", "context size",
                   "context window", "prompt is too long"});
}

std::string learn_from_refusal(EndpointQuirks& quirks, const ServerError& error, const RequestFeatures& sent,
                               bool named_only) {
  if (is_context_overflow(error)) return "";
  if (!error.param.empty()) {
    std::string taken = take_named(quirks, lower_case(error.param), sent);
    if (!taken.empty()) return taken;
  }
  std::string taken = take_named(quirks, lower_case(error.code + " " + error.message), sent);
  if (!taken.empty() || named_only) return taken;
  // A refusal without details: the least supported features are disabled first.
  if (sent.tools) return take(quirks.tools, "tools");
  if (sent.form != AnswerForm::Text) return step_down(quirks);
  if (sent.stream) return take(quirks.stream, "stream");
  if (quirks.seed) return take(quirks.seed, "seed");
  if (quirks.temperature) return take(quirks.temperature, "temperature");
  if (sent.images) return take(quirks.images, "images");
  return "";
}

QuirkMemory::QuirkMemory(std::filesystem::path file) : file_(std::move(file)) {
  if (file_.empty() || !std::filesystem::exists(file_)) return;
  const Result<std::string> text = read_text_file(file_, kMaxFileBytesOfQuirks);
  const Result<Json> parsed = text ? parse_json(*text) : Result<Json>(text.error());
  const Json* list = parsed ? member(*parsed, "endpoints") : nullptr;
  if (!list || !list->is_object()) {
    log_warn("%s: not a list of server capabilities; they are learned again", file_.c_str());
    return;
  }
  const std::int64_t now = std::time(nullptr);
  for (const auto& [key, value] : list->items()) {
    const auto learned = static_cast<std::int64_t>(number_member(value, "learned_unix_s").value_or(0));
    if (now - learned > kQuirkLifetime_s || learned > now + kQuirkLifetime_s ||
        entries_.size() >= kMaxEntries)
      continue;
    entries_[key] = {from_json(value), learned};
  }
}

bool QuirkMemory::recall(const std::string& key, EndpointQuirks& quirks) const {
  std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end()) return false;
  quirks = found->second.quirks;
  return true;
}

void QuirkMemory::keep(const std::string& key, const EndpointQuirks& quirks) {
  std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  if (found != entries_.end() && found->second.quirks == quirks) return;
  entries_[key] = {quirks, std::time(nullptr)};
  if (!file_.empty()) save();
}

void QuirkMemory::save() const {
  Json list = Json::object();
  for (const auto& [key, entry] : entries_) {
    list[key] = to_json(entry.quirks);
    list[key]["learned_unix_s"] = entry.learned_unix_s;
  }
  std::error_code ignored;
  std::filesystem::create_directories(file_.parent_path(), ignored);
  const Json file = {{"endpoints", list}};
  if (auto written =
          write_file_atomically(file_, file.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
      !written) {
    log_warn("model server: capabilities not saved: %s", written.error().message.c_str());
  }
}

}  // namespace livegs
