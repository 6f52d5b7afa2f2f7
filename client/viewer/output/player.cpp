// SPDX-License-Identifier: Apache-2.0
#include "viewer/output/player.h"

#include "core/log.h"

namespace livegs {
namespace {

constexpr int64_t kProgressInterval_ns = 5'000'000'000;

}  // namespace

Result<void> Player::play() {
  while (auto item = items_.take()) {
    Result<void> taken;
    if (const auto* frame = std::get_if<ReceivedFrame>(&*item))
      taken = take(*frame);
    else if (const auto* resumed = std::get_if<ResumedSession>(&*item))
      take(*resumed);
    else if (resets_)
      postponed_.push_back(std::move(*item));
    else
      taken = take_object(*item);
    if (!taken) return taken;
  }
  if (history_.empty()) return {};
  // After the last display time no further frame exists: show the last frame itself.
  if (!planned_) planned_ = display_.wait_frame();
  if (!planned_) return {};
  if (auto drawn = draw(history_.newest()); !drawn) return drawn;
  last_picture_ = pictures_.front();
  return {};
}

Result<void> Player::take_object(const StreamItem& item) {
  if (const auto* added = std::get_if<ObjectAdded>(&item)) return take(*added);
  if (const auto* changed = std::get_if<ObjectChanged>(&item)) return take(*changed);
  view_.remove(std::get<ObjectRemoved>(item).object_id);
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

void Player::take(const ResumedSession& resumed) {
  holds_ = true;
  resets_ = (resets_ || !resumed.same_server) && !history_.empty();
}

// Frames before and after an outage are not interpolated; the last frame before it is shown until shortly
// before the first one after it.
Result<void> Player::hold_until(const ReceivedFrame& frame) {
  DriverFrame held = history_.newest();
  if (resets_) {
    const int64_t shown_ns = held.simulated_ns + (frame.received_ns - last_.received_ns);
    shift_ns_ = shown_ns - frame.drivers->simulated_ns;
  }
  held.simulated_ns = frame.drivers->simulated_ns + shift_ns_ - 1;
  history_.add(std::move(held));
  if (auto drawn = draw_until_newest(); !drawn) return drawn;
  if (!resets_) return {};
  history_ = FrameHistory(kFramesKept);  // the drivers of the old server do not match the new objects
  for (const StreamItem& item : std::exchange(postponed_, {})) {
    if (auto taken = take_object(item); !taken) return taken;
  }
  return {};
}

Result<void> Player::take(const ReceivedFrame& frame) {
  DriverFrame drivers = *frame.drivers;
  if (holds_ && !history_.empty()) {
    if (auto held = hold_until(frame); !held) return held;
  }
  holds_ = resets_ = false;
  drivers.simulated_ns += shift_ns_;
  if (!first_simulated_ns_) {
    first_simulated_ns_ = drivers.simulated_ns;
    if (auto posed = view_.pose(drivers); !posed) return posed;
    if (auto prepared = on_first_frame_(view_); !prepared) return prepared;
  }
  history_.add(std::move(drivers));
  last_ = frame;
  return draw_until_newest();
}

Result<void> Player::draw_until_newest() {
  for (;;) {
    if (!planned_) planned_ = display_.wait_frame();
    if (!planned_) return {};
    const int64_t shown_ns = *first_simulated_ns_ + planned_->display_time_ns;
    if (shown_ns > history_.newest().simulated_ns) return {};
    if (auto drawn = draw_if_kept(*history_.at(shown_ns)); !drawn) return drawn;
    played_ns_ = shown_ns - *first_simulated_ns_;
    log_progress();
    history_.drop_before(shown_ns);
  }
}

Result<void> Player::draw_if_kept(const DriverFrame& frame) {
  if (planned_->kept || drawn_ == 0) return draw(frame);
  planned_.reset();
  return {};
}

void Player::log_progress() {
  if (now_ns() - logged_ns_ < kProgressInterval_ns) return;
  logged_ns_ = now_ns();
  log_info("player: played %.1f s of the stream, drew %llu pictures", played_s(),
           static_cast<unsigned long long>(drawn_));
}

Result<void> Player::draw(const DriverFrame& frame) {
  if (auto drawn = view_.draw(frame, planned_->views, pictures_); !drawn) return drawn;
  if (auto submitted = display_.submit(*planned_, pictures_); !submitted) return submitted;
  if (drawn_++ == 0) {
    if (auto taken = on_first_picture_(pictures_.front()); !taken) return taken;
  }
  log_.add({planned_->index, seconds_from_ns(frame.simulated_ns), last_.tick, last_.received_ns,
            age_ms(last_).value_or(0), milliseconds_from_ns(now_ns() - last_.received_ns),
            view_.last_times().skin_ms, view_.last_times().raster_ms, last_.bytes, last_.step_ms,
            view_.last_times().device});
  planned_.reset();
  return {};
}

}  // namespace livegs
