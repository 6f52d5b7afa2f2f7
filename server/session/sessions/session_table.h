// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "session/sessions/client_session.h"

namespace livegs {

// Default and upper limit of sessions. A client has three connections, and kMaxConnections is the total.
inline constexpr size_t kDefaultSessions = 64, kMaxSessions = 320;
// A stream without messages for this time is ended, also before its first message. Clients send at least
// every 50 ms.
inline constexpr int64_t kSilenceTimeout_ns = 2'000'000'000;
// Time for a stream to finish its current write before it is aborted.
inline constexpr int64_t kEndTimeout_ns = 500'000'000;
// Interval of the token checks.
inline constexpr int64_t kAuthorizationCheckInterval_ns = 1'000'000'000;
// Time for which a parked session is kept.
inline constexpr int64_t kParkedTimeout_ns = 30'000'000'000;
// Time from Join to Stream, in which a client fetches assets and binds kernels.
inline constexpr int64_t kJoinTimeout_ns = 120'000'000'000;

// The sessions and the objects of the scene. One lock guards both, so that a client's object list and its
// later events are consistent. A client that lost its connection resumes in join(). It receives all
// objects again, and its next stream starts with a keyframe. Missed events are not kept. Any thread.
class SessionTable {
 public:
  SessionTable();
  using Object = std::shared_ptr<const v1::ObjectDescription>;

  // Random id of this server run.
  const std::string& instance() const { return instance_; }
  // Maximum number of sessions including parked ones, 1 to kMaxSessions; call before open().
  void set_max_sessions(size_t sessions) { max_sessions_ = sessions; }
  // Lets clients join. `inputs` must outlive the sessions.
  void open(std::string scene, double rate_hz, std::vector<Object> objects, InputSink& inputs);
  // The next server of a client; without an address if there is none.
  using NextServerFor = std::function<v1::NextServer(const Authorization&)>;
  // Ends every stream with the reason and the next server; new clients cannot join. With `next`, a client
  // that has lost its connection can still resume its session, and its stream ends in the same way.
  void close(const std::string& reason, const NextServerFor& next = {});
  // Waits for the end of all sessions.
  void wait_until_empty(std::chrono::steady_clock::time_point end);

  struct Joined {
    std::shared_ptr<ClientSession> session;
    std::vector<Object> objects;
  };
  // `resumed_id`: a session to resume, if it exists and was opened with the same token; otherwise a new
  // session is created. Unavailable before open() and after close(). TooLarge if the table is full; the
  // longest parked session is dropped first.
  Result<Joined> join(std::string_view resumed_id = {}, ClientIdentity who = {}, const JoinTerms& terms = {});
  std::shared_ptr<ClientSession> find(std::string_view session_id) const;
  // Registers a stream. sweep() ends it if its first message does not name a session within
  // kSilenceTimeout_ns.
  void stream_begun(std::weak_ptr<SessionWriter> writer);
  // A stream was attached to the session. Ends it after close().
  void stream_attached(ClientSession& session, SessionWriter& writer);
  // Ends a stream of the session. `in_order`: the session ends too; otherwise it is parked. No effect if the
  // session has moved to another stream.
  void stream_ended(ClientSession& session, uint64_t stream, bool in_order);

  // Checks that an authorization is still valid; called once a second and by end_unauthorised(). Set before
  // open().
  using AuthorizationCheck = std::function<Result<void>(const Authorization&)>;
  void check_authorizations_with(AuthorizationCheck check) { authorization_check_ = std::move(check); }
  // Ends every session whose authorization is not valid any more, with the reason.
  void end_unauthorised();
  // Ends the session whose id has this prefix; returns the id. NotFound for none, InvalidArgument for several
  // or for fewer than four digits.
  Result<std::string> end_session(std::string_view id_begin, const Error& why);

