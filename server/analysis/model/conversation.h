// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/model/tool_box.h"
#include "core/result.h"

// Interface of a language model for the rest of the analysis. A conversation is about one object: the
// question consists of slots and pictures, the answer is JSON. Servers, recordings and test doubles implement
// these two classes.
//
// Answers are untrusted. They are checked here only to be one JSON object; the acceptance gate validates
// them.

namespace livegs {

struct AnalysisImage {
  std::string caption;     // its content, by name in prompts/captions.json: "outlined"
  std::string media_type;  // "image/png" or "image/jpeg"; other types are not supported everywhere
  std::string bytes;       // of the file
};

// Slots of prompts/user.md by name: name, size, mesh, camera, neighbours, offline, materials, category, ... A
// template line with an absent or empty slot is left out. `mesh`, `materials`, `category` and `neighbours`
// are derived from the ToolBox if absent. Values are plain text; `name` is the object's name from a user or a
// file.
struct AnalysisQuestion {
  std::map<std::string, std::string> slots;
  std::vector<AnalysisImage> images;
};

struct RawAnswer {
  std::string json;   // one JSON object, in the form of livegs.analysis/1 (prompts/answer.schema.json)
  std::string model;  // as reported by the server
  std::string prompt_version;  // "1-" and the start of a hash over every prompt text
  std::int64_t prompt_tokens = 0, completion_tokens = 0;  // of all turns together
  double cost_usd = 0;                                    // 0: unknown
  double wall_s = 0;  // of all calls so far, without the wait for a queue slot
  // JSON lines, one per request, reply and tool call; without the key and image bytes.
  std::string transcript;
  // For users: "the prompt was cut to 4096 tokens; set OLLAMA_CONTEXT_LENGTH".
  std::vector<std::string> warnings;
  bool blind = false;  // the server does not accept pictures; the question was sent without them
};

// Conversation about one object, used from one thread at a time. Calls block; a requested stop ends them
// within milliseconds with ErrorCode::Unavailable and a message that begins with "cancelled". Errors are one
// line with a remedy.
class Conversation {
 public:
  virtual ~Conversation() = default;
  virtual Result<RawAnswer> ask(const AnalysisQuestion& question, std::stop_token stop) = 0;
  // Continues the conversation: sends the validator's message about the last answer and returns a new answer.
  // Precondition: ask() returned an answer.
  virtual Result<RawAnswer> repair(std::string_view validator_message, std::stop_token stop) = 0;
};

// Status for users and dashboards; contains no secret.
struct EndpointState {
  std::string name;            // "http://127.0.0.1:11434/v1", "recorded in DIR"
  std::string model;           // empty until known
  std::string prompt_version;  // of the prompt texts, as in RawAnswer
  bool breaker_open = false;
  std::string breaker_reason;  // one line, empty while closed
  int in_flight = 0;
  int max_in_flight = 1;  // useful number of concurrent conversations
};

// Source of answers. Any thread. Must outlive its conversations.
class ModelEndpoint {
 public:
  virtual ~ModelEndpoint() = default;
  // Starts a conversation. Never blocks or fails; ask() reports faults of the endpoint.
  virtual std::unique_ptr<Conversation> start(ToolBox tools) = 0;
  // Determines the inputs of a question's hash, such as the model if none is named. Blocks briefly; ask()
  // reports failures.
  virtual void get_ready(std::stop_token) {}
  virtual EndpointState state() const = 0;
  // Texts of facts, complaints and tool results; valid for the lifetime of the endpoint.
  virtual const MessageTemplates& words() const { return MessageTemplates::built_in(); }
};

}  // namespace livegs
