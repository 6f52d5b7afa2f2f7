// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <deque>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "session/assets/asset_store.h"
#include "session/frames/tick_encodings.h"
#include "session/publish/kernel_publisher.h"
#include "session/publish/zmq_publisher.h"
#include "session/sessions/session_table.h"

namespace livegs {

struct PublisherSummary {
  uint64_t frames = 0;
  uint64_t skipped = 0;  // ticks replaced before encoding; their events are kept
  double frame_bytes_p50 = 0, frame_bytes_p99 = 0;
  double encode_ms_p50 = 0, encode_ms_p99 = 0;
  uint64_t encoded = 0;  // encodings: one per tick and client baseline
  double frame_bytes_total = 0, encode_ms_total = 0;
};

// Delivers each tick to every session. The number of a frame is its tick, counted by SceneRun::advance.
// Delivery is on its own thread, so that encoding and socket writes do not lengthen a tick. If it falls
// behind, the newest tick wins. It also sweeps silent sessions.
//
// It does not wait for assets. A new or fractured object whose asset is not encoded yet is announced when the
// encoding is done, which takes seconds for a large asset. Until then frames contain the object as clients
// have it, or not at all. A room that is replaced stays until the next one is announced. Recordings contain
// the simulated state.
class FramePublisher final : public TickSink {
 public:
  FramePublisher(SessionTable& table, AssetStore& assets);
  ~FramePublisher() override;

  // Publishes every tick there too. `zmq_publisher` must outlive this. Call before the first tick.
  void publish_to(ZmqPublisher& zmq_publisher) { zmq_publisher_ = &zmq_publisher; }

  // Objects that exist before the first tick.
  void begin_with(std::span<const SceneObject* const> objects);

  void publish(TickResult&& tick) override;
  PublisherSummary summary() const;

 private:
  void run();
  void take(TickResult tick);
  SessionTable::Object describe(const SceneObject& object);
  using Asset = std::shared_ptr<const GaussianAsset>;
  // Queues an asset for the encoding thread unless it is encoded or queued. `base`: as in AssetStore::add().
  // `stands_still`: an object waits for it.
  void encode(const Asset& asset, const Asset& base, bool stands_still);
  void encode_next();

  struct PendingObject {
    SceneObject object;                  // current state
    bool known = false;                  // clients have an earlier state
    std::optional<ObjectDrivers> shown;  // drivers of that state
  };
  // Events for clients in a tick: new ones except those that must wait, and earlier ones that are ready.
  struct Events {
    std::vector<SceneObject> added, changed;
    std::vector<uint32_t> removed;
  };
  Events take_events(const TickResult& tick);
  void hold(const SceneObject& object, bool known);
  // Drivers of an object in the last published frame.
  std::optional<ObjectDrivers> last_shown(uint32_t object_id) const;

  SessionTable& table_;
  AssetStore& assets_;
  ZmqPublisher* zmq_publisher_ = nullptr;
  // Accessed by the publisher's thread only.
  struct ToEncode {
    Asset asset, base;
  };
  std::deque<ToEncode> to_encode_;  // queue
  Asset encoded_;                   // being encoded, or null
  std::future<void> encoding_;      // encoding of encoded_
  int64_t dropped_ns_ = 0;
  // Objects that wait for an encoded asset, by id.
  std::map<uint32_t, PendingObject> held_;  // waiting for their own asset
  std::map<uint32_t, SceneObject> cut_;     // intact, waiting for the asset of their fragments
  std::optional<uint32_t> room_;            // id of the environment that clients have
  // Its drivers, if the simulation has removed it and the next one is not announced yet.
  std::optional<ObjectDrivers> kept_room_;
  std::shared_ptr<const TickEncodings> last_;
  KernelPublisher kernels_{table_};
  std::shared_ptr<EncodingRecord> record_ = std::make_shared<EncodingRecord>();

  mutable std::mutex mutex_;  // guards everything below except the thread
  std::condition_variable changed_;
  std::optional<TickResult> waiting_;
  bool stopping_ = false;
  uint64_t skipped_ = 0;
  uint64_t frames_ = 0;

  std::thread thread_;
};

}  // namespace livegs
