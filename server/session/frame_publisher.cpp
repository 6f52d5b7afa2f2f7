// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/frame_publisher.h"

#include <pthread.h>

#include <algorithm>
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
    if (tick) deliver(*std::move(tick));
    table_.sweep(now_ns());
  }
}

SessionTable::Object FramePublisher::describe(const SceneObject& object) {
  return std::make_shared<const v1::ObjectDescription>(describe_object(object, assets_));
}

void FramePublisher::encode(const std::shared_ptr<const GaussianAsset>& asset) {
  if (assets_.has(asset) || encodings_.contains(asset)) return;
  encodings_.emplace(asset, std::async(std::launch::async, [this, asset] { (void)assets_.add(asset); }));
}

void FramePublisher::hold(const SceneObject& object, bool known) {
  Held& held = held_[object.id];
  held.object = object;
  held.known = known;
  encode(object.asset);
  if (!known || !last_) return;
  const auto& before = last_->drivers().objects;
  const auto shown = std::find_if(before.begin(), before.end(), [&](const ObjectDrivers& one) { return one.object_id == object.id; });
  if (shown != before.end()) held.shown = *shown;
}

FramePublisher::Events FramePublisher::take_events(const SteppedTick& tick) {
  // A future that is dropped before it is ready is waited for.
  std::erase_if(encodings_, [](const auto& one) { return one.second.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
  Events events;
  for (const SceneObject& object : tick.added) {
    if (assets_.has(object.asset))
      events.added.push_back(object);
    else
      hold(object, false);
  }
  for (const SceneObject& object : tick.changed) {
    if (const auto held = held_.find(object.id); held != held_.end()) {
      held->second.object = object;
      encode(object.asset);
      continue;
    }
    // What has just been cut is told of when its other kernels are encoded; by then it may have broken.
    const bool cut = object.broken && object.rest.revision == 0 && !assets_.has(object.broken->asset);
    const bool waits = cut && !cut_.contains(object.id);
    if (cut) {
      encode(object.broken->asset);
      cut_.insert_or_assign(object.id, object);
    } else {
      cut_.erase(object.id);
    }
    if (!assets_.has(object.asset))
      hold(object, true);
    else if (!waits)
      events.changed.push_back(object);
  }
  for (const uint32_t id : tick.removed) {
    cut_.erase(id);
    const auto held = held_.find(id);
    const bool known = held == held_.end() || held->second.known;
    if (held != held_.end()) held_.erase(held);
    if (known) events.removed.push_back(id);
  }
  std::erase_if(held_, [&](const auto& one) {
    const Held& held = one.second;
    if (!assets_.has(held.object.asset)) return false;
    (held.known ? events.changed : events.added).push_back(held.object);
    return true;
  });
  std::erase_if(cut_, [&](const auto& one) {
    if (!assets_.has(one.second.broken->asset)) return false;
    events.changed.push_back(one.second);
    return true;
  });
  return events;
}

void FramePublisher::show_held(DriverFrame& drivers) const {
  if (held_.empty()) return;
  std::erase_if(drivers.objects, [&](ObjectDrivers& one) {
    const auto held = held_.find(one.object_id);
    if (held == held_.end()) return false;
    if (held->second.shown) one = *held->second.shown;
    return !held->second.shown;
  });
}

void FramePublisher::deliver(SteppedTick tick) {
  const Events events = take_events(tick);
  show_held(tick.drivers);
  std::vector<SessionTable::Object> added, changed;
  for (const SceneObject& object : events.added) added.push_back(describe(object));
  for (const SceneObject& object : events.changed) changed.push_back(describe(object));
  auto published = std::make_shared<PublishedTick>(std::move(tick.drivers), record_);
  published->stepped_ns = tick.stepped_ns;
  published->step_ms = tick.step_ms;
  published->run = tick.run;
  published->hands = std::move(tick.hands);
  last_ = published;
  {
    std::lock_guard lock(mutex_);
    ++frames_;
  }
  const uint64_t event_number = table_.deliver(published, added, changed, events.removed);
  kernels_.publish(published, events.added, events.changed, events.removed);
  if (fan_out_ && fan_out_->heard())
    fan_out_->publish({table_.instance(), event_number, tick.stepped_ns, published->drivers()});
}

PublisherSummary FramePublisher::summary() const {
  const EncodingRecord::Summary encoded = record_->summary();
  std::lock_guard lock(mutex_);
  return {frames_, skipped_, encoded.frame_bytes_p50, encoded.frame_bytes_p99, encoded.encode_ms_p50, encoded.encode_ms_p99,
          encoded.encoded, encoded.frame_bytes_total, encoded.encode_ms_total};
}

}  // namespace livegs
