// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "livegs/v1/session.pb.h"
#include "skin/driver_frame.h"
#include "skin/rest_body.h"
#include "stream/time/clock_offset.h"

namespace livegs {

// One object of the scene, as the server describes it.
struct StreamedObject {
  uint32_t id = 0;
  std::string name;
  std::string asset_hash;
  uint64_t asset_bytes = 0;
  RestBody rest;
  bool environment = false;
  bool hidden = false;  // not drawn
  std::string label;    // given by an author; may be empty
  double lift_m = 0;    // of the body's frame above the object's pose, along the object's +y
  uint32_t kernel_count = 0;
  double mass_kg = 0;
  v1::PhysicalParameters physics;
  std::optional<v1::ElasticAccuracy> elastic;  // of an elastic object
  // Asset after a fracture, fetched in advance; empty if there is none.
  std::string broken_asset_hash;
  uint64_t broken_asset_bytes = 0;
  std::optional<v1::Fragility> fragility;  // of a fragile object
  std::vector<std::string> warnings;
  std::optional<v1::PhysicalParameters> proposal;  // values proposed by a language model, not yet accepted
};

struct JoinedScene {
  std::string session_id;
  double rate_hz = 0;         // ticks per second
  double stream_rate_hz = 0;  // frames per second sent to this client
  uint64_t tick = 0;
  double ball_speed_m_s = 0;
  std::vector<StreamedObject> objects;  // the environment first, if there is one
};

// An object that a hand of this client holds on the server.
struct HeldByHand {
  uint32_t hand = 0;  // 0 left, 1 right
  uint32_t object_id = 0;
  Eigen::Vector3f point_m, force_n;
  bool grabbed = false;              // true: grabbed; false: pulled by the ray
  float contact_impulse_n_s = 0.0f;  // impulse from contacts in this tick, for haptics
};

// A driver frame as received.
struct ReceivedFrame {
  uint64_t tick = 0;
  std::shared_ptr<const DriverFrame> drivers;  // never null
  size_t bytes = 0;                            // size on the wire
  // Server clock: end of the step, start of the encoding for this client, time of sending.
  int64_t stepped_ns = 0;
  int64_t encode_begun_ns = 0;
  int64_t sent_ns = 0;
  // Client clock: the frame was received and decoded.
  int64_t received_ns = 0;
  int64_t decoded_ns = 0;
  // Server clock minus client clock, with its uncertainty. Nothing before the first reply to a client
  // message.
  std::optional<ClockOffset::Estimate> clock;
  double step_ms = 0;           // wall time of the step on the server
  uint64_t input_sequence = 0;  // newest input of this client applied in this tick
  std::vector<HeldByHand> hands;
  v1::RunState run;  // state of the simulation in this tick
};

// A session that continues after its stream broke.
struct ResumedSession {
  // False: the server was restarted. Ticks start again and ids may be reused; objects that differ are
  // reported as added or removed before the next frame.
  bool same_server = true;
  double outage_s = 0;  // since the last message
};

// Receives the contents of a stream, in order and one call at a time, on threads of the client: the reader of
// the stream, and between two streams the thread that reconnects. An object is added before the first frame
// that moves it. Frames are acknowledged when on_frame returns, so it must be fast.
class StreamSink {
 public:
  virtual ~StreamSink() = default;
  // The stream broke. Reconnecting continues until on_resumed() or the end of the session.
  virtual void on_lost(const std::string& reason) = 0;
  virtual void on_resumed(const ResumedSession& resumed) = 0;
  virtual void on_frame(ReceivedFrame frame) = 0;
  // An existing object with the same id is replaced.
  virtual void on_object_added(StreamedObject object) = 0;
  // An object has a new description, for example a new asset and rest body after a fracture. Frames of the
  // previous revision may still follow.
  virtual void on_object_changed(StreamedObject object) = 0;
  virtual void on_object_removed(uint32_t object_id) = 0;
  // The server is shutting down; `reason` is text for the user.
  virtual void on_draining(const std::string& reason) = 0;
  // The server is shutting down, and the session continues at another one. on_lost() and on_resumed() follow.
  virtual void on_moving(const std::string& /*reason*/, const std::string& /*address*/) {}
};

}  // namespace livegs
