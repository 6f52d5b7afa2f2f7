// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>

#include "core/input_sample.h"
#include "scene/scene.h"
#include "session/tick/tick_result.h"

// What controllers do to the world: the ray's spring, the grab and the ball shooter. The simulation's thread
// only.

namespace livegs {

// The trigger's threshold, and how much it must ease before the ray lets go, so that a finger that rests on
// it does not chatter.
inline constexpr float kTriggerPressed = 0.5f;
inline constexpr float kTriggerReleased = 0.4f;

// A ray reaches across a room, not to the horizon.
inline constexpr double kRayReach_m = 20.0;

// A hand that closes takes the nearest object within this distance of its grip.
inline constexpr double kGrabReach_m = 0.1;
inline constexpr float kSqueezePressed = 0.5f;
inline constexpr float kSqueezeReleased = 0.4f;
// A thrown object goes as the hand went: its velocity is averaged over about this time, and bounded, since
// samples come from outside.
inline constexpr double kHandSmoothing_s = 0.03;
// Between samples a hand goes on as it went, for as long as the last two were apart: a client that draws
// slowly throws as well as one that draws fast. Those further apart than this say nothing of how it moved.
inline constexpr double kMaxSampleInterval_s = 0.3;
inline constexpr double kMinSampleInterval_s = 0.002;  // nor do those that are closer
inline constexpr double kMaxHandSpeed_m_s = 15.0;
inline constexpr double kMaxHandSpin_rad_s = 30.0;

// An underarm throw.
inline constexpr double kBallSpeed_m_s = 6.0;
// A hand shoots no faster: a client that flickers its button cannot flood the scene.
inline constexpr double kMinShotInterval_s = 0.1;

class HandControls {
 public:
  // Applies one sample of a session. Balls are counted against simulated time, `now_s`.
  void apply(Scene& scene, SessionNumber session, const InputSample& sample, double now_s);
  // Lets go of what a session holds; on_session_closed() also drops its state.
  void release(Scene& scene, SessionNumber session);
  void on_session_closed(Scene& scene, SessionNumber session);
  // Lets go of an object that was taken out of the world.
  void release_object(Scene& scene, uint32_t object_id);
  // Nobody holds anything any more, since the scene is not to be touched.

  bool holding(SessionNumber session) const;
  std::array<HeldPoint, 2> held_points(const Scene& scene, SessionNumber session) const;
  uint64_t shots() const { return shots_; }

 private:
  struct Hand {
    bool triggered = false;
    bool holding = false;
    bool shooting = false;
    bool squeezed = false;
    bool grabbing = false;  // in place of the ray's holding
    bool tracked = false;   // grip and the two below are of the sample before
    Pose grip;
    int64_t sampled_ns = 0;
    double extrapolation_s = 0;  // until the next sample is likely
    Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero(), spin_rad_s = Eigen::Vector3d::Zero();
    uint32_t object_id = 0;
    Eigen::Vector3d rest_point_m = Eigen::Vector3d::Zero();
    std::optional<uint32_t> piece;  // of the fragment the ray met
    double distance_m = 0;          // along the ray, where the point was met
    double last_shot_s = -1e9;
  };
  using Hands = std::array<Hand, 2>;

  void apply_ray(Scene& scene, uint64_t spring_id, Hand& hand, const HandSample& sample);
  void apply_grab(Scene& scene, uint64_t grab_id, Hand& hand, const HandSample& sample);
  static void track(Hand& hand, const HandSample& sample, int64_t sampled_ns);
  void release_hand(Scene& scene, uint64_t spring_id, Hand& hand);

  std::map<SessionNumber, Hands> sessions_;
  uint64_t shots_ = 0;
};

}  // namespace livegs
