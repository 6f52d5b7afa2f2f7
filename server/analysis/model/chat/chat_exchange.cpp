// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/chat/chat_exchange.h"

#include <algorithm>

#include "analysis/text/prompt_text.h"
#include "core/clock.h"
#include "core/log.h"

namespace livegs {
namespace {

constexpr int kMaxToolRounds = 4;
constexpr std::size_t kMaxToolCalls = 8;
constexpr int kReasoningTokenFactor = 4;  // max_completion_tokens includes the hidden reasoning of a model
constexpr int kMaxRefusals = 8;           // request parts that may be disabled in one conversation
constexpr std::size_t kMaxSearchLength = 1500;
constexpr std::int64_t kContexts[] = {2048, 4096, 8192};  // Ollama's defaults; longer prompts are truncated

Error cancelled() { return {ErrorCode::Unavailable, "cancelled"}; }

}  // namespace

ChatConversation::ChatConversation(ChatEndpoint& endpoint, ToolBox tools)
    : endpoint_(endpoint), tools_(std::move(tools)), transcript_(endpoint.settings().api_key) {}

Result<RawAnswer> ChatConversation::ask(const AnalysisQuestion& question, std::stop_token stop) {
  answer_ = {};
  repair_turn_.clear();
  if (auto known = endpoint_.identify_server(stop); !known) {
    return stop.stop_requested() ? cancelled() : known.error();
  }
  slots_ = question.slots;
  images_ = question.images;
  for (AnalysisImage& image : images_) image.caption = endpoint_.prompts().caption(image.caption);
  return converse(stop, endpoint_.settings().tools);
}

Result<RawAnswer> ChatConversation::repair(std::string_view validator_message, std::stop_token stop) {
  if (turns_.empty() || answer_.json.empty()) return invalid_argument("there is no answer to repair yet");
  turns_.push_back({"assistant", answer_.json, {}, {}, ""});
  repair_turn_ = endpoint_.prompts().repair(validator_message);
  turns_.push_back({"user", repair_turn_, {}, {}, ""});
  return converse(stop, false);
}

// One ask or repair: queue slot, tools, answer, totals.
Result<RawAnswer> ChatConversation::converse(std::stop_token stop, bool with_tools) {
  const ModelServer::Slot slot = endpoint_.server().take_slot(endpoint_.max_in_flight(), stop);
  if (!slot) return cancelled();
  const std::int64_t begin_ns = now_ns();
  deadline_ns_ = begin_ns + static_cast<std::int64_t>(endpoint_.deadline_s() * 1e9);
  refusals_ = 0;
  quirks_ = endpoint_.quirks();
  max_tokens_ = endpoint_.settings().max_answer_tokens;
  Result<Json> found = Json();
  if (repair_turn_.empty()) {
    if (endpoint_.settings().web_search && !quirks_.web_search) warn_search_unsupported();
    if (endpoint_.settings().web_search && quirks_.web_search) search(slots_, stop);
    opening_ = endpoint_.prompts().user(slots_);
    begin_turns();
    if (with_tools && quirks_.tools) found = run_tools(stop);
  }
  if (found && found->is_null()) found = run_answer(stop);
  answer_.wall_s += seconds_from_ns(now_ns() - begin_ns);
  answer_.blind = !images_.empty() && !quirks_.images;
  if (answer_.blind) {
    warn(
        "model: does not accept pictures, so only measurements are sent; set LIVEGS_MODEL to one that "
        "accepts pictures");
  }
  answer_.transcript = transcript_.lines();
  if (!found) return found.error();
  answer_.json = transcript_.redact(dump_json(*found));
  answer_.model = transcript_.redact(answer_.model.empty() ? endpoint_.model() : answer_.model);
  answer_.prompt_version = endpoint_.prompts().version();
  return answer_;
}

void ChatConversation::begin_turns() {
  turns_.clear();
  turns_.push_back({"system", endpoint_.prompts().system(quirks_.examples), {}, {}, ""});
  turns_.push_back({"user", opening_, images_, {}, ""});
  opening_turns_ = turns_.size();
}

// The last turn requests the answer, in the wording of the answer form.
void ChatConversation::put_last_turn() {
  const std::string words = endpoint_.prompts().answer_turn(quirks_.form != AnswerForm::JsonSchema);
  if (!repair_turn_.empty()) {
    turns_.back().text = repair_turn_ + (quirks_.form == AnswerForm::JsonSchema ? "" : "\n" + words);
  } else if (turns_.size() == opening_turns_) {
    turns_.back().text = opening_ + "\n" + words;
  } else if (turns_.back().role == "user") {
    turns_.back().text = words;
  } else {
    turns_.push_back({"user", words, {}, {}, ""});
  }
}

ServerAnswer ChatConversation::send(Phase phase, std::stop_token stop) {
  ChatRequest request;
  request.model = endpoint_.model();
  request.max_tokens =
      max_tokens_ * (quirks_.limit_key == LimitKey::MaxCompletionTokens ? kReasoningTokenFactor : 1);
  request.stream = endpoint_.settings().stream;
  if (phase == Phase::Search) request.web_search = true;
  if (phase == Phase::Tools) request.tools = &endpoint_.prompts().tools();
  if (phase == Phase::Answer) request.answer_schema = &endpoint_.prompts().answer_schema();
  const RequestFeatures features = features_of(request, turns_, quirks_);
  transcript_.request(phase == Phase::Search  ? "search"
                      : phase == Phase::Tools ? "tools"
                                              : "answer",
                      chat_request_body(request, turns_, quirks_, true));
  const auto drop_request_part = [&](const ServerError& refusal, bool named_only) {
    if (++refusals_ > kMaxRefusals) return false;
    const bool tool_turns =
        phase == Phase::Answer && repair_turn_.empty() && turns_.size() > opening_turns_ + 1;
    std::string taken;
    if (tool_turns && refusal.message.find("tool") != std::string::npos) {
      // Some servers reject a history of tool calls in a request without tools.
      turns_.resize(opening_turns_);
      taken = "the turns with tools";
    } else {
      taken = learn_from_refusal(quirks_, refusal, features, named_only);
    }
    if (taken.empty()) return false;
    if (features.web_search && !quirks_.web_search) warn_search_unsupported();
    transcript_.note("the server refused; disabled from now on: " + taken);
    return true;
  };
  ServerAnswer answer = endpoint_.server().chat(chat_request_body(request, turns_, quirks_), features.stream,
                                                deadline_ns_, stop, drop_request_part, transcript_);
  if (answer.kind != ServerAnswer::Kind::Answered) return answer;
  const ChatReply& reply = answer.reply;
  const EndpointSettings& settings = endpoint_.settings();
  answer_.prompt_tokens += reply.prompt_tokens;
  answer_.completion_tokens += reply.completion_tokens;
  answer_.cost_usd +=
      reply.cost_usd > 0
          ? reply.cost_usd
          : 1e-6 *
                (settings.usd_per_million_prompt_tokens * static_cast<double>(reply.prompt_tokens) +
                 settings.usd_per_million_completion_tokens * static_cast<double>(reply.completion_tokens));
  if (!reply.model.empty()) answer_.model = brief(reply.model, 100);
  note_truncation(reply);
  endpoint_.keep(quirks_);
  return answer;
}

// A truncated prompt has exactly the context length in tokens, alone or together with its answer.
void ChatConversation::note_truncation(const ChatReply& reply) {
  if (quirks_.dialect != Dialect::Ollama && quirks_.dialect != Dialect::Unknown) return;
  const std::int64_t all = reply.prompt_tokens + reply.completion_tokens;
  const auto context = std::find_if(std::begin(kContexts), std::end(kContexts), [&](std::int64_t size) {
    return size == all || size == reply.prompt_tokens;
  });
  if (context == std::end(kContexts)) return;
  const std::string warning =
      "prompt: truncated to the server's context of " + std::to_string(*context) +
      " tokens; start the server with a longer one (Ollama: OLLAMA_CONTEXT_LENGTH=16384)";
  warn(warning);
  quirks_.examples = 0;  // the examples are dispensable, from the next object on
}

void ChatConversation::warn_search_unsupported() {
  warn("--web-search: not supported by the server for this model; answers are given without it");
}

// Adds a warning to the answer and logs it the first time.
void ChatConversation::warn(const std::string& warning) {
  if (std::find(answer_.warnings.begin(), answer_.warnings.end(), warning) != answer_.warnings.end()) return;
  answer_.warnings.push_back(warning);
  transcript_.note(warning);
  endpoint_.warn_once(warning);
}

void ChatConversation::search(std::map<std::string, std::string>& slots, std::stop_token stop) {
  turns_ = {{"user", endpoint_.prompts().search(slots), {}, {}, ""}};
  const ServerAnswer found = send(Phase::Search, stop);
  if (found.kind == ServerAnswer::Kind::Answered)
    slots["search"] = quoted_text(found.reply.content, kMaxSearchLength);
  if (found.kind == ServerAnswer::Kind::Refused) endpoint_.keep(quirks_);
  if (found.kind == ServerAnswer::Kind::Failed)
    warn("--web-search: " + transcript_.redact(found.error.message));
}

Result<Json> ChatConversation::run_tools(std::stop_token stop) {
  std::size_t calls_left = kMaxToolCalls;
  turns_.back().text = opening_ + "\n" + endpoint_.prompts().tools_turn();
  for (int round = 0; round < kMaxToolRounds && calls_left > 0;) {
    ServerAnswer said = send(Phase::Tools, stop);
    if (said.kind == ServerAnswer::Kind::Refused) {
      if (quirks_.tools) continue;
      begin_turns();
      return Json();
    }
    if (said.kind != ServerAnswer::Kind::Answered) return said.error;
    ++round;
    ChatReply& reply = said.reply;
    if (reply.tool_calls.empty()) {
      // A reply with all needed fields is an answer; the gate judges it as one of the second phase.
      const std::vector<std::string>& needed = endpoint_.prompts().needed_fields();
      const auto early = find_json_object(reply.content, endpoint_.prompts().answer_fields());
      if (early && reply.finish_reason != "length" &&
          std::all_of(needed.begin(), needed.end(),
                      [&](const std::string& one) { return early->contains(one); })) {
        return *early;
      }
      if (!reply.content.empty()) turns_.push_back({"assistant", brief(reply.content, 2000), {}, {}, ""});
      return Json();
    }
    if (reply.tool_calls.size() > calls_left) reply.tool_calls.resize(calls_left);
    calls_left -= reply.tool_calls.size();
    turns_.push_back({"assistant", reply.content, {}, reply.tool_calls, ""});
    for (const ToolCall& call : reply.tool_calls) {
      const std::string result = tools_.call(call.name, call.arguments);
      transcript_.tool(call.name, call.arguments, result);
      turns_.push_back({"tool", result, {}, {}, call.id});
    }
  }
  return Json();
}

Result<Json> ChatConversation::run_answer(std::stop_token stop) {
  for (bool lengthened = false;;) {
    put_last_turn();
    const ServerAnswer said = send(Phase::Answer, stop);
    if (said.kind == ServerAnswer::Kind::Refused) continue;
    if (said.kind != ServerAnswer::Kind::Answered) return said.error;
    const ChatReply& reply = said.reply;
    if (!reply.refusal.empty()) {
      return unsupported("model: declined to answer: " + transcript_.redact(brief(reply.refusal)) +
                         "; set another LIVEGS_MODEL");
    }
    if (reply.finish_reason == "content_filter") {
      return unsupported("answer: stopped by the server's content filter; try other views");
    }
    if (reply.finish_reason == "length") {
      if (lengthened) {
        return Error{ErrorCode::TooLarge, "answer: did not end within " + std::to_string(max_tokens_) +
                                              " tokens; use a model with shorter answers"};
      }
      lengthened = true;
      max_tokens_ *= 2;
      continue;
    }
    if (auto object = find_json_object(reply.content, endpoint_.prompts().answer_fields()))
      return std::move(*object);
    if (quirks_.form == AnswerForm::Text) {
      return invalid_data("answer: contains no JSON object: " +
                          transcript_.redact(brief(reply.content, 120)) + "; set another LIVEGS_MODEL");
    }
    // The requested form was ignored: the server skips unknown parameters.
    quirks_.form = quirks_.form == AnswerForm::JsonSchema ? AnswerForm::JsonObject : AnswerForm::Text;
    transcript_.note("no JSON object received; the form is requested in words from now on");
  }
}

}  // namespace livegs
