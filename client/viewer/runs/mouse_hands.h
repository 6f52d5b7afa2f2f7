// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "splat/camera.h"
#include "stream/session/scripted_hands.h"
#include "stream/session/session_client.h"
#include "viewer/panels/frame_meter.h"
#include "xr/window_display.h"

namespace livegs {

// Input samples of a window: the mouse is the ray of the right hand, or a script moves the hands. Renderer
// thread.
class MouseHands {
 public:
  // Both must outlive this object.
  MouseHands(SessionClient& client, FrameMeter& meter) : client_(client), meter_(meter) {}

  // Starts a script that pokes the object from `eye_m`, in place of the mouse.
  void begin_script(const std::string& object, const Eigen::Vector3d& eye_m);
  bool scripted() const { return script_.has_value(); }

  // `window`: the camera of the whole window. `pulls`: the left button pulls. `rests`: the scene does not
  // change. A repeated sample is then not sent, because it would wake the server, and the reply this window.
  void send_mouse(const WindowInput& input, const Camera& window, bool pulls, bool rests);
  // `seconds`: since the beginning of the script. Between two pictures the script advances by
  // kMaxScriptStep_s at most, so that a slow window shows all of it.
  void send_script(double seconds, const ScriptedHands::Locate& locate);

 private:
  SessionClient& client_;
  FrameMeter& meter_;
  std::optional<ScriptedHands> script_;
  InputSample sample_;
  HandSample sent_;  // of the right hand, in the last sample
  double asked_s_ = 0, script_s_ = 0;
};

}  // namespace livegs
