// SPDX-License-Identifier: Apache-2.0
#include "viewer/player.h"

#include "core/clock.h"

namespace livegs {

Result<void> Player::play() {
  while (auto item = queue_.take()) {
    Result<void> taken;
    if (const auto* frame = std::get_if<ReceivedFrame>(&*item))
      taken = take(*frame);
    else if (const auto* added = std::get_if<ObjectAdded>(&*item))
      taken = take(*added);
    else if (const auto* changed = std::get_if<ObjectChanged>(&*item))
      taken = take(*changed);
    else
      view_.remove(std::get<ObjectRemoved>(*item).object_id);
    if (!taken) return taken;
  }
  if (history_.empty()) return {};
  // Between the last display time and the last frame nothing else is to come: show that frame itself.
  if (!planned_) planned_ = display_.wait_frame();
  if (!planned_) return {};
  if (auto drawn = draw(history_.newest()); !drawn) return drawn;
  last_picture_ = pictures_.front();
  return {};
}

Result<void> Player::take(const ObjectAdded& added) {
  auto asset = assets_.get(added.object.asset_hash);
  if (!asset) return asset.error();
  return view_.add(added.object.id, *asset, added.object.rest, added.object.environment);
}

Result<void> Player::take(const ObjectChanged& changed) {
  auto asset = assets_.get(changed.object.asset_hash);
  if (!asset) return asset.error();
  return view_.change(changed.object.id, *asset, changed.object.rest, changed.object.environment);
}

Result<void> Player::take(const ReceivedFrame& frame) {
  const DriverFrame& drivers = *frame.drivers;
  if (!first_simulated_ns_) {
    first_simulated_ns_ = drivers.simulated_ns;
    if (auto posed = view_.pose(drivers); !posed) return posed;
    if (auto prepared = on_first_frame_(view_); !prepared) return prepared;
  }
  history_.add(drivers);
  last_ = frame;
  return draw_until_newest();
}

Result<void> Player::draw_until_newest() {
  for (;;) {
    if (!planned_) planned_ = display_.wait_frame();
    if (!planned_) return {};
    const int64_t shown_ns = *first_simulated_ns_ + planned_->display_time_ns;
    if (shown_ns > history_.newest().simulated_ns) return {};
    if (auto drawn = draw(*history_.at(shown_ns)); !drawn) return drawn;
    history_.forget_before(shown_ns);
  }
}

Result<void> Player::draw(const DriverFrame& frame) {
  if (auto drawn = view_.draw(frame, planned_->views, pictures_); !drawn) return drawn;
  if (!first_picture_) first_picture_ = pictures_.front();
  if (auto submitted = display_.submit(*planned_, pictures_); !submitted) return submitted;
  log_.add({planned_->index, seconds_from_ns(frame.simulated_ns), last_.tick, last_.received_ns,
            milliseconds_from_ns(last_.received_ns - last_.stepped_ns),
            milliseconds_from_ns(now_ns() - last_.received_ns), view_.last_times().skin_ms,
            view_.last_times().raster_ms, last_.bytes, last_.step_ms});
  planned_.reset();
  return {};
}

}  // namespace livegs
