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
  uint64_t skipped = 0;  // ticks whose frame was replaced before it was encoded; their events were kept
  double frame_bytes_p50 = 0, frame_bytes_p99 = 0;
  double encode_ms_p50 = 0, encode_ms_p99 = 0;
  uint64_t encoded = 0;  // frames, one for each baseline that clients had
  double frame_bytes_total = 0, encode_ms_total = 0;
};

// Between the simulation and the sessions, on a thread of its own: hands each tick to every session, so that
// neither encoding nor a hundred socket writes lengthen a tick. When it falls behind, the newest tick wins.
// It also sweeps out sessions that went silent.
//
// It waits for nobody, and for no asset: one that has none encoded yet, because it came or broke this moment,
// is told of when that is done, seconds later if it is large. Until then frames have it as clients know it,
// at rest where it was last, or not at all; everything else goes on. What is recorded is what was simulated.
class FramePublisher final : public TickSink {
 public:
  FramePublisher(SessionTable& table, AssetStore& assets);
  ~FramePublisher() override;

  // From now on every tick goes out there too; it outlives the publisher. Before the first tick.
  void publish_to(ZmqPublisher& zmq_publisher) { zmq_publisher_ = &zmq_publisher; }

  // What there is before the first tick.
  void begin_with(std::span<const SceneObject* const> objects) { kernels_.begin_with(objects); }

  void publish(TickResult&& tick) override;
  PublisherSummary summary() const;

 private:
  void run();
  void take(TickResult tick);
  SessionTable::Object describe(const SceneObject& object);
  // On a thread of its own, one after the other, if it is not done or under way yet.
  void encode(const std::shared_ptr<const GaussianAsset>& asset, bool stands_still);
  void encode_next();

  struct PendingObject {
    SceneObject object;                  // as it is now
    bool known = false;                  // as it was before, to clients
    std::optional<ObjectDrivers> shown;  // of that
  };
  // What clients are told with a tick: what happened in it, without what has to wait, and with what waited
  // long enough.
  struct Events {
    std::vector<SceneObject> added, changed;
    std::vector<uint32_t> removed;
  };
  Events take_events(const TickResult& tick);
  void hold(const SceneObject& object, bool known);

  SessionTable& table_;
  AssetStore& assets_;
  ZmqPublisher* zmq_publisher_ = nullptr;
  // The publisher's thread only.
  std::deque<std::shared_ptr<const GaussianAsset>> to_encode_;  // in turn
  std::shared_ptr<const GaussianAsset> encoded_;                // right now, or null
  std::future<void> encoding_;                                  // of it
  int64_t dropped_ns_ = 0;
  // What waits for its kernels to be encoded, by id.
  std::map<uint32_t, PendingObject> held_;  // what is drawn with them
  std::map<uint32_t, SceneObject> cut_;     // whole; announced when the kernels of its pieces are encoded
  std::shared_ptr<const TickEncodings> last_;
  KernelPublisher kernels_{table_};
  std::shared_ptr<EncodingRecord> record_ = std::make_shared<EncodingRecord>();

  mutable std::mutex mutex_;  // guards everything below but the thread
  std::condition_variable changed_;
  std::optional<TickResult> waiting_;
  bool stopping_ = false;
  uint64_t skipped_ = 0;
  uint64_t frames_ = 0;

  std::thread thread_;
};

}  // namespace livegs
