// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <future>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "session/asset_store.h"
#include "session/frame_fan_out.h"
#include "session/kernel_publisher.h"
#include "session/published_tick.h"
#include "session/session_table.h"

namespace livegs {

struct PublisherSummary {
  uint64_t frames = 0;
  uint64_t skipped = 0;  // ticks whose frame was replaced before it was encoded; their events were kept
  double frame_bytes_p50 = 0, frame_bytes_p99 = 0;
  double encode_ms_p50 = 0, encode_ms_p99 = 0;
  uint64_t encoded = 0;  // frames, one for each baseline that clients had
  double frame_bytes_total = 0, encode_ms_total = 0;
};

// Between the simulation and the sessions, on a thread of its own: hands each tick to every session, so that neither encoding nor a hundred socket writes lengthen a tick. When it falls behind,
// the newest tick wins. It also sweeps out sessions that went silent.
class FramePublisher final : public TickSink {
 public:
  FramePublisher(SessionTable& table, AssetStore& assets);
  ~FramePublisher() override;

  // From now on every tick goes out there too; it outlives the publisher. Before the first tick.
  void publish_to(FrameFanOut& fan_out) { fan_out_ = &fan_out; }

  // What there is before the first tick.
  void begin_with(std::span<const SceneObject* const> objects) { kernels_.begin_with(objects); }

  void publish(SteppedTick tick) override;
  PublisherSummary summary() const;

 private:
  void run();
  void deliver(const SteppedTick& tick);
  SessionTable::Object describe(const SceneObject& object);
  // Encodes, on a thread of its own, what an object will be drawn with once it breaks; clients are told when it is done.
  void encode_ahead(const SceneObject& object);
  std::vector<SessionTable::Object> encoded_ahead();

  SessionTable& table_;
  AssetStore& assets_;
  FrameFanOut* fan_out_ = nullptr;
  struct Encoding {
    SceneObject object;
    std::future<void> done;
  };
  std::vector<Encoding> encodings_;  // the publisher's thread only
  KernelPublisher kernels_{table_};
  std::shared_ptr<EncodingRecord> record_ = std::make_shared<EncodingRecord>();

  mutable std::mutex mutex_;  // guards everything below but the thread
  std::condition_variable changed_;
  std::optional<SteppedTick> waiting_;
  bool stopping_ = false;
  uint64_t skipped_ = 0;
  uint64_t frames_ = 0;

  std::thread thread_;
};

}  // namespace livegs
