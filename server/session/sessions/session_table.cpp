// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/sessions/session_table.h"

#include <algorithm>
#include <cstdio>
#include <random>

#include "core/clock.h"
#include "core/log.h"
#include "session/access/id_prefix.h"

namespace livegs {
namespace {

// A random 128-bit id. It authenticates the session, so it must not be guessable.
std::string random_id() {
  std::random_device device;
  char text[33];
  std::snprintf(text, sizeof text, "%08x%08x%08x%08x", device(), device(), device(), device());
  return text;
}

// Prefix of the warning with the reason for a proposal.
const std::string kNeedsReview = "needs review: ";

std::shared_ptr<const ObjectReaches> reaches_of(std::span<const SessionTable::Object> objects) {
  auto reaches = std::make_shared<ObjectReaches>();
  for (const SessionTable::Object& object : objects) reaches->emplace(object->object_id(), object->reach_m());
  return reaches;
}

}  // namespace

SessionTable::SessionTable() : instance_(random_id()) {}

void SessionTable::open(std::string scene, double rate_hz, std::vector<Object> objects, InputSink& inputs) {
  std::stable_sort(objects.begin(), objects.end(),
                   [](const Object& a, const Object& b) { return a->environment() > b->environment(); });
  std::lock_guard lock(mutex_);
  scene_ = std::move(scene);
  rate_hz_ = rate_hz;
  objects_ = std::move(objects);
  for (Object& object : objects_) object = with_proposal(std::move(object));
  reaches_ = reaches_of(objects_);
  inputs_ = &inputs;
  open_ = true;
}

void SessionTable::close(const std::string& reason, const NextServerFor& next) {
  {
    std::lock_guard lock(mutex_);
    open_ = false;
    closed_reason_ = reason;
    next_ = next;
  }
  for (const auto& session : sessions_now()) {
    if (const auto writer = session->writer())
      close_stream(*session, *writer);
    else if (!next)
      remove(*session);
  }
}

void SessionTable::close_stream(ClientSession& session, SessionWriter& writer) {
  v1::SessionEvent draining;
  NextServerFor next;
  {
    std::lock_guard lock(mutex_);
    draining.set_draining(closed_reason_);
    next = next_;
  }
  if (next) *draining.mutable_next_server() = next(session.who.authorization);
  session.add_event(draining);
  writer.close(draining.draining());
}

void SessionTable::stream_attached(ClientSession& session, SessionWriter& writer) {
  {
    std::lock_guard lock(mutex_);
    if (open_) return;
  }
  close_stream(session, writer);
}

void SessionTable::wait_until_empty(std::chrono::steady_clock::time_point end) {
  std::unique_lock lock(mutex_);
  removed_.wait_until(lock, end, [&] { return sessions_.empty(); });
}

Result<SessionTable::Joined> SessionTable::join(std::string_view resumed_id, ClientIdentity who,
                                                const JoinTerms& terms) {
  std::shared_ptr<SessionWriter> left;
  Joined joined;
  {
    std::lock_guard lock(mutex_);
    const auto found = sessions_.find(resumed_id);
    const bool resumes =
        found != sessions_.end() && found->second->who.authorization.token_id == who.authorization.token_id;
    if (!open_ && !(resumes && next_)) return Error{ErrorCode::Unavailable, closed_reason_};
    if (resumes) {
      joined.session = found->second;
      left = joined.session->rejoin(now_ns(), terms);
    } else {
      if (sessions_.size() >= max_sessions_) {
        std::shared_ptr<ClientSession> parked_longest;
        for (const auto& [id, session] : sessions_) {
          if (session->state() == ClientSession::State::Parked &&
              (!parked_longest || session->last_message_ns < parked_longest->last_message_ns)) {
            parked_longest = session;
          }
        }
        if (!parked_longest) {
          return Error{ErrorCode::TooLarge, "clients: " + std::to_string(max_sessions_) +
                                                " are connected, the maximum; try again later, or "
                                                "start the server with a larger --clients"};
        }
        remove(*parked_longest, lock);
      }
      joined.session =
          std::make_shared<ClientSession>(random_id(), next_number_++, now_ns(), std::move(who), terms);
      sessions_.emplace(joined.session->id, joined.session);
      ++totals_.sessions;
    }
    joined.objects = objects_;
  }
  if (left) left->abort();
  return joined;
}

std::shared_ptr<ClientSession> SessionTable::find(std::string_view session_id) const {
  std::lock_guard lock(mutex_);
  const auto found = sessions_.find(session_id);
  return found == sessions_.end() ? nullptr : found->second;
}

void SessionTable::stream_begun(std::weak_ptr<SessionWriter> writer) {
  std::lock_guard lock(mutex_);
  begun_.push_back({std::move(writer), now_ns()});
}

void SessionTable::stream_ended(ClientSession& session, uint64_t stream, bool in_order) {
  if (!session.park(stream)) return;
  bool keep = !in_order;
  {
    std::lock_guard lock(mutex_);
    keep = keep && (open_ || next_);
  }
  if (!keep) remove(session);
}

void SessionTable::remove(const ClientSession& session) {
  std::lock_guard lock(mutex_);
  remove(session, lock);
}

void SessionTable::remove(const ClientSession& session, const std::lock_guard<std::mutex>&) {
  const auto found = sessions_.find(session.id);
  if (found == sessions_.end()) return;
  totals_.frames_sent += session.frames_sent();
  totals_.frames_replaced += session.frames_replaced();
  const std::shared_ptr<ClientSession> last_share = std::move(found->second);
  sessions_.erase(found);
  removed_.notify_all();
  if (inputs_ != nullptr) inputs_->on_session_closed(last_share->number);
}

void SessionTable::end(ClientSession& session, const Error& why) {
  log_info("session %.8s: ended: %s", session.id.c_str(), why.message.c_str());
  const ClientSession::Stream stream = session.stream();
  if (stream.writer) {
    {
      std::lock_guard lock(mutex_);
      ending_.push_back({stream.writer, now_ns()});
    }
    stream.writer->end(why);
  }
  session.give_up(stream.number);
  remove(session);
}

void SessionTable::end_unauthorised() {
  if (!authorization_check_) return;
  for (const auto& session : sessions_now()) {
    if (const auto holds = authorization_check_(session->who.authorization); !holds)
      end(*session, holds.error());
  }
}

Result<std::string> SessionTable::end_session(std::string_view id_begin, const Error& why) {
  const auto sessions = sessions_now();
  std::vector<std::string> ids;
  for (const auto& session : sessions) ids.push_back(session->id);
  const auto found = find_by_prefix(ids, id_begin, "session", "livegs ctl clients");
  if (!found) return found.error();
  end(*sessions[*found], why);
  return ids[*found];
}

uint64_t SessionTable::deliver(std::shared_ptr<TickEncodings> tick, std::span<const Object> added,
                               std::span<const Object> changed, std::span<const uint32_t> removed) {
  uint64_t event_number = 0;
  std::vector<std::shared_ptr<ClientSession>> sessions;
  std::vector<StalledSession> stalled;
  {
    std::lock_guard lock(mutex_);
    std::vector<v1::SessionEvent> events;
    for (const Object& object : added) {
      objects_.push_back(with_proposal(object));
      *events.emplace_back().mutable_object_added() = *objects_.back();
    }
    for (const Object& object : changed) {
      const auto known = std::find_if(objects_.begin(), objects_.end(), [&](const Object& one) {
        return one->object_id() == object->object_id();
      });
      if (known == objects_.end()) continue;  // removed meanwhile
      *known = with_proposal(object);
      *events.emplace_back().mutable_object_changed() = **known;
    }
    for (uint32_t id : removed) {
      std::erase_if(objects_, [&](const Object& object) { return object->object_id() == id; });
      events.emplace_back().mutable_object_removed()->set_object_id(id);
    }
    if (!events.empty()) reaches_ = reaches_of(objects_);
    tick_ = tick->tick();
    event_number = event_number_ += events.size();
    tick->reaches = reaches_;
    for (const auto& [id, session] : sessions_) sessions.push_back(session);
    broadcast(events, stalled);
  }
  for (const auto& session : sessions) {
    session->offer(tick);
    if (const auto writer = session->writer()) writer->wake();
  }
  abort_streams(stalled);
  return event_number;
}

void SessionTable::broadcast(std::span<const v1::SessionEvent> events, std::vector<StalledSession>& stalled) {
  for (const auto& [id, session] : sessions_) {
    for (const v1::SessionEvent& event : events) {
      if (!session->add_event(event)) {
        stalled.push_back({session, session->stream()});
        break;
      }
    }
  }
}

void SessionTable::abort_streams(std::span<const StalledSession> stalled) {
  for (const auto& [session, stream] : stalled) {
    if (stream.writer) stream.writer->abort();
    session->give_up(stream.number);  // the client receives all objects when it joins again
  }
}

SessionTable::Object SessionTable::with_proposal(Object object) const {
  const auto proposal = proposals_.find(object->name());
  if (proposal == proposals_.end() || object->environment()) return object;
  auto described = std::make_shared<v1::ObjectDescription>(*object);
  *described->mutable_proposal() = proposal->second.physics();
  const std::string& why = proposal->second.analysis().review();
  if (!why.empty()) described->add_warnings(kNeedsReview + why);
  return described;
}

void SessionTable::propose(const std::string& object, const v1::PhysicsFile* proposal) {
  std::vector<StalledSession> stalled;
  {
    std::lock_guard lock(mutex_);
    proposal ? void(proposals_[object] = *proposal) : void(proposals_.erase(object));
    std::vector<v1::SessionEvent> events;
    for (Object& one : objects_) {
      if (one->name() != object || one->environment()) continue;
      auto described = std::make_shared<v1::ObjectDescription>(*one);
      described->clear_proposal();
      auto& warnings = *described->mutable_warnings();
      const auto says_why = [](const std::string& warning) { return warning.starts_with(kNeedsReview); };
      warnings.erase(std::remove_if(warnings.begin(), warnings.end(), says_why), warnings.end());
      one = with_proposal(std::move(described));
      *events.emplace_back().mutable_object_changed() = *one;
    }
    event_number_ += events.size();
    broadcast(events, stalled);
  }
  for (const auto& session : sessions_now()) {
    if (const auto writer = session->writer()) writer->wake();
  }
  abort_streams(stalled);
}

bool SessionTable::has_clients_for(v1::JoinRequest::Encoding encoding) const {
  std::lock_guard lock(mutex_);
  return std::any_of(sessions_.begin(), sessions_.end(), [&](const auto& one) {
    return one.second->encoding() == encoding && one.second->state() == ClientSession::State::Streaming;
  });
}

void SessionTable::deliver_kernels(std::shared_ptr<const TickEncodings> tick,
                                   v1::JoinRequest::Encoding encoding) {
  for (const auto& session : sessions_now()) {
    if (session->encoding() != encoding) continue;
    session->offer(tick, encoding);
    if (const auto writer = session->writer()) writer->wake();
  }
}

Result<SessionTable::Described> SessionTable::described(std::string_view resumed_id) const {
  std::lock_guard lock(mutex_);
  if (!open_ && !(next_ && sessions_.contains(resumed_id)))
    return Error{ErrorCode::Unavailable, closed_reason_};
  return Described{scene_, rate_hz_, event_number_, objects_};
}

void SessionTable::sweep(int64_t now) {
  std::vector<std::shared_ptr<SessionWriter>> stuck, overdue;
  bool check_authorizations = false;
  {
    std::lock_guard lock(mutex_);
    check_authorizations = now - authorizations_checked_ns_ >= kAuthorizationCheckInterval_ns;
    if (check_authorizations) authorizations_checked_ns_ = now;
    std::erase_if(ending_, [&](const Ending& one) {
      if (now - one.since_ns < kEndTimeout_ns) return one.writer.expired();
      if (auto writer = one.writer.lock()) stuck.push_back(std::move(writer));
      return true;
    });
    for (; !begun_.empty() && now - begun_.front().begun_ns >= kSilenceTimeout_ns; begun_.pop_front()) {
      if (auto writer = begun_.front().writer.lock()) overdue.push_back(std::move(writer));
    }
  }
  for (const auto& writer : overdue) writer->end_without_session();
  for (const auto& writer : stuck) writer->abort();
  if (check_authorizations) end_unauthorised();
  for (const auto& session : sessions_now()) {
    const ClientSession::State state = session->state();
    const int64_t silent_ns = now - session->last_message_ns.load();
    const int64_t patience_ns = state == ClientSession::State::Streaming ? kSilenceTimeout_ns
                                : state == ClientSession::State::Parked  ? kParkedTimeout_ns
                                                                         : kJoinTimeout_ns;
    const auto [writer, stream] = session->stream();
    if (silent_ns < patience_ns) {
      if (writer) writer->send_keepalive(now);
      continue;
    }
    if (state == ClientSession::State::Streaming) {
      log_info("session %.8s: silent for %.1f s; stream ended, session parked", session->id.c_str(),
               seconds_from_ns(silent_ns));
      // Abort before parking: otherwise a client that hangs up in between gets status OK.
      if (writer) writer->abort();
      session->give_up(stream);
    } else {
      {
        std::lock_guard lock(mutex_);  // also held while a client rejoins
        if (session->state() != state || now - session->last_message_ns.load() < patience_ns) continue;
        remove(*session, lock);
      }
      log_info("session %.8s: silent for %.1f s; session dropped", session->id.c_str(),
               seconds_from_ns(silent_ns));
    }
  }
}

SessionTable::Object SessionTable::object(std::string_view name) const {
  std::lock_guard lock(mutex_);
  const auto found = std::find_if(objects_.begin(), objects_.end(),
                                  [&](const Object& object) { return object->name() == name; });
  return found == objects_.end() ? nullptr : *found;
}

std::vector<std::string> SessionTable::object_names() const {
  std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const Object& object : objects_) names.push_back(object->name());
  return names;
}

