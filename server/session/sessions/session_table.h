// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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

// Unless it is told another number, up to kMaxSessions: a client has three connections, and kMaxConnections
// are let in.
inline constexpr size_t kDefaultSessions = 64, kMaxSessions = 320;
// A stream that sends nothing for so long is over, one that has just begun too: clients send a sign of life
// every 50 ms.
inline constexpr int64_t kSilenceTimeout_ns = 2'000'000'000;
// So long a stream that was told to end may take to write what it is writing.
inline constexpr int64_t kEndTimeout_ns = 500'000'000;
// So often it is looked whether tokens still hold.
inline constexpr int64_t kGrantCheckInterval_ns = 1'000'000'000;
// So long a session is kept whose stream broke.
inline constexpr int64_t kParkedTimeout_ns = 30'000'000'000;
// From Join to Stream a client fetches assets and ties kernels to drivers, which may take a while.
inline constexpr int64_t kJoinTimeout_ns = 120'000'000'000;

// Who is there and what there is to see. Objects and sessions stand under one lock, so that the list a client
// is given and the events it gets afterwards fit together. Any thread.
class SessionTable {
 public:
  SessionTable();
  using Object = std::shared_ptr<const v1::ObjectDescription>;

  // Random, drawn when the table was made.
  const std::string& instance() const { return instance_; }
  // How many sessions there may be, parked ones included, 1 to kMaxSessions; before open().
  void set_max_sessions(size_t sessions) { max_sessions_ = sessions; }
  // From now on clients may join. `inputs` outlives the table's sessions.
  void open(std::string scene, double rate_hz, std::vector<Object> objects, InputSink& inputs);
  // Ends every stream with the reason; nobody joins any more.
  void close(const std::string& reason);

  struct Joined {
    std::shared_ptr<ClientSession> session;
    std::vector<Object> objects;
  };
  // `resumed_id`: of a session to go on with, if it is still there and was opened with the same token; else,
  // and when empty, a new one. Unavailable before open and after close, TooLarge when as many as may be are
  // there; of those the one parked longest makes room.
  Result<Joined> join(std::string_view resumed_id = {}, ClientIdentity who = {}, const JoinTerms& terms = {});
  std::shared_ptr<ClientSession> find(std::string_view session_id) const;
  // A stream that has no session until its first message names one; kSilenceTimeout_ns later sweep() ends it
  // if there was none.
  void stream_begun(std::weak_ptr<SessionWriter> writer);
  // The session's stream of this number is over: in order, and so is the session, or it broke, and the
  // session waits for its client. Nothing if the session has gone on without that stream.
  void stream_ended(ClientSession& session, uint64_t stream, bool in_order);

  // Whether what a session was opened with still holds; asked once a second and by end_unauthorised(). Before
  // open().
  using GrantCheck = std::function<Result<void>(const Grant&)>;
  void check_grants_with(GrantCheck check) { grant_check_ = std::move(check); }
  // Ends every session whose grant does not hold any more, with the reason why.
  void end_unauthorised();
  // Ends the one session whose id begins so; its id. NotFound for none, InvalidArgument for several or too
  // few digits.
  Result<std::string> end_session(std::string_view id_begin, const Error& why);

  // A new tick for everybody, with what came, changed and went in it. The event number from then on.
  uint64_t deliver(std::shared_ptr<TickEncodings> tick, std::span<const Object> added,
                   std::span<const Object> changed, std::span<const uint32_t> removed);
  // Objects of this name are described with this answer of a model, which waits for a person, and why it does
  // among their warnings; nullptr: none waits any more. Who is there is told at once, whether there are ticks
  // or not.
  void propose(const std::string& object, const v1::PhysicsFile* proposal);
  // Whether anybody who is there asked for frames of this encoding.
  bool has_clients_for(v1::JoinRequest::Encoding encoding) const;
  // A tick whose kernels are kept in it as `encoding`, for those who asked for that. After deliver() of it.
  void deliver_kernels(std::shared_ptr<const TickEncodings> tick, v1::JoinRequest::Encoding encoding);
  // Ends streams that went silent and drops sessions that were parked or never opened a stream for too long;
  // sees to it that the others on_input something.
  void sweep(int64_t now_ns);

  // The scene, for who has no session. Unavailable before open and after close.
  struct Described {
    std::string scene;
    double rate_hz = 0;
    uint64_t event_number = 0;  // births, deaths and changes so far
    std::vector<Object> objects;
  };
  Result<Described> described() const;
  Object object(std::string_view name) const;  // nullptr if unknown
  std::vector<std::string> object_names() const;
  // Of what clients may fetch now.
  std::set<std::string> asset_hashes() const;
  std::vector<std::shared_ptr<ClientSession>> sessions_now() const;
  // Nothing of a session that may only look, and nothing once it was removed.
  void on_input(const ClientSession& session, std::span<const InputSample> samples);

  struct Status {
    std::string scene;
    double rate_hz = 0;
    uint64_t tick = 0;
    size_t objects = 0, clients = 0, streaming = 0;  // clients: parked ones too
    bool open = false;
  };
  Status status() const;

  struct Totals {
    uint64_t sessions = 0, frames_sent = 0, frames_replaced = 0;
  };
  Totals totals() const;  // over sessions that have ended

 private:
  Object with_proposal(Object object) const;  // under the lock
  // Tells everybody, under the lock; adds those who do not read, to be cut off without it, to the list.
  struct StalledSession {
    std::shared_ptr<ClientSession> session;
    ClientSession::Stream stream;
  };
  void broadcast(std::span<const v1::SessionEvent> events, std::vector<StalledSession>& stalled);
  static void abort_streams(std::span<const StalledSession> stalled);
  void remove(const ClientSession& session);
  void remove(const ClientSession& session, const std::lock_guard<std::mutex>& lock);
  void end(ClientSession& session, const Error& why);

  const std::string instance_;
  GrantCheck grant_check_;
  size_t max_sessions_ = kDefaultSessions;
  mutable std::mutex mutex_;  // guards everything below
  bool open_ = false;
  std::string closed_reason_ = "the scene is still being built";
  std::string scene_;
  double rate_hz_ = 0;
  uint64_t tick_ = 0;
  uint64_t event_number_ = 0;
  InputSink* inputs_ = nullptr;
  std::vector<Object> objects_;                       // the environment first
  std::shared_ptr<const ObjectReaches> reaches_;      // of objects_
  std::map<std::string, v1::PhysicsFile> proposals_;  // by the object's name
  std::map<std::string, std::shared_ptr<ClientSession>, std::less<>> sessions_;
  SessionNumber next_number_ = 1;
  int64_t grants_checked_ns_ = 0;
  // Streams of the last two seconds, oldest first. None of them is looked at again.
  struct Begun {
    std::weak_ptr<SessionWriter> writer;
    int64_t begun_ns = 0;
  };
  std::deque<Begun> begun_;
  // Streams that were told to end, and when: one that is amid a write which its client does not read is cut
  // off.
  struct Ending {
    std::weak_ptr<SessionWriter> writer;
    int64_t told_ns = 0;
  };
  std::vector<Ending> ending_;
  Totals totals_;
};

}  // namespace livegs
