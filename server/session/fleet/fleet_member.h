// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "session/fleet/agones_sdk.h"
#include "session/support/successor.h"
#include "session/support/tick_liveness.h"

namespace livegs {

// Time in which the sidecar must reply after the start. It may start later than this process, and its image
// may have to be fetched first.
inline constexpr double kSidecarTimeout_s = 30;
// Between two reports of Health. A stuck tick ends them within this time and one call, so within two seconds.
// The periodSeconds of the GameServer must be longer.
inline constexpr int64_t kHealthInterval_ns = 1'000'000'000;
// A server that was allocated and is without a person for this time shuts down.
inline constexpr double kFleetEmpty_s = 300;
// At the end, time in which people get the address of the next server. With the calls (4 s) and the end of
// the sessions (3 s) it must stay below the grace period of the pod (30 s), after which the server is killed.
inline constexpr double kNextAddressWait_s = 10;
// The counter whose count is the number of people, and whose capacity the number of places.
inline constexpr const char* kPeopleCounter = "people";
// Labels: first digits of the hash of the scene; milliseconds of the 99th percentile of a tick.
inline constexpr const char* kSceneLabel = "livegs-scene";
inline constexpr const char* kTickLabel = "livegs-tick-p99-ms";

// First 16 digits of the SHA-256 of a scene's description. Equal for equal scene files.
std::string scene_label(const v1::Scene& scene);

// The part of a server in an Agones fleet: a thread that reports the state of this server to its sidecar.
//
//   FleetMember member({.port = 9358});       looks for the sidecar
//   … build the scene, start the ticks …
//   member.open(scene_label(scene), facts);    label and counter, then Ready; Health while ticks advance
//   member.empty()                             the server should end
//   Successor next = member.leave();           Shutdown; where the clients continue
//
// Allocate follows the first person, unless the fleet allocated the server before. A server that waits in the
// fleet, not yet allocated, stays as long as the fleet keeps it.
//
// A sidecar that fails later does not end the server, since people are in it: one line is logged, calls are
// repeated, and the numbers are sent again when it replies.
class FleetMember {
 public:
  struct Options {
    int port = 0;
    double empty_s = kFleetEmpty_s;
    double sidecar_timeout_s = kSidecarTimeout_s;
    double next_address_s = kNextAddressWait_s;
  };
  explicit FleetMember(const Options& options);
  ~FleetMember();
  FleetMember(const FleetMember&) = delete;
  FleetMember& operator=(const FleetMember&) = delete;

  // The name of this GameServer. Nothing while the sidecar is awaited; Unavailable if it did not reply in
  // time. Any thread.
  std::optional<Result<std::string>> name() const;

  // Current numbers; any thread.
  struct Facts {
    uint64_t ticks = 0;  // of the simulation, as they reach clients
    size_t people = 0, places = 0;
    double tick_p99_ms = 0;
  };
  // `facts` is called on the thread of this object, and by leave(). Call once, after name().
  void open(std::string scene, std::function<Facts()> facts);

  // True from the moment the server was without a person for `empty_s` after its allocation. Any thread.
  bool empty() const;

  // Ends the reports, reads where the clients continue (the annotations) and requests Shutdown. While there
  // are people and no next address, waits for it up to `next_address_s`. Call once.
  Successor leave();

 private:
  void run(const std::stop_token& stop);
  bool find_sidecar(const std::stop_token& stop);
  // The calls that are due. Stops at the first one that must be repeated.
  Result<void> report(const Facts& facts, int64_t now_ns, const std::stop_token& stop);
  Result<void> announce(const Facts& facts, const std::stop_token& stop);
  Result<void> allocate_if_joined(const Facts& facts, const std::stop_token& stop);
  Result<void> send_scene(const std::stop_token& stop);
  Result<void> send_people(const Facts& facts, const std::stop_token& stop);
  Result<void> send_tick_time(const Facts& facts, int64_t now_ns, const std::stop_token& stop);
  void take(const GameServer& server, int64_t now_ns);
  void note_empty(const Facts& facts, int64_t now_ns);
  void note_sidecar(const Result<void>& reported);
  void await_next_address();
  // Whether `sent` must be repeated. Any other refusal is logged, and `unwanted` is set.
  static bool repeats(const Result<void>& sent, bool& unwanted);

  const Options options_;
  AgonesSdk sdk_;

  // Accessed by the thread; after leave() by its caller.
  GameServer server_;
  TickLiveness liveness_{kHealthInterval_ns};
  bool ready_ = false, allocated_ = false, sidecar_away_ = false;
  bool scene_sent_ = false, counter_unwanted_ = false, label_unwanted_ = false;
  std::optional<size_t> people_sent_;
  double tick_p99_sent_ms_ = 0;
  int64_t people_sent_ns_ = 0, tick_sent_ns_ = 0, read_ns_ = 0, empty_since_ns_ = 0;

  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable_any opened_;
  std::optional<Result<std::string>> name_;
  std::string scene_;
  std::function<Facts()> facts_;
  bool empty_ = false;

  std::jthread thread_;  // last: uses everything above
};

}  // namespace livegs
