// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "analysis/model/conversation.h"

namespace livegs {

// Model that answers from a function after a delay, fails, or hangs. Records its questions.
class FakeEndpoint final : public ModelEndpoint {
 public:
  // Answers turn 0 (the question), 1 (the repair), … about the object.
  using Say =
      std::function<Result<std::string>(const AnalysisQuestion& question, const ToolBox& tools, int turn)>;
  explicit FakeEndpoint(Say say) : say_(std::move(say)) {}

  std::function<std::chrono::milliseconds(const std::string& name)> delay;  // if empty, immediate
  int max_in_flight = 4;
  bool blind = false;  // does not accept pictures
  std::string model = "fake-1";
  bool names_its_model = true;  // before get_ready()

  void get_ready(std::stop_token) override { names_its_model = true; }
  std::unique_ptr<Conversation> start(ToolBox tools) override {
    return std::make_unique<Talk>(*this, std::move(tools));
  }
  EndpointState state() const override {
    EndpointState state;
    state.name = "fake";
    if (names_its_model) state.model = model;
    state.max_in_flight = max_in_flight;
    return state;
  }

  // Name, repair message or "", and the neighbours with their masses; sorted.
  std::vector<std::string> asked() const {
    std::lock_guard lock(mutex_);
    auto sorted = asked_;
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  }
  int most_at_once() const {
    std::lock_guard lock(mutex_);
    return most_;
  }

 private:
  class Talk final : public Conversation {
   public:
    Talk(FakeEndpoint& fake, ToolBox tools) : fake_(fake), tools_(std::move(tools)) {}
    Result<RawAnswer> ask(const AnalysisQuestion& question, std::stop_token stop) override {
      question_ = question;
      return fake_.say(question_, tools_, turn_++, "", stop);
    }
    Result<RawAnswer> repair(std::string_view message, std::stop_token stop) override {
      return fake_.say(question_, tools_, turn_++, std::string(message), stop);
    }

   private:
    FakeEndpoint& fake_;
    ToolBox tools_;
    AnalysisQuestion question_;
    int turn_ = 0;
  };

  Result<RawAnswer> say(const AnalysisQuestion& question, const ToolBox& tools, int turn,
                        const std::string& repair, std::stop_token stop) {
    const std::string name = question.slots.at("name");
    std::string line = name + " <" + repair + ">";
    for (const SceneObjectFacts& one : tools.scene()) {
      line += " " + one.name + (one.analysed ? "!" : "?") + std::to_string(one.mass_kg);
    }
    {
      std::unique_lock lock(mutex_);
      asked_.push_back(line);
      most_ = std::max(most_, ++now_);
      // Also ends a hang.
      if (delay) changed_.wait_for(lock, stop, delay(name), [] { return false; });
      --now_;
    }
    if (stop.stop_requested()) return Error{ErrorCode::Unavailable, "cancelled"};
    auto text = say_(question, tools, turn);
    if (!text) return text.error();
    RawAnswer answer;
    answer.json = std::move(*text);
    answer.model = model;
    answer.wall_s = 2 * (turn + 1);
    answer.blind = blind;
    answer.prompt_version = "1-test";
    answer.prompt_tokens = 1000 * (turn + 1);
    answer.completion_tokens = 250 * (turn + 1);
    answer.transcript = "said to " + name;
    answer.warnings = {"made up"};
    return answer;
  }

  Say say_;
  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable_any changed_;
  std::vector<std::string> asked_;
  int now_ = 0, most_ = 0;
};

}  // namespace livegs
