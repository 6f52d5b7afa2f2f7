// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "session/client_session.h"

namespace livegs {

inline constexpr size_t kMaxSessions = 64;
// A stream that sends nothing for so long is over: clients send a sign of life every 50 ms.
inline constexpr int64_t kSilentAfter_ns = 2'000'000'000;
// From Join to Stream a client fetches assets and ties kernels to drivers, which may take a while.
inline constexpr int64_t kJoinExpiry_ns = 120'000'000'000;

// Who is there and what there is to see. Objects and sessions stand under one lock, so that the list a client
// is given and the events it gets afterwards fit together. Any thread.
class SessionTable {
 public:
  using Object = std::shared_ptr<const v1::ObjectDescription>;

  // From now on clients may join. `inputs` outlives the table's sessions.
  void open(std::string scene, double rate_hz, std::vector<Object> objects, InputSink& inputs);
  // Ends every stream with the reason; nobody joins any more.
  void close(const std::string& reason);

  struct Joined {
    std::shared_ptr<ClientSession> session;
    std::vector<Object> objects;
  };
  // Unavailable before open and after close, TooLarge when kMaxSessions are there.
  Result<Joined> join();
  std::shared_ptr<ClientSession> find(std::string_view session_id) const;
  void remove(const ClientSession& session);

  // A new tick for everybody, with what came, changed and went in it.
  void deliver(std::shared_ptr<const PublishedTick> tick, std::span<const Object> added,
               std::span<const Object> changed, std::span<const uint32_t> removed);
  // Drops sessions that went silent or never opened a stream.
  void sweep(int64_t now_ns);

  Object object(std::string_view name) const;  // nullptr if unknown
  std::vector<std::string> object_names() const;
  void hear(const ClientSession& session, std::span<const InputSample> samples);

  struct Status {
    std::string scene;
    double rate_hz = 0;
    uint64_t tick = 0;
    size_t objects = 0, clients = 0, streaming = 0;
    bool open = false;
  };
  Status status() const;

  struct Totals {
    uint64_t sessions = 0, frames_sent = 0, frames_replaced = 0;
  };
  Totals totals() const;  // over sessions that have ended

 private:
  std::vector<std::shared_ptr<ClientSession>> sessions_now() const;

  mutable std::mutex mutex_;  // guards everything below
  bool open_ = false;
  std::string closed_reason_ = "the scene is still being built";
  std::string scene_;
  double rate_hz_ = 0;
  uint64_t tick_ = 0;
  InputSink* inputs_ = nullptr;
  std::vector<Object> objects_;  // the environment first
  std::map<std::string, std::shared_ptr<ClientSession>, std::less<>> sessions_;
  SessionNumber next_number_ = 1;
  Totals totals_;
};

}  // namespace livegs
