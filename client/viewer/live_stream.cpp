// SPDX-License-Identifier: Apache-2.0
#include "viewer/live_stream.h"

#include <utility>

namespace livegs {

void LiveStream::on_lost(const std::string& reason) {
  std::lock_guard lock(mutex_);
  news_.lost = reason;
  lost_ = true;
}

void LiveStream::on_resumed(const ResumedSession& resumed) {
  std::lock_guard lock(mutex_);
  if (resumed.same_server || holds_) return;
  holds_ = true;
  events_to_take_ = events_.size();
}

void LiveStream::on_frame(ReceivedFrame frame) {
  std::lock_guard lock(mutex_);
  news_.back = news_.back || std::exchange(lost_, false);
  if (std::exchange(holds_, false)) {
    news_.anew = true;
    news_.frames.clear();
  }
  if (keeps_all_) kept_.push_back(frame);
  if (news_.frames.size() == kMostFrames) news_.frames.erase(news_.frames.begin());
  news_.frames.push_back(std::move(frame));
}

void LiveStream::keep_all(bool keep) {
  std::lock_guard lock(mutex_);
  keeps_all_ = keep;
}

std::vector<ReceivedFrame> LiveStream::take_kept() {
  std::lock_guard lock(mutex_);
  return std::exchange(kept_, {});
}

void LiveStream::on_object_added(StreamedObject object) {
  assets_.ask_for(object);
  std::lock_guard lock(mutex_);
  events_.push_back({std::move(object), true, 0});
}

void LiveStream::on_object_changed(StreamedObject object) {
  assets_.ask_for(object);
  std::lock_guard lock(mutex_);
  events_.push_back({std::move(object), false, 0});
}

void LiveStream::on_object_removed(uint32_t object_id) {
  std::lock_guard lock(mutex_);
  events_.push_back({std::nullopt, false, object_id});
}

void LiveStream::on_draining(const std::string& reason) {
  std::lock_guard lock(mutex_);
  news_.goodbye = reason;
}

Result<LiveStream::News> LiveStream::take(SceneView& view) {
  std::vector<Event> events;
  News news;
  {
    std::lock_guard lock(mutex_);
    const auto ready = holds_ ? events_.begin() + static_cast<std::ptrdiff_t>(events_to_take_) : events_.end();
    events.assign(std::make_move_iterator(events_.begin()), std::make_move_iterator(ready));
    events_.erase(events_.begin(), ready);
    events_to_take_ = 0;
    news = std::exchange(news_, {});
  }
  for (Event& event : events) {
    if (!event.object) {
      view.remove(event.removed_id);
      news.removed.push_back(event.removed_id);
      continue;
    }
    const StreamedObject& object = *event.object;
    auto asset = assets_.get(object.asset_hash);
    if (!asset) return asset.error();
    auto shown = event.added ? view.add(object.id, *asset, object.rest, object.environment)
                             : view.change(object.id, *asset, object.rest, object.environment);
    if (!shown) return shown.error();
    news.described.push_back(std::move(*event.object));
  }
  return news;
}

}  // namespace livegs
