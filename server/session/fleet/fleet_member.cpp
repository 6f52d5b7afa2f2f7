// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/fleet/fleet_member.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <thread>
#include <utility>

#include "core/clock.h"
#include "core/content_hash.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "trust/host_port.h"

namespace livegs {
namespace {

// Between two looks at the server's numbers, and after a call that failed.
constexpr std::chrono::milliseconds kReportPause{100}, kFailurePause{500};
// Between two reads of a next address that is awaited.
constexpr std::chrono::milliseconds kNextAddressPause{500};
// Between two reads of the GameServer, which the sidecar answers from memory.
constexpr int64_t kReadInterval_ns = 5'000'000'000;
// Each change of a counter or label is a write to the cluster's store, so that changes wait: of the number of
// people a second, of the time of a tick a minute and 10 %.
constexpr int64_t kPeopleInterval_ns = 1'000'000'000, kTickInterval_ns = 60'000'000'000;
constexpr double kMinTickChange = 0.1;
constexpr size_t kSceneDigits = 16;  // of 64; a label has at most 63 characters

void pause(std::chrono::milliseconds time, const std::stop_token& stop) {
  std::mutex alone;
  std::condition_variable_any stopped;
  std::unique_lock lock(alone);
  stopped.wait_for(lock, stop, time, [] { return false; });
}

}  // namespace

std::string scene_label(const v1::Scene& scene) {
  const std::string bytes = scene.SerializeAsString();  // without maps, so that equal scenes have equal bytes
  return content_hash(std::as_bytes(std::span(bytes))).substr(0, kSceneDigits);
}

FleetMember::FleetMember(const Options& options)
    : options_(options), sdk_(options.port), thread_([this](const std::stop_token& stop) { run(stop); }) {}

FleetMember::~FleetMember() = default;

std::optional<Result<std::string>> FleetMember::name() const {
  std::lock_guard lock(mutex_);
  return name_;
}

void FleetMember::open(std::string scene, std::function<Facts()> facts) {
  {
    std::lock_guard lock(mutex_);
    scene_ = std::move(scene);
    facts_ = std::move(facts);
  }
  opened_.notify_all();
}

bool FleetMember::empty() const {
  std::lock_guard lock(mutex_);
  return empty_;
}

bool FleetMember::find_sidecar(const std::stop_token& stop) {
  const int64_t end_ns = now_ns() + static_cast<int64_t>(options_.sidecar_timeout_s * 1e9);
  while (!stop.stop_requested()) {
    const auto server = sdk_.game_server(stop);
    if (server) {
      take(*server, now_ns());
      log_info("agones: this server is GameServer \"%s\"", server->name.c_str());
      std::lock_guard lock(mutex_);
      name_ = server->name;
      return true;
    }
    log_debug("%s", server.error().message.c_str());
    if (now_ns() >= end_ns) {
      std::lock_guard lock(mutex_);
      name_ = Error{
          ErrorCode::Unavailable,
          "--fleet agones: no sidecar replied at " + sdk_.url() +
              format_text(" within %.0f s; run the server in a GameServer of Agones, or without --fleet",
                          options_.sidecar_timeout_s)};
      return false;
    }
    pause(kFailurePause, stop);
  }
  return false;
}

void FleetMember::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "fleet");
  if (!find_sidecar(stop)) return;
  {
    std::unique_lock lock(mutex_);
    opened_.wait(lock, stop, [&] { return facts_ != nullptr; });
  }
  while (!stop.stop_requested()) {
    const Facts facts = facts_();
    note_empty(facts, now_ns());
    const auto reported = report(facts, now_ns(), stop);
    if (stop.stop_requested()) break;  // a cancelled call says nothing of the sidecar
    note_sidecar(reported);
    pause(reported ? kReportPause : kFailurePause, stop);
  }
}

Result<void> FleetMember::report(const Facts& facts, int64_t now, const std::stop_token& stop) {
  if (liveness_.due(facts.ticks, now)) {
    if (auto sent = sdk_.health(stop); !sent) return sent;
  }
  if (!ready_) return announce(facts, stop);
  if (auto allocated = allocate_if_joined(facts, stop); !allocated) return allocated;
  if (now - read_ns_ >= kReadInterval_ns) {
    const auto server = sdk_.game_server(stop);
    if (!server) return server.error();
    take(*server, now);
  }
  if (auto sent = send_scene(stop); !sent) return sent;
  if (auto sent = send_people(facts, stop); !sent) return sent;
  return send_tick_time(facts, now, stop);
}

// The label and the counter first, so that an allocation can select by them as soon as the server is ready.
Result<void> FleetMember::announce(const Facts& facts, const std::stop_token& stop) {
  if (auto sent = send_scene(stop); !sent) return sent;
  if (auto sent = send_people(facts, stop); !sent) return sent;
  if (auto sent = sdk_.ready(stop); !sent) return sent;
  ready_ = true;
  log_info("agones: the GameServer is ready");
  return {};
}

