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
#include "analysis/model/chat/http_client.h"
#include "analysis/model/chat/request_limits.h"
#include "analysis/model/chat/transcript.h"
#include "analysis/model/model_endpoint.h"
#include "core/token_bucket.h"

namespace livegs {

// What became of one request with its repeats.
struct ServerAnswer {
  enum class Kind {
    Answered,  // `reply` holds a choice
    Refused,   // and a part of the request was given up: worth asking again
    Failed,    // `error` says it for people
    Cancelled,
  };
  Kind kind = Kind::Failed;
  ChatReply reply;
  Error error;
};

// One model server, asked with manners: a token bucket, a bounded number of conversations at once, repeats
// with backoff for what passes by itself, none for what does not, and a circuit breaker. Any thread; calls
// block.
class ModelServer {
 public:
  explicit ModelServer(const EndpointSettings& settings);

  // A place among the conversations that run at once.
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
  Slot take_slot(int max_in_flight, std::stop_token stop);  // empty when stopped

  // The list of models, one try with a short limit; "" where there is none. `status` 401 and 403 mean the
  // key.
  std::string probe(std::stop_token stop, int& status);

  // Whether a part of the request is given up after this refusal; with `named_only`, none that it does not
  // name.
  using DropRequestPart = std::function<bool(const ServerError& refusal, bool named_only)>;

  // POST /chat/completions with repeats until `deadline_ns` of now_ns().
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
  mutable std::mutex mutex_;  // guards everything below it
  mutable std::condition_variable_any changed_;
  int in_flight_ = 0;
  TokenBucket bucket_;
  CircuitBreaker breaker_;
  std::mt19937_64 random_;
  HttpClient client_;  // last: its thread ends first
};

}  // namespace livegs
