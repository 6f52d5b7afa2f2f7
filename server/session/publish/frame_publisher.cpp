// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/publish/frame_publisher.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "core/clock.h"
#include "scene/build/fragile_object.h"
#include "session/assets/describe_object.h"

namespace livegs {
namespace {

// Interval of the session sweep when there are no ticks.
constexpr std::chrono::milliseconds kSweepInterval{100};
// Interval of the sweep of unused assets.
constexpr int64_t kAssetSweepInterval_ns = 1'000'000'000;

template <class Happened>
void go_before(std::vector<Happened>& older, std::vector<Happened>& newer) {
  older.insert(older.end(), std::make_move_iterator(newer.begin()), std::make_move_iterator(newer.end()));
  newer = std::move(older);
}

// Merges two ticks. Ids are never reused, so added, then changed, then removed is a valid order for any
// number of ticks.
void go_before(TickResult& older, TickResult& newer) {
  go_before(older.added, newer.added);
  go_before(older.changed, newer.changed);
  go_before(older.removed, newer.removed);
}

// Replaces pending objects by the state that clients have, or omits them.
void show_held(DriverFrame& drivers, const auto& held_objects) {
  if (held_objects.empty()) return;
  std::erase_if(drivers.objects, [&](ObjectDrivers& one) {
    const auto held = held_objects.find(one.object_id);
    if (held == held_objects.end()) return false;
    if (held->second.shown) one = *held->second.shown;
    return !held->second.shown;
  });
}

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

void FramePublisher::begin_with(std::span<const SceneObject* const> objects) {
  for (const SceneObject* object : objects) {
    if (object->environment) room_ = object->id;
  }
  kernels_.begin_with(objects);
}

void FramePublisher::publish(TickResult&& tick) {
  {
    std::lock_guard lock(mutex_);
    if (waiting_) {
      go_before(*waiting_, tick);
      ++skipped_;
    }
    waiting_ = std::move(tick);
  }
  changed_.notify_one();
}

void FramePublisher::run() {
  for (;;) {
    std::optional<TickResult> tick;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kSweepInterval, [&] { return stopping_ || waiting_; });
      if (stopping_) return;
      tick = std::move(waiting_);
      waiting_.reset();
    }
    if (tick) take(*std::move(tick));
    const int64_t now = now_ns();
    table_.sweep(now);
    if (now - dropped_ns_ < kAssetSweepInterval_ns) continue;
    dropped_ns_ = now;
    assets_.drop_unused(table_.asset_hashes(), now);
  }
}

SessionTable::Object FramePublisher::describe(const SceneObject& object) {
  return std::make_shared<const v1::ObjectDescription>(describe_object(object, assets_));
}

void FramePublisher::encode(const Asset& asset, const Asset& base, bool stands_still) {
  if (assets_.has(asset) || asset == encoded_) return;
  const auto waiting = std::find_if(to_encode_.begin(), to_encode_.end(),
                                    [&](const ToEncode& one) { return one.asset == asset; });
  if (waiting != to_encode_.end() && !stands_still) return;
  if (waiting != to_encode_.end()) to_encode_.erase(waiting);
  // Objects that are waiting to be shown have priority over objects that may break later.
  to_encode_.insert(stands_still ? to_encode_.begin() : to_encode_.end(), {asset, base});
}

