// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>

#include "core/clock.h"
#include "render/scene_view.h"
#include "stream/received/frame_history.h"
#include "stream/received/stream_item.h"
#include "viewer/assets/asset_library.h"
#include "viewer/output/frame_log.h"
#include "xr/display.h"

namespace livegs {

// Draws a stream or a recording at the display's times, on one thread. A display time maps to the simulated
// time with the same offset from the first frame, so the video is even, independent of network and drawing.
// During an outage the last picture is kept. Pictures that the display does not keep are left out, except the
// first and the last. Logs its progress every few seconds.
class Player {
 public:
  // Called with the view posed by the first frame, before the first picture.
  using OnFirstFrame = std::function<Result<void>(const SceneView& view)>;
  // Called with the first picture as soon as it is drawn.
  using OnFirstPicture = std::function<Result<void>(const Image& picture)>;
  Player(SceneView& view, AssetLibrary& assets, ItemSource& items, Display& display, DrawnLog log,
         OnFirstFrame on_first_frame, OnFirstPicture on_first_picture)
      : view_(view),
        assets_(assets),
        items_(items),
        display_(display),
        log_(std::move(log)),
        on_first_frame_(std::move(on_first_frame)),
        on_first_picture_(std::move(on_first_picture)) {}

  // Plays until the source ends; then draws the very last frame.
  Result<void> play();
  // Length of the stream that was played so far, seconds. Any thread.
  double played_s() const { return seconds_from_ns(played_ns_); }

  // The last picture. It shows `last_frame` without interpolation.
  const std::optional<Image>& last_picture() const { return last_picture_; }
  const DriverFrame* last_frame() const { return last_.drivers.get(); }  // null before the first
  DrawnLog::Summary summary() const { return log_.summary(); }

 private:
  Result<void> take(const ReceivedFrame& frame);
  Result<void> take_object(const StreamItem& item);
  Result<void> take(const ObjectAdded& added);
  Result<void> take(const ObjectChanged& changed);
  // Holds the picture until the next frame.
  void take(const ResumedSession& resumed);
  Result<void> hold_until(const ReceivedFrame& frame);
  Result<void> draw_until_newest();
  // Draws the planned picture, or leaves it out if the display does not keep it.
  Result<void> draw_if_kept(const DriverFrame& frame);
  Result<void> draw(const DriverFrame& frame);
  void log_progress();

  SceneView& view_;
  AssetLibrary& assets_;
  ItemSource& items_;
  Display& display_;
  DrawnLog log_;
  OnFirstFrame on_first_frame_;
  OnFirstPicture on_first_picture_;

  // Covers the frames on both sides of a picture; older ones were drawn.
  static constexpr size_t kFramesKept = 8;
  FrameHistory history_{kFramesKept};
  ReceivedFrame last_;  // the newest frame taken
  // Offset from simulated to history time, which continues when a restarted server begins at zero.
  int64_t shift_ns_ = 0;
  bool holds_ = false, resets_ = false;  // apply to the next frame
  std::vector<StreamItem> postponed_;    // objects of a restarted server, until then
  std::optional<int64_t> first_simulated_ns_;
  std::optional<PlannedFrame> planned_;
  std::vector<Image> pictures_;  // one per eye, of the last draw
  uint64_t drawn_ = 0;           // pictures
  std::optional<Image> last_picture_;
  std::atomic<int64_t> played_ns_{0};
  int64_t logged_ns_ = now_ns();
};

}  // namespace livegs
