// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <mutex>
#include <set>
#include <string>

#include "analysis/model/chat/endpoint_quirks.h"
#include "analysis/model/chat/model_server.h"
#include "analysis/model/model_endpoint.h"
#include "analysis/model/prompt_set.h"

namespace livegs {

// Endpoint of a chat-completions server; holds the knowledge about the server that its conversations share.
class ChatEndpoint final : public ModelEndpoint {
 public:
  ChatEndpoint(EndpointSettings settings, PromptSet prompts);

  std::unique_ptr<Conversation> start(ToolBox tools) override;
  EndpointState state() const override;
  const MessageTemplates& words() const override { return prompts_.words(); }
  void get_ready(std::stop_token stop) override {
    if (model().empty()) (void)identify_server(stop);
  }

  // Identifies the server and its model once; takes at most probe_timeout_s. Fails without a model.
  Result<void> identify_server(std::stop_token stop);

  const EndpointSettings& settings() const { return settings_; }
  const PromptSet& prompts() const { return prompts_; }
  ModelServer& server() { return server_; }
  std::string model() const;
  EndpointQuirks quirks() const;
  void keep(const EndpointQuirks& quirks);  // stores verified quirks
  int max_in_flight() const;
  double deadline_s() const;
  // Logs each warning once.
  void warn_once(const std::string& warning);

 private:
  bool decodes_one_at_a_time() const;
  std::string memory_key() const { return settings_.base_url + " " + model_; }

  const EndpointSettings settings_;
  const PromptSet prompts_;
  QuirkMemory memory_;
  std::mutex probing_;        // held while the server is identified
  mutable std::mutex mutex_;  // guards the members below
  bool known_ = false;
  std::string model_;
  std::set<std::string> warned_;
  EndpointQuirks quirks_;
  ModelServer server_;
};

}  // namespace livegs
