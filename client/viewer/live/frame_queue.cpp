// SPDX-License-Identifier: Apache-2.0
#include "viewer/live/frame_queue.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace livegs {

void FrameQueue::on_lost(const std::string& reason) {
  update([&] {
    update_.lost = reason;
    lost_ = true;
  });
}

void FrameQueue::on_resumed(const ResumedSession& resumed) {
  std::lock_guard lock(mutex_);
  if (resumed.same_server || holds_) return;
  holds_ = true;
  events_to_take_ = events_.size();
}

void FrameQueue::on_frame(ReceivedFrame frame) {
  update([&] {
    if (std::exchange(lost_, false)) {
      update_.back = true;
      update_.lost.reset();  // the outage ended before it was reported
    }
    if (std::exchange(holds_, false)) {
      update_.server_restarted = true;
      update_.frames.clear();
    }
    if (records_frames_) recorded_.push_back(frame);
    if (update_.frames.size() == kMaxFrames) update_.frames.erase(update_.frames.begin());
    update_.frames.push_back(std::move(frame));
  });
}

void FrameQueue::record_frames(bool keep) {
  std::lock_guard lock(mutex_);
  records_frames_ = keep;
}

std::vector<ReceivedFrame> FrameQueue::take_recorded() {
  std::lock_guard lock(mutex_);
  return std::exchange(recorded_, {});
}

void FrameQueue::on_object_added(StreamedObject object) {
  objects_.request(object);
  const uint32_t id = object.id;
  update([&] { events_.push_back({std::move(object), true, id}); });
}

void FrameQueue::on_object_changed(StreamedObject object) {
  objects_.request(object);
  const uint32_t id = object.id;
  update([&] { events_.push_back({std::move(object), false, id}); });
}

void FrameQueue::on_object_removed(uint32_t object_id) {
  update([&] { events_.push_back({std::nullopt, false, object_id}); });
}

void FrameQueue::on_moving(const std::string& reason, const std::string& address) {
  on_draining(reason + "; continuing at " + address);
}

void FrameQueue::on_draining(const std::string& reason) {
  update([&] { update_.shutdown_reason = reason; });
}

bool FrameQueue::Pending::ready() const {
  return !bound.valid() || bound.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

void FrameQueue::take_event(Event event, const SceneView& view) {
  Pending pending{std::move(event), {}};
  if (pending.event.object) {
    const StreamedObject& object = *pending.event.object;
    const auto binds_it = [&](const Pending& one) {
      return one.bound.valid() && one.event.id == object.id &&
             one.event.object->rest.revision == object.rest.revision;
    };
    // A description is also sent after a parameter change, such as the mass.
    const bool is_there =
        view.has(object.id, object.rest.revision) || std::any_of(pending_.begin(), pending_.end(), binds_it);
    // A room that replaces another is shown when it is whole; the other one is removed after it.
    if (pending.event.added || !is_there) pending.bound = objects_.bind(object, object.environment);
  }
  pending_.push_back(std::move(pending));
}

Result<void> FrameQueue::show(Pending pending, SceneView& view, StreamUpdate& update) {
  if (!pending.event.object) {
    objects_.remove(pending.event.id, view);
    update.removed.push_back(pending.event.id);
    return {};
  }
  if (pending.bound.valid()) {
    auto bound = pending.bound.get();
    if (!bound) return bound.error();
    objects_.show(*std::move(bound), view, pending.event.added);
  }
  hide(std::span(&*pending.event.object, 1));
  update.described.push_back(std::move(*pending.event.object));
  return {};
}

void FrameQueue::hide(std::span<const StreamedObject> described) {
  for (const StreamedObject& object : described)
    object.hidden ? void(hidden_.insert(object.id)) : void(hidden_.erase(object.id));
}

Result<FrameQueue::StreamUpdate> FrameQueue::take(SceneView& view) {
  StreamUpdate update;
  {
    std::lock_guard lock(mutex_);
    const auto ready =
        holds_ ? events_.begin() + static_cast<std::ptrdiff_t>(events_to_take_) : events_.end();
    for (auto event = events_.begin(); event != ready; ++event) take_event(std::move(*event), view);
    events_.erase(events_.begin(), ready);
    events_to_take_ = 0;
    const bool all_there =
        std::all_of(pending_.begin(), pending_.end(), [](const Pending& one) { return one.ready(); });
    if (update_.server_restarted && !all_there) {
      update.shutdown_reason = std::exchange(update_.shutdown_reason, std::nullopt);
      update.lost = std::exchange(update_.lost, std::nullopt);
      return update;
    }
    update = std::exchange(update_, {});
  }
  std::deque<Pending> later;
  const auto waits = [&](const Pending& one) {
    return std::any_of(later.begin(), later.end(),
                       [&](const Pending& before) { return before.event.id == one.event.id; });
  };
  const auto room_comes = [&] {
    return std::any_of(later.begin(), later.end(), [](const Pending& before) {
      return before.event.object && before.event.added && before.event.object->environment;
    });
  };
  for (Pending& one : std::exchange(pending_, {})) {
    if (!one.event.object && room_comes() && !waits(one)) {  // undrawn objects are removed at once
      later.push_back(std::move(one));
      continue;
    }
    if (!one.event.object) {
      for (Pending& before : later) {
        if (before.event.id == one.event.id && before.bound.valid())
          unwanted_.push_back(std::move(before.bound));
      }
      std::erase_if(later, [&](const Pending& before) { return before.event.id == one.event.id; });
    } else if (!one.ready() || waits(one)) {
      later.push_back(std::move(one));
      continue;
    }
    if (auto shown = show(std::move(one), view, update); !shown) return shown.error();
  }
  pending_ = std::move(later);
  for (ReceivedFrame& frame : update.frames) {
    if (hidden_.empty()) break;
    auto shown = std::make_shared<DriverFrame>(*frame.drivers);
    std::erase_if(shown->objects,
                  [&](const ObjectDrivers& object) { return hidden_.contains(object.object_id); });
    frame.drivers = std::move(shown);
  }
  std::erase_if(unwanted_, [](const auto& one) {
    return one.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  });
  auto refined = objects_.refine(view);
  if (!refined) return refined.error();
  update.refined = std::move(*refined);
  return update;
}

}  // namespace livegs
