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

// What the rest of the analysis sees of a language model: one conversation about one object, as a question of
// slots and pictures and an answer of JSON. What speaks to a server, what replays a recording and what a test
// makes up all stand behind these two classes. The answer is text from outside: nothing in it is checked here
// beyond being one JSON object; the acceptance gate judges it.

namespace livegs {

struct AnalysisImage {
  std::string caption;     // what it shows, by its name in prompts/captions.json: "outlined"
  std::string media_type;  // "image/png" or "image/jpeg"; nothing else is understood everywhere
  std::string bytes;       // of the file
};

// Slots of prompts/user.md by name: name, size, mesh, camera, neighbours, offline, materials, category, ... A
// line of the template whose slot is absent or empty is left out. `mesh`, `materials`, `category` and
// `neighbours` are worked out from the ToolBox when they are not given. Values are plain text; `name` is what
// a person or a file calls the object.
struct AnalysisQuestion {
  std::map<std::string, std::string> slots;
  std::vector<AnalysisImage> images;
};

struct RawAnswer {
  std::string json;            // one JSON object, meant to be livegs.analysis/1 (prompts/answer.schema.json)
  std::string model;           // as the server named it
  std::string prompt_version;  // "1-" and the start of a hash over every prompt text
  std::int64_t prompt_tokens = 0, completion_tokens = 0;  // of all turns together
  double cost_usd = 0;                                    // 0: unknown
  double wall_s = 0;  // of all calls so far, without the wait for a place in the queue
  std::string
      transcript;  // JSON lines, one a request, reply and tool call; without the key and without image bytes
  std::vector<std::string>
      warnings;        // for people: "the prompt was cut to 4096 tokens; set OLLAMA_CONTEXT_LENGTH"
  bool blind = false;  // the server takes no pictures: it was asked without those of the question
};

// One conversation about one object, by one thread at a time. Calls block; a requested stop ends them within
// milliseconds with ErrorCode::Unavailable and a message that begins "cancelled". Errors are one line with a
// remedy.
class Conversation {
 public:
  virtual ~Conversation() = default;
  virtual Result<RawAnswer> ask(const AnalysisQuestion& question, std::stop_token stop) = 0;
  // The same conversation goes on: what the validator found wrong with the last answer, and a new one.
  // Precondition: ask() gave an answer.
  virtual Result<RawAnswer> repair(std::string_view validator_message, std::stop_token stop) = 0;
};

// For people and dashboards; holds no secret.
struct EndpointState {
  std::string name;            // "http://127.0.0.1:11434/v1", "recorded in DIR"
  std::string model;           // empty until known
  std::string prompt_version;  // of the texts it asks with, as in RawAnswer
  bool breaker_open = false;
  std::string breaker_reason;  // one line, empty while closed
  int in_flight = 0;
  int max_in_flight = 1;  // how many objects are worth asking about at once
};

// A place that answers. Any thread may call. It outlives its exchanges.
class ModelEndpoint {
 public:
  virtual ~ModelEndpoint() = default;
  // Never blocks, never fails: what is wrong with the endpoint is told by ask().
  virtual std::unique_ptr<Conversation> start(ToolBox tools) = 0;
  // Finds out what a question's hash has to know, such as the model where none is named. Blocks for a moment;
  // what fails here is told by ask().
  virtual void get_ready(std::stop_token) {}
  virtual EndpointState state() const = 0;
  // What an object's facts, complaints and tools are worded with; lives as long as this.
  virtual const MessageTemplates& words() const { return MessageTemplates::built_in(); }
};

}  // namespace livegs
