// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "analysis/model/chat/chat_endpoint.h"
#include "analysis/model/chat/chat_request.h"
#include "analysis/model/chat/transcript.h"

namespace livegs {

// Conversation in two phases, in separate requests: first the tools, for a bounded number of rounds; then the
// answer, in the strictest form that the server supports. A complete answer in place of a tool call is
// accepted. Refused request parts are left out afterwards.
class ChatConversation final : public Conversation {
 public:
  ChatConversation(ChatEndpoint& endpoint, ToolBox tools);
  Result<RawAnswer> ask(const AnalysisQuestion& question, std::stop_token stop) override;
  Result<RawAnswer> repair(std::string_view validator_message, std::stop_token stop) override;

 private:
  enum class Phase { Search, Tools, Answer };
  Result<RawAnswer> converse(std::stop_token stop, bool with_tools);
  Result<Json> run_tools(std::stop_token stop);  // a complete answer, or null after the last tool round
  Result<Json> run_answer(std::stop_token stop);
  void search(std::map<std::string, std::string>& slots, std::stop_token stop);
  ServerAnswer send(Phase phase, std::stop_token stop);
  void begin_turns();
  void put_last_turn();
  void note_truncation(const ChatReply& reply);
  void warn_search_unsupported();
  void warn(const std::string& warning);

  ChatEndpoint& endpoint_;
  ToolBox tools_;
  EndpointQuirks quirks_;
  Transcript transcript_;
  std::map<std::string, std::string> slots_;
  std::vector<AnalysisImage> images_;
  std::vector<ChatTurn> turns_;
  std::string opening_;            // the user's first turn without the final instruction
  std::string repair_turn_;        // replaces the answer turn
  std::size_t opening_turns_ = 0;  // number of turns before any tool
  std::int64_t deadline_ns_ = 0, max_tokens_ = 0;
  int refusals_ = 0;
  RawAnswer answer_;  // sums so far
};

}  // namespace livegs