// Does not block: encodes one asset at a time, the others queue.
void FramePublisher::encode_next() {
  if (encoding_.valid()) {
    if (encoding_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    encoding_.get();
    std::erase_if(to_encode_, [&](const ToEncode& one) { return one.asset == encoded_; });
    encoded_.reset();
  }
  // Drops assets that were encoded meanwhile or are no longer used.
  std::erase_if(to_encode_,
                [&](const ToEncode& one) { return one.asset.use_count() == 1 || assets_.has(one.asset); });
  if (to_encode_.empty()) return;
  encoded_ = to_encode_.front().asset;
  encoding_ = std::async(std::launch::async,
                         [this, one = to_encode_.front()] { (void)assets_.add(one.asset, one.base); });
}

std::optional<ObjectDrivers> FramePublisher::last_shown(uint32_t object_id) const {
  if (!last_) return std::nullopt;
  const auto& before = last_->drivers().objects;
  const auto shown = std::find_if(before.begin(), before.end(),
                                  [&](const ObjectDrivers& one) { return one.object_id == object_id; });
  return shown == before.end() ? std::nullopt : std::optional(*shown);
}

void FramePublisher::hold(const SceneObject& object, bool known) {
  PendingObject& held = held_[object.id];
  held.object = object;
  held.known = known;
  encode(object.asset, assets_.described(object.name), true);
  if (known) held.shown = last_shown(object.id);
}

FramePublisher::Events FramePublisher::take_events(const TickResult& tick) {
  encode_next();
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
      encode(object.asset, assets_.described(object.name), true);
      continue;
    }
    // A freshly cut object is announced when the asset of its fragments is encoded. It may have fractured by
    // then.
    const bool cut = object.broken && object.rest.revision == 0 && !assets_.has(object.broken->asset);
    const bool waits = cut && !cut_.contains(object.id);
    if (cut) {
      encode(object.broken->asset, object.asset, false);
      cut_.insert_or_assign(object.id, object);
    } else {
      cut_.erase(object.id);
    }
    if (!assets_.has(object.asset))
      hold(object, true);
    else if (!waits)
      events.changed.push_back(object);
  }
  std::vector<uint32_t> known_removed;
  for (const uint32_t id : tick.removed) {
    cut_.erase(id);
    const auto held = held_.find(id);
    if (held == held_.end() || held->second.known) known_removed.push_back(id);
    if (held != held_.end()) held_.erase(held);
  }
  const auto room_waits = [&] {
    return std::any_of(held_.begin(), held_.end(),
                       [](const auto& one) { return one.second.object.environment; });
  };
  for (const uint32_t id : known_removed) {
    if (id == room_ && room_waits()) kept_room_ = last_shown(id);
    if (id != room_ || !kept_room_) events.removed.push_back(id);
  }
  std::erase_if(held_, [&](const auto& one) {
    const PendingObject& held = one.second;
    if (!assets_.has(held.object.asset)) return false;
    (held.known ? events.changed : events.added).push_back(held.object);
    return true;
  });
  std::erase_if(cut_, [&](const auto& one) {
    if (!assets_.has(one.second.broken->asset)) return false;
    events.changed.push_back(one.second);
    return true;
  });
  if (kept_room_ && !room_waits()) {
    events.removed.push_back(kept_room_->object_id);
    kept_room_.reset();
  }
  for (const SceneObject& object : events.added) {
    if (object.environment) room_ = object.id;
  }
  encode_next();
  return events;
}

void FramePublisher::take(TickResult tick) {
  const Events events = take_events(tick);
  show_held(tick.drivers, held_);
  if (kept_room_) tick.drivers.objects.push_back(*kept_room_);
  std::vector<SessionTable::Object> added, changed;
  for (const SceneObject& object : events.added) added.push_back(describe(object));
  for (const SceneObject& object : events.changed) changed.push_back(describe(object));
  auto published = std::make_shared<TickEncodings>(std::move(tick.drivers), record_);
  published->stepped_ns = tick.stepped_ns;
  published->step_ms = tick.step_ms;
  published->run = tick.run;
  published->hands = std::move(tick.hands);
  kernels_.take(events.added, events.changed, events.removed);
  const uint64_t event_number = table_.deliver(published, added, changed, events.removed);
  last_ = published;
  {
    std::lock_guard lock(mutex_);
    ++frames_;
  }
  kernels_.publish(published);
  if (zmq_publisher_ && zmq_publisher_->has_subscribers())
    zmq_publisher_->publish({table_.instance(), event_number, tick.stepped_ns, published->drivers()});
}

PublisherSummary FramePublisher::summary() const {
  const EncodingRecord::Summary encoded = record_->summary();
  std::lock_guard lock(mutex_);
  return {frames_,
          skipped_,
          encoded.frame_bytes_p50,
          encoded.frame_bytes_p99,
          encoded.encode_ms_p50,
          encoded.encode_ms_p99,
          encoded.encoded,
          encoded.frame_bytes_total,
          encoded.encode_ms_total};
}

}  // namespace livegs
