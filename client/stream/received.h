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
};

struct JoinedScene {
  std::string session_id;
  double rate_hz = 0;
  uint64_t tick = 0;
  double ball_speed_m_s = 0;
  std::vector<StreamedObject> objects;  // the environment first, if there is one
};

// What a hand of this client holds on the server.
struct HeldByHand {
  uint32_t hand = 0;  // 0 left, 1 right
  uint32_t object_id = 0;
  Eigen::Vector3f point_m, force_n;
  bool grabbed = false;             // in the hand, not on the ray
  float contact_impulse_n_s = 0.0f; // that contacts gave the object in this tick, for haptics
};

// A driver frame as it came.
struct ReceivedFrame {
  uint64_t tick = 0;
  std::shared_ptr<const DriverFrame> drivers;  // never null
  size_t bytes = 0;                            // that it took on the wire
  int64_t received_ns =
      0;  // this machine's clock, like all below but stepped_ns and sent_ns, which are the server's
  int64_t stepped_ns = 0;
  int64_t sent_ns = 0;
  int64_t echoed_ns = 0;  // sent_ns of the newest message of ours the server had taken; 0 when none
  double step_ms = 0;
  uint64_t input_sequence = 0;
  std::vector<HeldByHand> hands;
};

// What a stream brings, on the reader's thread, in order: an object is added before the first frame it moves
// in. Frames are acknowledged when on_frame returns, so it should be quick.
class StreamSink {
 public:
  virtual ~StreamSink() = default;
  virtual void on_frame(ReceivedFrame frame) = 0;
  virtual void on_object_added(StreamedObject object) = 0;
  // What the server now says of an object: a new asset and rest body when it broke. Frames of the revision before may
  // still follow.
  virtual void on_object_changed(StreamedObject object) = 0;
  virtual void on_object_removed(uint32_t object_id) = 0;
  virtual void on_draining(const std::string& reason) = 0;
};

}  // namespace livegs
