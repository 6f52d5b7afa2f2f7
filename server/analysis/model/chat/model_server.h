// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <random>
#include <stop_token>
#include <string>
#include <utility>

#include "analysis/model/chat/chat_reply.h"
#include "analysis/model/chat/request_limits.h"
#include "analysis/model/chat/transcript.h"
#include "analysis/model/model_endpoint.h"
#include "core/token_bucket.h"
#include "store/http_client.h"

namespace livegs {

// Result of one request with its retries.
struct ServerAnswer {
  enum class Kind {
    Answered,  // `reply` has a choice
    Refused,   // and a request part was disabled: send it again
    Failed,    // `error` holds the cause, for users
    Cancelled,
  };
  Kind kind = Kind::Failed;
  ChatReply reply;
  Error error;
};

// Client of one model server with rate control: a token bucket, a limit on concurrent conversations, retries
// with backoff for transient errors only, and a circuit breaker. Any thread; calls block.
class ModelServer {
 public:
  explicit ModelServer(const EndpointSettings& settings);

  // Slot of one concurrent conversation.
  class Slot {
   public:
    explicit Slot(ModelServer* server) : server_(server) {}
    ~Slot();
    Slot(Slot&& other) noexcept : server_(std::exchange(other.server_, nullptr)) {}
    Slot(const Slot&) = delete;
    Slot& operator=(const Slot&) = delete;
    explicit operator bool() const { return server_ != nullptr; }

   private:
    ModelServer* server_;
  };
  Slot take_slot(int max_in_flight, std::stop_token stop);  // empty if stopped

  // Requests the list of models, once and with a short timeout; "" on failure. `status` 401 or 403 means an
  // invalid key.
  std::string probe(std::stop_token stop, int& status);

  // Disables a request part after a refusal, with `named_only` only one that it names. Returns true if a part
  // was disabled.
  using DropRequestPart = std::function<bool(const ServerError& refusal, bool named_only)>;

  // Sends POST /chat/completions with retries until `deadline_ns` of now_ns().
  ServerAnswer chat(const std::string& body, bool event_stream, std::int64_t deadline_ns,
                    std::stop_token stop, const DropRequestPart& drop_request_part, Transcript& transcript);

  int in_flight() const;
  bool breaker_open(std::string& reason) const;

 private:
  struct Verdict;
  Verdict judge(const HttpReply& http) const;
  HttpReply send_chat(const std::string& body, bool event_stream, std::int64_t deadline_ns,
                      std::stop_token stop);
  void update_breaker(const Verdict& verdict);
  bool wait(double seconds, std::stop_token stop) const;
  double unit_random();

  const EndpointSettings& settings_;
  mutable std::mutex mutex_;  // guards the members below
  mutable std::condition_variable_any changed_;
  int in_flight_ = 0;
  TokenBucket bucket_;
  CircuitBreaker breaker_;
  std::mt19937_64 random_;
  HttpClient client_;  // declared last: its thread ends first
};

}  // namespace livegs