  // Offers a tick to all sessions, with the objects added, changed and removed in it. Returns the new event
  // number.
  uint64_t deliver(std::shared_ptr<TickEncodings> tick, std::span<const Object> added,
                   std::span<const Object> changed, std::span<const uint32_t> removed);
  // Adds the proposal of a model, and the reason why it needs a decision, to the descriptions of objects of
  // this name; null removes it. Clients are notified at once, even without ticks.
  void propose(const std::string& object, const v1::PhysicsFile* proposal);
  // True if a streaming client requested this encoding.
  bool has_clients_for(v1::JoinRequest::Encoding encoding) const;
  // Offers a tick with kernels of this encoding to the clients that requested it. Call after deliver().
  void deliver_kernels(std::shared_ptr<const TickEncodings> tick, v1::JoinRequest::Encoding encoding);
  // Ends silent streams, drops timed-out sessions and sends keepalives to the others.
  void sweep(int64_t now_ns);

  // The scene. Unavailable before open() and after close(), except for a session that can still resume.
  struct Described {
    std::string scene;
    double rate_hz = 0;
    uint64_t event_number = 0;  // added, removed and changed objects so far
    std::vector<Object> objects;
  };
  Result<Described> described(std::string_view resumed_id = {}) const;
  Object object(std::string_view name) const;  // null if unknown
  std::vector<std::string> object_names() const;
  // Hashes of the assets that clients may fetch.
  std::set<std::string> asset_hashes() const;
  std::vector<std::shared_ptr<ClientSession>> sessions_now() const;
  // Forwards input. Ignored for sessions without INTERACT and for removed sessions.
  void on_input(const ClientSession& session, std::span<const InputSample> samples);

  struct Status {
    std::string scene;
    double rate_hz = 0;
    uint64_t tick = 0;
    size_t objects = 0, clients = 0, streaming = 0;  // clients includes parked ones
    bool open = false;
  };
  Status status() const;

  struct Totals {
    uint64_t sessions = 0, frames_sent = 0, frames_replaced = 0;
  };
  Totals totals() const;  // of ended sessions

 private:
  Object with_proposal(Object object) const;  // mutex_ must be held
  // Adds events to all sessions; mutex_ must be held. Sessions that do not read are appended to `stalled`, to
  // be aborted without the lock.
  struct StalledSession {
    std::shared_ptr<ClientSession> session;
    ClientSession::Stream stream;
  };
  void broadcast(std::span<const v1::SessionEvent> events, std::vector<StalledSession>& stalled);
  static void abort_streams(std::span<const StalledSession> stalled);
  void remove(const ClientSession& session);
  void remove(const ClientSession& session, const std::lock_guard<std::mutex>& lock);
  void end(ClientSession& session, const Error& why);
  void close_stream(ClientSession& session, SessionWriter& writer);

  const std::string instance_;
  AuthorizationCheck authorization_check_;
  size_t max_sessions_ = kDefaultSessions;
  mutable std::mutex mutex_;  // guards everything below
  bool open_ = false;
  std::string closed_reason_ = "server: the scene is still loading; try again later";
  NextServerFor next_;               // set by close()
  std::condition_variable removed_;  // a session was removed
  std::string scene_;
  double rate_hz_ = 0;
  uint64_t tick_ = 0;
  uint64_t event_number_ = 0;
  InputSink* inputs_ = nullptr;
  std::vector<Object> objects_;                       // environment first
  std::shared_ptr<const ObjectReaches> reaches_;      // of objects_
  std::map<std::string, v1::PhysicsFile> proposals_;  // by object name
  std::map<std::string, std::shared_ptr<ClientSession>, std::less<>> sessions_;
  SessionNumber next_number_ = 1;
  int64_t authorizations_checked_ns_ = 0;
  // Streams of the last two seconds, oldest first; each is checked once.
  struct Begun {
    std::weak_ptr<SessionWriter> writer;
    int64_t begun_ns = 0;
  };
  std::deque<Begun> begun_;
  // Streams that are ending, and since when. A stream whose client does not read the current write is
  // aborted.
  struct Ending {
    std::weak_ptr<SessionWriter> writer;
    int64_t since_ns = 0;
  };
  std::vector<Ending> ending_;
  Totals totals_;
};

}  // namespace livegs
