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

// State of the hands for a picture. A hand is inactive while it is not tracked or the system has the focus,
// and in the picture after a recentre, so that a held object does not jump.
struct HeadsetInput {
  std::array<HandSample, 2> hands;  // left, right; scene pose predicted for the display time
  bool focused = false;
};

// A headset on the active OpenXR runtime. The display survives the loss of its session (headset taken off,
// runtime restarted, another application in front): meanwhile pictures have no views and nothing is drawn.
// Picture times are of now_ns(). Use on the thread that opened it.
class HeadsetDisplay : public Display {
 public:
  // Unavailable, with the remedy, without a runtime, a headset or a suitable device. open() sets the maker of
  // `options`.
  static Result<std::unique_ptr<HeadsetDisplay>> open(VulkanDeviceOptions options = {});

  virtual const std::string& runtime_name() const = 0;
  // The device that renders the pictures. It must not be used during wait_frame or submit.
  virtual std::shared_ptr<VulkanDevice> device() const = 0;

  // Pose of the LOCAL space (origin at the initial head pose, facing -Z) in the scene.
  virtual void set_scene_from_local(const Pose& scene_from_local) = 0;
  // Render scale relative to the recommended size: 0.25 to 1.
  virtual void set_scale(double scale) = 0;

  // Sets a text plate that is fixed to the view, from the next submit on. Lines are separated by newlines or
  // wrapped. Empty: no plate.
  virtual void set_notice(const std::string& text) = 0;

  // wait_frame: nothing when the runtime ended the session. Paced by the headset; returns at least every 50
  // ms, without views if nothing is visible.
  virtual const HeadsetInput& input() const = 0;  // of the last wait_frame or update_input
  virtual double period_s() const = 0;            // picture interval, as last reported by the runtime

  // Updates the views with the newest head prediction, which is more accurate than that of wait_frame.
  virtual void update_views(PlannedFrame& frame) = 0;
  // Updates the hands. False if no picture is in progress or the system has the focus.
  virtual bool update_input() = 0;
  // Image to draw the views into; nothing if the session was lost. Call once per picture.
  virtual std::optional<DeviceImage> acquire() = 0;
  // submit: without images, the acquired image is shown.

  // hand: 0 left, 1 right; amplitude 0..1.
  virtual void vibrate(size_t hand, float amplitude, double seconds) = 0;

  // finish: requests the end of the session and waits for up to two seconds. Returns the error if the session
  // had failed.

  struct Counts {
    uint64_t sessions = 0, losses = 0, recentres = 0, refresh_changes = 0, pictures = 0;
  };
  virtual const Counts& counts() const = 0;
};

}  // namespace livegs
