// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "compute/device_image.h"
#include "compute/vulkan_device.h"
#include "core/input_sample.h"
#include "xr/display.h"

namespace livegs {

// What the hands did at a picture. A hand is not active while it is not tracked or the system has the focus,
// and for the picture in which the space was recentred, so that nothing is torn along.
struct HeadsetInput {
  std::array<HandSample, 2> hands;  // left, right; in the scene, where they will be when the picture is seen
  bool focused = false;
};

// A headset, through whatever OpenXR runtime is active. Its session comes and goes (the headset is taken off,
// the runtime is restarted, another application covers this one) without the display ending: pictures then
// have no views, and nothing is drawn. Times of pictures are of now_ns(). On the thread that opened it.
class HeadsetDisplay : public Display {
 public:
  // Unavailable, with the remedy, when there is no runtime, no headset or no device that can draw for it. The
  // maker of `options` is set here.
  static Result<std::unique_ptr<HeadsetDisplay>> open(VulkanDeviceOptions options = {});

  virtual const std::string& runtime_name() const = 0;
  // Where its pictures are drawn. It must not be used while the display is waited for or submitted to.
  virtual std::shared_ptr<VulkanDevice> device() const = 0;

  // Where the person's place at the start (LOCAL's origin: head height, facing -Z) lies in the scene.
  virtual void set_scene_from_local(const Pose& scene_from_local) = 0;
  // Of what is drawn, by the size that the runtime wants: 0.25 to 1.
  virtual void set_scale(double scale) = 0;

  // Text on a plate that stays before the eyes, over whatever is shown, from the next submit on; lines end
  // with \n or are broken. Empty: none.
  virtual void set_notice(const std::string& text) = 0;

  // wait_frame: nothing when the runtime ended the session; at least every 50 ms, with no views where none
  // are seen. Sleeps as the headset paces it.
  virtual const HeadsetInput& input() const = 0;  // of the last wait_frame or update_input
  virtual double period_s() const = 0;            // between pictures, as the runtime last said

  // Where the head will be, as far as is known by now: closer than at wait_frame.
  virtual void update_views(PlannedFrame& frame) = 0;
  // The hands as they are by now. False where there are none: no picture is being made, the system has the
  // focus.
  virtual bool update_input() = 0;
  // What the views of this picture are drawn into; nothing if the session was lost meanwhile. Once a picture.
  virtual std::optional<DeviceImage> acquire() = 0;
  // submit: with no images, what was drawn into the acquired one.

  // hand 0 left, 1 right; amplitude 0..1.
  virtual void vibrate(size_t hand, float amplitude, double seconds) = 0;

  // finish: asks the runtime to end the session and waits, two seconds at most. Why it ended by itself, if by
  // a failure.

  struct Counts {
    uint64_t sessions = 0, losses = 0, recentres = 0, refresh_changes = 0, pictures = 0;
  };
  virtual const Counts& counts() const = 0;
};

}  // namespace livegs