Result<void> FleetMember::allocate_if_joined(const Facts& facts, const std::stop_token& stop) {
  if (facts.people == 0) return {};
  if (allocated_) return {};
  const auto server = sdk_.game_server(stop);
  if (!server) return server.error();
  take(*server, now_ns());
  if (allocated_) return {};
  if (auto sent = sdk_.allocate(stop); !sent) return sent;
  allocated_ = true;
  return {};
}

Result<void> FleetMember::send_scene(const std::stop_token& stop) {
  if (label_unwanted_ || scene_sent_) return {};
  const auto sent = sdk_.set_label(kSceneLabel, scene_, stop);
  if (repeats(sent, label_unwanted_)) return sent;
  scene_sent_ = true;
  return {};
}

Result<void> FleetMember::send_people(const Facts& facts, const std::stop_token& stop) {
  const int64_t now = now_ns();
  if (counter_unwanted_ || people_sent_ == facts.people || now - people_sent_ns_ < kPeopleInterval_ns)
    return {};
  const auto sent = sdk_.set_counter(kPeopleCounter, facts.people, facts.places, stop);
  if (repeats(sent, counter_unwanted_)) return sent;
  people_sent_ = facts.people;
  people_sent_ns_ = now;
  return {};
}

Result<void> FleetMember::send_tick_time(const Facts& facts, int64_t now, const std::stop_token& stop) {
  const double change = std::abs(facts.tick_p99_ms - tick_p99_sent_ms_);
  if (label_unwanted_ || change <= kMinTickChange * tick_p99_sent_ms_ || facts.tick_p99_ms <= 0) return {};
  if (tick_sent_ns_ != 0 && now - tick_sent_ns_ < kTickInterval_ns) return {};
  const auto sent = sdk_.set_label(kTickLabel, format_text("%.2f", facts.tick_p99_ms), stop);
  if (repeats(sent, label_unwanted_)) return sent;
  tick_p99_sent_ms_ = facts.tick_p99_ms;
  tick_sent_ns_ = now;
  return {};
}

bool FleetMember::repeats(const Result<void>& sent, bool& unwanted) {
  if (sent) return false;
  if (sent.error().code == ErrorCode::Unavailable) return true;
  unwanted = true;
  log_warn("%s; not sent again", sent.error().message.c_str());
  return false;
}

void FleetMember::take(const GameServer& server, int64_t now) {
  server_ = server;
  read_ns_ = now;
  allocated_ = allocated_ || server.state == "Allocated";
}

void FleetMember::note_empty(const Facts& facts, int64_t now) {
  if (facts.people > 0 || !allocated_ || empty_since_ns_ == 0) empty_since_ns_ = now;
  if (seconds_from_ns(now - empty_since_ns_) < options_.empty_s) return;
  std::lock_guard lock(mutex_);
  empty_ = true;
}

void FleetMember::note_sidecar(const Result<void>& reported) {
  if (reported) {
    if (!std::exchange(sidecar_away_, false)) return;
    log_info("agones: the sidecar replies again");
    scene_sent_ = false;  // a restarted sidecar has lost what it had not written
    people_sent_.reset();
    tick_p99_sent_ms_ = 0;
    return;
  }
  if (std::exchange(sidecar_away_, true)) return;
  log_warn("%s; the server keeps running, and calls are repeated", reported.error().message.c_str());
}

// A drain of a node sends SIGTERM before anybody can name the next server, so that people need some time
// here. Health goes on, or the fleet would remove the server as unhealthy.
void FleetMember::await_next_address() {
  const int64_t end_ns = now_ns() + static_cast<int64_t>(options_.next_address_s * 1e9);
  for (bool first = true;; first = false) {
    if (const auto server = sdk_.game_server(); server) server_ = *server;
    if (!server_.next_address.empty() || !facts_) return;
    const Facts facts = facts_();
    if (facts.people == 0) return;
    if (now_ns() >= end_ns) {
      log_warn(
          "agones: annotation %s: is not set, so that clients do not continue elsewhere; annotate a "
          "GameServer before its drain",
          kNextAddressAnnotation);
      return;
    }
    if (first)
      log_info("agones: waiting at most %.0f s for the annotation %s", options_.next_address_s,
               kNextAddressAnnotation);
    if (liveness_.due(facts.ticks, now_ns())) (void)sdk_.health();
    std::this_thread::sleep_for(kNextAddressPause);
  }
}

Successor FleetMember::leave() {
  thread_.request_stop();
  thread_.join();
  if (server_.name.empty()) return {};  // the sidecar never replied
  await_next_address();
  if (const auto sent = sdk_.shutdown(); !sent) log_warn("%s", sent.error().message.c_str());
  if (server_.next_address.empty()) return {};
  if (auto checked = parse_host_port(server_.next_address); !checked) {
    log_warn("agones: annotation %s: %s", kNextAddressAnnotation, checked.error().message.c_str());
    return {};
  }
  return {server_.next_address, server_.next_server};
}

}  // namespace livegs
