// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/input_sample.h"
#include "recording/tick_record.h"
#include "scene/scene.h"
#include "skin/driver_frame.h"

// The seam between the simulation, which knows no client, and the service, which knows no body. Values go
// through it in both directions; neither side waits for the other.

namespace livegs {

// The server's own number for a session: never sent, never used twice.
using SessionNumber = uint64_t;

// What one hand of a session holds, for the ray and the force arrow.
struct HeldPoint {
  bool holding = false;
  uint32_t object_id = 0;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  // now, world frame
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  bool grabbed = false;  // in the hand, not on the ray
  Eigen::Vector3d torque_n_m = Eigen::Vector3d::Zero();
  double contact_impulse_n_s = 0;  // that contacts gave the object in this tick
};

struct SessionHands {
  SessionNumber session = 0;
  uint64_t input_sequence = 0;  // the newest sample applied
  std::array<HeldPoint, 2> hands;
};

// What the simulation does.
struct RunStatus {
  bool paused = false;
  bool loading = false;  // a reset is under way
  uint32_t resets = 0;
  double simulated_s = 0;  // since the scene was loaded
  std::string message;     // why the last reset failed
};

// Everything one tick left behind.
struct TickResult {
  DriverFrame drivers;
  int64_t stepped_ns = 0;  // when the step was done
  double step_ms = 0;
  RunStatus run;
  bool scene_is_new = false;       // it took the place of another: all of it is added, all of that removed
  std::vector<SceneObject> added;  // since the tick before
  std::vector<uint32_t> removed;
  std::vector<SceneObject> changed;  // broke, were cut, or had their physics set; as they are now
  std::vector<SessionHands> hands;   // ascending session
  std::vector<uint32_t>
      cuts;  // fragile objects whose pieces were done, in the order in which the step took them
};

// Takes ticks, on the simulation's thread, and returns at once.
class TickSink {
 public:
  virtual ~TickSink() = default;
  virtual void publish(TickResult&& tick) = 0;
};

// Takes what each tick took from outside and what it left behind, on the simulation's thread, and returns at
// once.
class TickRecorder {
 public:
  virtual ~TickRecorder() = default;
  virtual void record(const TickActions& actions, const TickResult& tick, const Scene& scene) = 0;
};

// Takes what clients do. Any thread, one at a time; returns at once and calls nobody who asks the session
// table.
class InputSink {
 public:
  virtual ~InputSink() = default;
  // A sign of life of a session, with the samples it brought: oldest first, each already checked, repeated
  // ones welcome (a sequence that was seen before is skipped).
  virtual void on_input(SessionNumber session, std::span<const InputSample> samples) = 0;
  // The session is gone; what it held is let go. It is not heard any more.
  virtual void on_session_closed(SessionNumber session) = 0;
};

}  // namespace livegs
