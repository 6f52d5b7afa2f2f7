// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/publish/frame_publisher.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <iterator>
#include <utility>

#include "core/clock.h"
#include "core/log.h"
#include "scene/build/fragile_object.h"
#include "session/assets/describe_object.h"

namespace livegs {
namespace {

// How often silent sessions are looked for when no tick comes.
constexpr std::chrono::milliseconds kSweepInterval{100};
// How often assets that nobody needs are looked for.
constexpr int64_t kDropInterval_ns = 1'000'000'000;
// When an asset that could not be encoded is tried again.
constexpr int64_t kEncodeAgainAfter_ns = 1'000'000'000;
// When memory that is short is asked for again.
constexpr std::chrono::milliseconds kMemoryPause{5};

// Nothing is copied, and nothing is changed when there is no memory for both.
template <class Happened>
void go_before(std::vector<Happened>& older, std::vector<Happened>& newer) {
  if (older.empty()) return;
  older.reserve(older.size() + newer.size());
  std::move(newer.begin(), newer.end(), std::back_inserter(older));
  newer.swap(older);
  older.clear();
}

// Ids are never used twice, so all that came, then all that changed, then all that went is the order of any number of ticks.
void go_before(SteppedTick& older, SteppedTick& newer) {
  go_before(older.added, newer.added);
  go_before(older.changed, newer.changed);
  go_before(older.removed, newer.removed);
}

// Of what waits for its kernels: as clients know it, or not at all.
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

void FramePublisher::publish(SteppedTick&& tick) {
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
    std::optional<SteppedTick> tick;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kSweepInterval, [&] { return stopping_ || waiting_; });
      if (stopping_) return;
      tick = std::move(waiting_);
      waiting_.reset();
    }
    try {
      if (tick) take(*std::move(tick));
      const int64_t now = now_ns();
      table_.sweep(now);
      if (now - dropped_ns_ < kDropInterval_ns) continue;
      dropped_ns_ = now;
      assets_.drop_unused(table_.asset_hashes(), now);
    } catch (const std::exception& error) {  // memory is short now, and may not be the next time
      note_short(error.what());
    }
  }
}

void FramePublisher::take(SteppedTick tick) {
  while (left_out_) {
    try {
      go_before(*left_out_, tick);
      left_out_.reset();
    } catch (const std::exception& error) {
      note_short(error.what());
      std::unique_lock lock(mutex_);
      if (changed_.wait_for(lock, kMemoryPause, [&] { return stopping_; })) return;
    }
  }
  try {
    deliver(tick);
  } catch (const std::exception& error) {
    left_out_ = std::move(tick);
    note_short(error.what());
  }
}

void FramePublisher::note_short(const char* why) {
  if (std::exchange(told_of_shortage_, true)) return;
  log_warn("a frame is left out: %s; what happened in it is told with the next", why);
}

SessionTable::Object FramePublisher::describe(const SceneObject& object) {
  return std::make_shared<const v1::ObjectDescription>(describe_object(object, assets_));
}

void FramePublisher::encode(const std::shared_ptr<const GaussianAsset>& asset, bool stands_still) {
  if (assets_.has(asset) || asset == encoded_) return;
  const auto waiting = std::find(to_encode_.begin(), to_encode_.end(), asset);
  if (waiting != to_encode_.end() && !stands_still) return;
  if (waiting != to_encode_.end()) to_encode_.erase(waiting);
  // What is seen to stand still goes before what may break some day.
  to_encode_.insert(stands_still ? to_encode_.begin() : to_encode_.end(), asset);
}

