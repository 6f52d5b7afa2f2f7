// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/frame_publisher.h"

#include <pthread.h>

#include <chrono>

#include "core/clock.h"
#include "scene/fragile_object.h"
#include "session/describe_object.h"

namespace livegs {
namespace {

// How often silent sessions are looked for when no tick comes.
constexpr std::chrono::milliseconds kSweepInterval{100};

}  // namespace

FramePublisher::FramePublisher(SessionTable& table, AssetStore& assets) : table_(table), assets_(assets) {
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "publisher");
    run();
  });
}

FramePublisher::~FramePublisher() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void FramePublisher::publish(SteppedTick tick) {
  {
    std::lock_guard lock(mutex_);
    if (waiting_) {
      // Ids are never used twice, so all that came, then all that changed, then all that went is the order of any number
      // of ticks.
      ++skipped_;
      tick.added.insert(tick.added.begin(), waiting_->added.begin(), waiting_->added.end());
      tick.changed.insert(tick.changed.begin(), waiting_->changed.begin(), waiting_->changed.end());
      tick.removed.insert(tick.removed.begin(), waiting_->removed.begin(), waiting_->removed.end());
    }
    waiting_ = std::move(tick);
  }
  changed_.notify_one();
}

void FramePublisher::run() {
  for (;;) {
    std::optional<SteppedTick> tick;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kSweepInterval, [&] { return stopping_ || waiting_; });
      if (stopping_) return;
      tick = std::move(waiting_);
      waiting_.reset();
    }
    if (tick) deliver(*tick);
    table_.sweep(now_ns());
  }
}

SessionTable::Object FramePublisher::describe(const SceneObject& object) {
  return std::make_shared<const v1::ObjectDescription>(describe_object(object, assets_));
}

void FramePublisher::encode_ahead(const SceneObject& object) {
  auto done = std::async(std::launch::async, [this, asset = object.broken->asset] { (void)assets_.add(asset); });
  encodings_.push_back({object, std::move(done)});
}

std::vector<SessionTable::Object> FramePublisher::encoded_ahead() {
  std::vector<SessionTable::Object> changed;
  std::erase_if(encodings_, [&](Encoding& one) {
    if (one.done.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    changed.push_back(describe(one.object));
    return true;
  });
  return changed;
}

void FramePublisher::deliver(const SteppedTick& tick) {
  std::vector<SessionTable::Object> added;
  for (const SceneObject& object : tick.added) {
    added.push_back(describe(object));
  }
  std::vector<SessionTable::Object> changed = encoded_ahead();
  for (const SceneObject& object : tick.changed) {
    // What has just been cut is told of when its other kernels are encoded; by then it may have broken.
    std::erase_if(encodings_, [&](const Encoding& one) { return one.object.id == object.id; });
    if (object.broken && object.rest.revision == 0 && !assets_.has(object.broken->asset)) {
      encode_ahead(object);
    } else {
      changed.push_back(describe(object));
    }
  }
  auto published = std::make_shared<PublishedTick>(tick.drivers, record_);
  published->stepped_ns = tick.stepped_ns;
  published->step_ms = tick.step_ms;
  published->run = tick.run;
  published->hands = tick.hands;
  {
    std::lock_guard lock(mutex_);
    ++frames_;
  }
  const uint64_t event_number = table_.deliver(published, added, changed, tick.removed);
  kernels_.publish(std::move(published), tick.added, tick.changed, tick.removed);
  if (fan_out_ && fan_out_->heard())
    fan_out_->publish({table_.instance(), event_number, tick.stepped_ns, tick.drivers});
}

PublisherSummary FramePublisher::summary() const {
  const EncodingRecord::Summary encoded = record_->summary();
  std::lock_guard lock(mutex_);
  return {frames_, skipped_, encoded.frame_bytes_p50, encoded.frame_bytes_p99, encoded.encode_ms_p50, encoded.encode_ms_p99,
          encoded.encoded, encoded.frame_bytes_total, encoded.encode_ms_total};
}

}  // namespace livegs
