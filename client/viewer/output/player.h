// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "render/scene_view.h"
#include "stream/received/frame_history.h"
#include "stream/received/stream_item.h"
#include "viewer/assets/asset_library.h"
#include "viewer/output/frame_log.h"
#include "xr/display.h"

namespace livegs {

// Takes what comes from a stream or a recording and draws it at the display's times, on one thread. A display
// time is shown as the moment of the simulation that lies as long after the first frame; the video is even,
// whatever the network and the drawing did, because simulated time is. While the stream is gone, the last
// picture stays.
class Player {
 public:
  // Called with the view posed by the first frame, before the first picture.
  using OnFirstFrame = std::function<Result<void>(const SceneView& view)>;
  Player(SceneView& view, AssetLibrary& assets, ItemSource& items, Display& display, DrawnLog log,
         OnFirstFrame on_first_frame)
      : view_(view),
        assets_(assets),
        items_(items),
        display_(display),
        log_(std::move(log)),
        on_first_frame_(std::move(on_first_frame)) {}

  // Until no more comes; then draws the very last frame by itself.
  Result<void> play();

  // The first and the last picture. The last is of `last_frame`, not interpolated.
  const std::optional<Image>& first_picture() const { return first_picture_; }
  const std::optional<Image>& last_picture() const { return last_picture_; }
  const DriverFrame* last_frame() const { return last_.drivers.get(); }  // null before the first
  DrawnLog::Summary summary() const { return log_.summary(); }

 private:
  Result<void> take(const ReceivedFrame& frame);
  Result<void> take_object(const StreamItem& item);
  Result<void> take(const ObjectAdded& added);
  Result<void> take(const ObjectChanged& changed);
  // What is drawn stands still until the next frame.
  void take(const ResumedSession& resumed);
  Result<void> hold_until(const ReceivedFrame& frame);
  Result<void> draw_until_newest();
  Result<void> draw(const DriverFrame& frame);

  SceneView& view_;
  AssetLibrary& assets_;
  ItemSource& items_;
  Display& display_;
  DrawnLog log_;
  OnFirstFrame on_first_frame_;

  // Enough for the frames on both sides of a picture; what is older was drawn.
  static constexpr size_t kFramesKept = 8;
  FrameHistory history_{kFramesKept};
  ReceivedFrame last_;  // the newest taken
  // The history's time is simulated time plus this: it goes on when a server that was started anew begins at
  // zero.
  int64_t shift_ns_ = 0;
  bool holds_ = false, resets_ = false;  // with the next frame
  std::vector<StreamItem> postponed_;    // until then: objects of a server that was started anew
  std::optional<int64_t> first_simulated_ns_;
  std::optional<PlannedFrame> planned_;
  std::vector<Image> pictures_;  // an eye each, of the last moment drawn
  std::optional<Image> first_picture_, last_picture_;
};

}  // namespace livegs
