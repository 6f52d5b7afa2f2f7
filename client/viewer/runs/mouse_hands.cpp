// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/mouse_hands.h"

#include <algorithm>
#include <span>

#include "core/clock.h"
#include "viewer/camera/client_view_cone.h"
#include "viewer/camera/orbit_camera.h"

namespace livegs {
namespace {

constexpr size_t kRightHand = 1;
constexpr double kMaxScriptStep_s = 0.1;  // a tenth of the pull of --poke

bool same(const HandSample& a, const HandSample& b) {
  return a.active == b.active && a.trigger == b.trigger && a.aim.position_m == b.aim.position_m &&
         a.aim.orientation.coeffs() == b.aim.orientation.coeffs();
}

}  // namespace

void MouseHands::begin_script(const std::string& object, const Eigen::Vector3d& eye_m) {
  script_.emplace(poke_script(object), ScriptedHands::Settings{eye_m, client_.scene().ball_speed_m_s});
}

void MouseHands::send_mouse(const WindowInput& input, const Camera& window, bool pulls, bool rests) {
  HandSample& hand = sample_.hands[kRightHand];
  hand.active = true;
  client_.set_view(client_view_cone(std::span(&window, 1)));
  hand.aim = ray_through(window, input.mouse_px);
  hand.grip = hand.aim;
  hand.trigger = pulls ? 1.0f : 0.0f;
  const auto send = [&](bool shoot) {
    hand.shoot = shoot;
    ++sample_.sequence;
    sample_.sampled_ns = now_ns();
    meter_.sampled(sample_.sequence, sample_.sampled_ns);
    client_.send(sample_);
  };
  for (int press = 0; press < input.shoot; ++press) {  // one rising edge each
    send(true);
    send(false);
  }
  const bool repeats = rests && hand.trigger == 0 && same(hand, sent_);
  if (input.shoot == 0 && !repeats) send(false);
  sent_ = hand;
}

void MouseHands::send_script(double seconds, const ScriptedHands::Locate& locate) {
  // Time decreases when the run waits for its start.
  script_s_ = seconds < asked_s_ ? seconds : script_s_ + std::min(seconds - asked_s_, kMaxScriptStep_s);
  asked_s_ = seconds;
  const InputSample sample = script_->at(script_s_, locate);
  meter_.sampled(sample.sequence, now_ns());
  client_.send(sample);
}

}  // namespace livegs
