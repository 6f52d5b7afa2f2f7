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
  uint32_t kernel_count = 0;
  double mass_kg = 0;
  v1::PhysicalParameters physics;
  std::optional<v1::ElasticAccuracy> elastic;  // of an elastic object
  // The asset it will have once it breaks, to be fetched before; empty when there is none.
  std::string broken_asset_hash;
  uint64_t broken_asset_bytes = 0;
  std::optional<v1::Fragility> fragility;  // of a fragile object
  std::vector<std::string> warnings;
  std::optional<v1::PhysicalParameters> proposal;  // a model's answer that waits for a person
};

struct JoinedScene {
  std::string session_id;
  double rate_hz = 0;         // ticks a second
  double stream_rate_hz = 0;  // frames a second that this client gets of them
  uint64_t tick = 0;
  double ball_speed_m_s = 0;
  std::vector<StreamedObject> objects;  // the environment first, if there is one
};

// What a hand of this client holds on the server.
struct HeldByHand {
  uint32_t hand = 0;  // 0 left, 1 right
  uint32_t object_id = 0;
  Eigen::Vector3f point_m, force_n;
  bool grabbed = false;              // in the hand, not on the ray
  float contact_impulse_n_s = 0.0f;  // that contacts gave the object in this tick, for haptics
};

// A driver frame as it came.
struct ReceivedFrame {
  uint64_t tick = 0;
  std::shared_ptr<const DriverFrame> drivers;  // never null
  size_t bytes = 0;                            // that it took on the wire
  // The moments of its way, the server's clock: its step was done, this client's turn came, it was encoded
  // and handed on.
  int64_t stepped_ns = 0;
  int64_t encode_begun_ns = 0;
  int64_t sent_ns = 0;
  // This machine's clock: it came, and it was decoded.
  int64_t received_ns = 0;
  int64_t decoded_ns = 0;
  // The server's clock minus this one's, and how far off that may be. Nothing before an answer to a message
  // of ours.
  std::optional<ClockOffset::Estimate> clock;
  double step_ms = 0;
  uint64_t input_sequence = 0;
  std::vector<HeldByHand> hands;
  v1::RunState run;  // what the simulation did in this tick
};

// A session that goes on after its stream broke.
struct ResumedSession {
  // False: the server was started anew. Ticks begin again, and an id may be another object than before; those
  // that are not as they were are added or removed before the next frame.
  bool same_server = true;
  double outage_s = 0;  // since something last came
};

// What a stream brings, one call at a time, in order: an object is added before the first frame it moves
// in. Frames are acknowledged when on_frame returns, so it should be quick.
class StreamSink {
 public:
  virtual ~StreamSink() = default;
  // Nothing comes any more, for this reason; it is tried again until on_resumed(), or the end of the session.
  virtual void on_lost(const std::string& reason) = 0;
  virtual void on_resumed(const ResumedSession& resumed) = 0;
  virtual void on_frame(ReceivedFrame frame) = 0;
  // An id that is there already is replaced.
  virtual void on_object_added(StreamedObject object) = 0;
  // What the server now says of an object: a new asset and rest body when it broke. Frames of the revision
  // before may still follow.
  virtual void on_object_changed(StreamedObject object) = 0;
  virtual void on_object_removed(uint32_t object_id) = 0;
  virtual void on_draining(const std::string& reason) = 0;
};

}  // namespace livegs