// Never waits: while one is encoded the others stand in line. Memory or threads that are short now may not be later.
void FramePublisher::encode_next() {
  if (encoding_.valid()) {
    if (encoding_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    note_encoded(encoding_.get());
  }
  if (now_ns() < encode_after_ns_) return;
  // What another has encoded meanwhile, and what nobody draws any more.
  std::erase_if(to_encode_, [&](const auto& asset) { return asset.use_count() == 1 || assets_.has(asset); });
  if (to_encode_.empty()) return;
  encoded_ = to_encode_.front();
  try {
    encoding_ = std::async(std::launch::async, [this, asset = encoded_]() -> std::string {
      try {
        (void)assets_.add(asset);
        return {};
      } catch (const std::exception& error) {
        return error.what();
      }
    });
  } catch (const std::exception& error) {  // there is no thread for it
    note_encoded(error.what());
  }
}

void FramePublisher::note_encoded(const std::string& failed) {
  const auto done = std::find(to_encode_.begin(), to_encode_.end(), encoded_);
  encoded_.reset();
  if (failed.empty()) {
    if (done != to_encode_.end()) to_encode_.erase(done);
    return;
  }
  if (done != to_encode_.end()) std::rotate(done, done + 1, to_encode_.end());
  encode_after_ns_ = now_ns() + kEncodeAgainAfter_ns;
  if (std::exchange(told_of_failure_, true)) return;
  log_warn("an object's kernels cannot be encoded: %s; clients see it as it was; trying again each second", failed.c_str());
}

void FramePublisher::hold(const SceneObject& object, bool known, Waiting& waiting) {
  Held& held = waiting.held[object.id];
  held.object = object;
  held.known = known;
  encode(object.asset, true);
  if (!known || !last_) return;
  const auto& before = last_->drivers().objects;
  const auto shown = std::find_if(before.begin(), before.end(), [&](const ObjectDrivers& one) { return one.object_id == object.id; });
  if (shown != before.end()) held.shown = *shown;
}

FramePublisher::Events FramePublisher::take_events(const SteppedTick& tick, Waiting& waiting) {
  encode_next();
  Events events;
  for (const SceneObject& object : tick.added) {
    if (assets_.has(object.asset))
      events.added.push_back(object);
    else
      hold(object, false, waiting);
  }
  for (const SceneObject& object : tick.changed) {
    if (const auto held = waiting.held.find(object.id); held != waiting.held.end()) {
      held->second.object = object;
      encode(object.asset, true);
      continue;
    }
    // What has just been cut is told of when its other kernels are encoded; by then it may have broken.
    const bool cut = object.broken && object.rest.revision == 0 && !assets_.has(object.broken->asset);
    const bool waits = cut && !waiting.cut.contains(object.id);
    if (cut) {
      encode(object.broken->asset, false);
      waiting.cut.insert_or_assign(object.id, object);
    } else {
      waiting.cut.erase(object.id);
    }
    if (!assets_.has(object.asset))
      hold(object, true, waiting);
    else if (!waits)
      events.changed.push_back(object);
  }
  for (const uint32_t id : tick.removed) {
    waiting.cut.erase(id);
    const auto held = waiting.held.find(id);
    const bool known = held == waiting.held.end() || held->second.known;
    if (held != waiting.held.end()) waiting.held.erase(held);
    if (known) events.removed.push_back(id);
  }
  std::erase_if(waiting.held, [&](const auto& one) {
    const Held& held = one.second;
    if (!assets_.has(held.object.asset)) return false;
    (held.known ? events.changed : events.added).push_back(held.object);
    return true;
  });
  std::erase_if(waiting.cut, [&](const auto& one) {
    if (!assets_.has(one.second.broken->asset)) return false;
    events.changed.push_back(one.second);
    return true;
  });
  encode_next();
  return events;
}

void FramePublisher::deliver(SteppedTick& tick) {
  Waiting waiting = waits_;
  const Events events = take_events(tick, waiting);
  show_held(tick.drivers, waiting.held);
  std::vector<SessionTable::Object> added, changed;
  for (const SceneObject& object : events.added) added.push_back(describe(object));
  for (const SceneObject& object : events.changed) changed.push_back(describe(object));
  auto published = std::make_shared<PublishedTick>(std::move(tick.drivers), record_);
  published->stepped_ns = tick.stepped_ns;
  published->step_ms = tick.step_ms;
  published->run = tick.run;
  published->hands = std::move(tick.hands);
  kernels_.take(events.added, events.changed, events.removed);
  const uint64_t event_number = table_.deliver(published, added, changed, events.removed);
  waits_ = std::move(waiting);
  last_ = published;
  {
    std::lock_guard lock(mutex_);
    ++frames_;
  }
  kernels_.publish(published);
  try {
    if (fan_out_ && fan_out_->heard())
      fan_out_->publish({table_.instance(), event_number, tick.stepped_ns, published->drivers()});
  } catch (const std::exception& error) {  // a publication is followed by the next
    note_short(error.what());
  }
}

PublisherSummary FramePublisher::summary() const {
  const EncodingRecord::Summary encoded = record_->summary();
  std::lock_guard lock(mutex_);
  return {frames_, skipped_, encoded.frame_bytes_p50, encoded.frame_bytes_p99, encoded.encode_ms_p50, encoded.encode_ms_p99,
          encoded.encoded, encoded.frame_bytes_total, encoded.encode_ms_total};
}

}  // namespace livegs
