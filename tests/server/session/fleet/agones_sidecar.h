// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "core/clock.h"
#include "test_http_server.h"

namespace livegs {

// The sidecar of Agones: its REST interface on 127.0.0.1, with a GameServer that takes the states that are
// requested. Records all calls with their times.
class AgonesSidecar {
 public:
  struct Call {
    std::string what;  // "POST /ready"
    std::string body;
    int64_t at_ns = 0;
  };

  // `port`: 0 lets the system choose.
  explicit AgonesSidecar(int port = 0)
      : server_([this](const SeenRequest& request, int) { return answer(request); }, port) {}

  int port() const { return server_.port(); }

  // As an operator does; before the calls that read it.
  void set_state(const std::string& state) {
    std::lock_guard lock(mutex_);
    state_ = state;
  }
  void set_annotations(const std::string& json_members) {
    std::lock_guard lock(mutex_);
    annotations_ = json_members;
  }
  // The status of every reply to this call, with its text; 0: no reply.
  void refuse(const std::string& what, int status, const std::string& message = "try again") {
    std::lock_guard lock(mutex_);
    refused_[what] = {status, message};
  }
  void accept(const std::string& what) {
    std::lock_guard lock(mutex_);
    refused_.erase(what);
  }

  std::vector<Call> calls() const {
    std::lock_guard lock(mutex_);
    return calls_;
  }
  size_t count(const std::string& what) const {
    std::lock_guard lock(mutex_);
    return count_now(what);
  }
  // Position of the first such call; npos without one.
  size_t first(const std::string& what) const {
    std::lock_guard lock(mutex_);
    const auto found =
        std::find_if(calls_.begin(), calls_.end(), [&](const Call& call) { return call.what == what; });
    return found == calls_.end() ? std::string::npos : static_cast<size_t>(found - calls_.begin());
  }
  bool wait_for(const std::string& what, size_t times = 1) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(60), [&] { return count_now(what) >= times; });
  }
  bool wait_for_body(const std::string& what, const std::string& part) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(60), [&] {
      return std::any_of(calls_.begin(), calls_.end(), [&](const Call& call) {
        return call.what == what && call.body.find(part) != std::string::npos;
      });
    });
  }
  // Waits until the newest such call that was accepted has this part.
  bool wait_for_accepted(const std::string& what, const std::string& part) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(60), [&] {
      const auto newest = accepted_.find(what);
      return newest != accepted_.end() && newest->second.find(part) != std::string::npos;
    });
  }
  int64_t last_ns(const std::string& what) const {
    std::lock_guard lock(mutex_);
    int64_t last = 0;
    for (const Call& call : calls_)
      if (call.what == what) last = call.at_ns;
    return last;
  }

 private:
  struct Refusal {
    int status = 0;
    std::string message;
  };
  size_t count_now(const std::string& what) const {
    return static_cast<size_t>(
        std::count_if(calls_.begin(), calls_.end(), [&](const Call& call) { return call.what == what; }));
  }

  Reply answer(const SeenRequest& request) {
    std::lock_guard lock(mutex_);
    const std::string what = request.method + " " + request.path;
    calls_.push_back({what, request.body, now_ns()});
    changed_.notify_all();
    Reply reply;
    if (const auto refused = refused_.find(what); refused != refused_.end()) {
      reply.status = refused->second.status;
      reply.hang = reply.status == 0;
      if (reply.hang) reply.cut_after = 0;
      reply.body = R"({"code": 2, "message": ")" + refused->second.message + R"("})";
      return reply;
    }
    accepted_[what] = request.body;
    if (what == "POST /ready") state_ = "Ready";
    if (what == "POST /allocate") state_ = "Allocated";
    if (what == "POST /shutdown") state_ = "Shutdown";
    reply.body = "{}";
    if (what == "GET /gameserver") {
      reply.body = R"({"object_meta": {"name": "room-x7k2p", "namespace": "default", "annotations": {)" +
                   annotations_ + R"(}}, "status": {"state": ")" + state_ +
                   R"(", "address": "10.0.0.7", "ports": [{"name": "default", "port": 7777}]}})";
    }
    return reply;
  }

  mutable std::mutex mutex_;  // guards everything down to refused_
  mutable std::condition_variable changed_;
  std::vector<Call> calls_;
  std::string state_ = "Scheduled", annotations_;
  std::map<std::string, std::string> accepted_;  // body of the newest one
  std::map<std::string, Refusal> refused_;
  TestHttpServer server_;  // last: its threads use everything above
};

}  // namespace livegs
