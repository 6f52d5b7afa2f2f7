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

// The interface between the simulation, which has no notion of clients, and the service, which has no notion
// of bodies. Values are passed in both directions; neither side blocks on the other.

namespace livegs {

// The server's internal number of a session: never sent, never reused.
using SessionNumber = uint64_t;

// The point that one hand of a session holds, for the ray and the force arrow.
struct HeldPoint {
  bool holding = false;
  uint32_t object_id = 0;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  // current, world frame
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  bool grabbed = false;  // grabbed, not pulled by the ray
  Eigen::Vector3d torque_n_m = Eigen::Vector3d::Zero();
  double contact_impulse_n_s = 0;  // contact impulse on the object in this tick
};

struct SessionHands {
  SessionNumber session = 0;
  uint64_t input_sequence = 0;  // newest applied sample
  std::array<HeldPoint, 2> hands;
};

// State of the simulation.
struct RunStatus {
  bool paused = false;
  bool loading = false;  // a reset is in progress
  uint32_t resets = 0;
  double simulated_s = 0;      // since the current scene was loaded
  std::string message;         // reason for the last failed reset
  uint64_t edit_revision = 0;  // of the document that authors edit; 0: none
  bool waiting = false;        // paused before the first tick, until a client starts it
};

// Result of one tick. `drivers` carries the number of the tick, which SceneRun counts; it is the sequence
// number of the frame on the wire.
struct TickResult {
  DriverFrame drivers;
  int64_t stepped_ns = 0;  // end of the step
  double step_ms = 0;
  RunStatus run;
  bool scene_is_new = false;       // scene replaced: `added` has all new objects, `removed` all old ones
  std::vector<SceneObject> added;  // since the tick before
  std::vector<uint32_t> removed;
  std::vector<SceneObject> changed;  // fractured, cut or with new physics; current state
  std::vector<SessionHands> hands;   // ordered by session
  std::vector<uint32_t> cuts;        // fragile objects whose pieces became ready, in order
};

// Receives ticks on the simulation thread; returns at once.
class TickSink {
 public:
  virtual ~TickSink() = default;
  virtual void publish(TickResult&& tick) = 0;
};

// Records the inputs and the result of each tick. Called on the simulation thread; returns at once.
class TickRecorder {
 public:
  virtual ~TickRecorder() = default;
  virtual void record(const TickActions& actions, const TickResult& tick, const Scene& scene) = 0;
};

// Receives client input. Any thread, one call at a time; returns at once and must not call the session table.
class InputSink {
 public:
  virtual ~InputSink() = default;
  // Resets the input timeout of the session and queues its samples, oldest first and already validated.
  // Samples with a sequence that was already received are skipped.
  virtual void on_input(SessionNumber session, std::span<const InputSample> samples) = 0;
  // The session has ended: releases its held objects. No further input of it may follow.
  virtual void on_session_closed(SessionNumber session) = 0;
};

}  // namespace livegs
