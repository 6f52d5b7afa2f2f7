// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "render/scene_view.h"
#include "stream/received/received.h"
#include "viewer/assets/progressive_objects.h"
#include "viewer/camera/window_picture.h"
#include "viewer/panels/frame_meter.h"
#include "xr/window/window_panels.h"

namespace livegs {

// Contents of the Run panel of a live scene.
struct RunPanelSource {
  const ReceivedFrame* newest = nullptr;  // null before the first frame
  const SceneView& view;
  const WindowPicture& picture;
  const FrameMeter& meter;
  ProgressiveObjects::Progress coming;
  std::string notice;  // empty: that of the view
};
RunPanel run_panel(const RunPanelSource& source);

// Keeps the counters of the panel while the picture rests, so that they alone do not redraw the window. One
// thread.
class RestingCounters {
 public:
  void hold(RunPanel& run, bool rests);

 private:
  RunPanel last_;
  bool rested_ = false;  // last_ is of a picture at rest
};

}  // namespace livegs