void SessionTable::on_input(const ClientSession& session, std::span<const InputSample> samples) {
  // The scope of hand input is checked here; that of calls in access/call_authoriser.cpp. The lock is held
  // during the call: input after on_session_closed() would create state that is never removed.
  std::lock_guard lock(mutex_);
  if (inputs_ != nullptr && session.who.authorization.allows(v1::INTERACT) && sessions_.contains(session.id))
    inputs_->on_input(session.number, samples);
}

SessionTable::Status SessionTable::status() const {
  std::lock_guard lock(mutex_);
  size_t streaming = 0;
  for (const auto& [id, session] : sessions_)
    streaming += session->state() == ClientSession::State::Streaming ? 1 : 0;
  return {scene_, rate_hz_, tick_, objects_.size(), sessions_.size(), streaming, open_};
}

SessionTable::Totals SessionTable::totals() const {
  std::lock_guard lock(mutex_);
  return totals_;
}

std::set<std::string> SessionTable::asset_hashes() const {
  std::lock_guard lock(mutex_);
  std::set<std::string> hashes;
  for (const Object& object : objects_) {
    hashes.insert(object->asset_hash());
    if (!object->broken_asset_hash().empty()) hashes.insert(object->broken_asset_hash());
  }
  return hashes;
}

std::vector<std::shared_ptr<ClientSession>> SessionTable::sessions_now() const {
  std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<ClientSession>> sessions;
  for (const auto& [id, session] : sessions_) sessions.push_back(session);
  return sessions;
}

}  // namespace livegs
