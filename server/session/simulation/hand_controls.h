// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "core/input_sample.h"
#include "scene/scene.h"
#include "session/tick/tick_result.h"

// Applies controllers to the world: ray spring, grab and ball shooter. Simulation thread only.

namespace livegs {

// Trigger thresholds for press and release, 0..1. The difference prevents flicker when a finger rests on the
// trigger.
inline constexpr float kTriggerPressed = 0.5f;
inline constexpr float kTriggerReleased = 0.4f;

// Length of the ray: across a room.
inline constexpr double kRayReach_m = 20.0;

// Maximum distance from the grip to the nearest object for a grab.
inline constexpr double kGrabReach_m = 0.1;
inline constexpr float kSqueezePressed = 0.5f;
inline constexpr float kSqueezeReleased = 0.4f;
// Time constant of the hand velocity that a thrown object takes over. The velocity is limited by
// kMaxHandSpeed_m_s and kMaxHandSpin_rad_s, since samples are untrusted.
inline constexpr double kHandSmoothing_s = 0.03;
// Longest interval between samples that gives a velocity. Between samples the hand is extrapolated for the
// length of the last interval, so that the client's frame rate does not affect throws.
inline constexpr double kMaxSampleInterval_s = 0.3;
inline constexpr double kMinSampleInterval_s = 0.002;  // shortest such interval
inline constexpr double kMaxHandSpeed_m_s = 15.0;
inline constexpr double kMaxHandSpin_rad_s = 30.0;

// Speed of a ball: an underarm throw.
inline constexpr double kBallSpeed_m_s = 6.0;
// Minimum time between shots of a hand, so that a client cannot flood the scene. The shot of a faster press
// is delayed.
inline constexpr double kMinShotInterval_s = 0.1;
// Maximum number of delayed shots of a hand; further presses are ignored. A larger value would shoot for
// seconds after the last press.
inline constexpr size_t kMaxWaitingShots = 16;

class HandControls {
 public:
  // Applies one sample of a session. A rising edge of `shoot` waits for shoot().
  void apply(Scene& scene, SessionNumber session, const InputSample& sample);
  // Shoots the waiting balls that are due, at most one per hand. Call once per tick, after its samples.
  // `now_s` is simulated time and limits the rate of shots.
  void shoot(Scene& scene, double now_s);
  // Releases the objects held by a session; on_session_closed() also drops its state.
  void release(Scene& scene, SessionNumber session);
  void on_session_closed(Scene& scene, SessionNumber session);
  // Releases an object that was removed from the world.
  void release_object(Scene& scene, uint32_t object_id);
  // True if a hand of the session holds an object.

  bool holding(SessionNumber session) const;
  std::array<HeldPoint, 2> held_points(const Scene& scene, SessionNumber session) const;
  uint64_t shots() const { return shots_; }

 private:
  struct Hand {
    bool triggered = false;
    bool holding = false;
    bool shooting = false;
    bool squeezed = false;
    bool grabbing = false;  // grabbed; excludes holding by the ray
    bool tracked = false;   // grip, sampled_ns and velocities are from the previous sample
    Pose grip;
    int64_t sampled_ns = 0;
    double extrapolation_s = 0;  // expected time until the next sample
    Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero(), spin_rad_s = Eigen::Vector3d::Zero();
    uint32_t object_id = 0;
    Eigen::Vector3d rest_point_m = Eigen::Vector3d::Zero();
    std::optional<uint32_t> piece;  // fragment hit by the ray
    double distance_m = 0;          // distance of the hit along the ray
    double last_shot_s = -1e9;
    std::deque<Pose> waiting_shots;  // the aims of the presses
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
