// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/simulation/hand_controls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace livegs {
namespace {

uint64_t spring_id(SessionNumber session, size_t hand) { return 2 * session + hand; }

Eigen::Vector3d ray_direction(const Pose& aim) { return aim.orientation * -Eigen::Vector3d::UnitZ(); }

}  // namespace

void HandControls::apply(Scene& scene, SessionNumber session, const InputSample& sample) {
  Hands& hands = sessions_[session];
  for (size_t i = 0; i < hands.size(); ++i) {
    Hand& hand = hands[i];
    const HandSample& input = sample.hands[i];
    if (!input.active) {  // an untracked hand releases its object
      release_hand(scene, spring_id(session, i), hand);
      hand.triggered = hand.shooting = hand.squeezed = hand.tracked = false;
      hand.waiting_shots.clear();
      continue;
    }
    track(hand, input, sample.sampled_ns);
    apply_grab(scene, spring_id(session, i), hand, input);
    apply_ray(scene, spring_id(session, i), hand, input);
    if (input.shoot && !hand.shooting && hand.waiting_shots.size() < kMaxWaitingShots)
      hand.waiting_shots.push_back(input.aim);
    hand.shooting = input.shoot;
  }
}

void HandControls::shoot(Scene& scene, double now_s) {
  for (auto& [session, hands] : sessions_) {
    for (Hand& hand : hands) {
      if (hand.waiting_shots.empty() || now_s - hand.last_shot_s < kMinShotInterval_s) continue;
      const Pose aim = hand.waiting_shots.front();
      hand.waiting_shots.pop_front();
      scene.shoot_ball(aim.position_m, kBallSpeed_m_s * ray_direction(aim));
      hand.last_shot_s = now_s;
      ++shots_;
    }
  }
}

void HandControls::apply_ray(Scene& scene, uint64_t spring, Hand& hand, const HandSample& input) {
  const bool pressed = input.trigger > (hand.triggered ? kTriggerReleased : kTriggerPressed);
  World& world = scene.world();
  if (pressed && !hand.triggered && !hand.grabbing) {  // cast once: a moving ray does not pick up objects
    if (const auto hit = world.ray_cast(input.aim.position_m, ray_direction(input.aim), kRayReach_m)) {
      hand.holding = true;
      hand.object_id = hit->object_id;
      hand.rest_point_m = hit->rest_point_m;
      hand.piece = hit->piece;
      hand.distance_m = hit->distance_m;
    }
  }
  hand.triggered = pressed;
  if (!pressed && hand.holding) release_hand(scene, spring, hand);
  if (!hand.holding) return;

  // The mass of the fragment after fracture.
  const double mass_kg = world.mass_at_kg(hand.object_id, hand.rest_point_m, hand.piece);
  if (mass_kg <= 0) return;  // static objects are not pulled
  World::Spring pull = ray_spring(mass_kg);
  pull.rest_point_m = hand.rest_point_m;
  pull.piece = hand.piece;
  pull.target_m = input.aim.position_m + hand.distance_m * ray_direction(input.aim);
  world.set_spring(spring, hand.object_id, pull);
}

// Estimates the velocity of the grip from two samples, by the client's clock if its interval is plausible. A
// headset sends several samples per frame at nearly the same time: the last one gives the best position, but
// no velocity.
void HandControls::track(Hand& hand, const HandSample& sample, int64_t sampled_ns) {
  const double passed_s = 1e-9 * (static_cast<double>(sampled_ns) - static_cast<double>(hand.sampled_ns));
  const bool previous_is_recent = hand.tracked && std::abs(passed_s) <= kMaxSampleInterval_s;
  if (previous_is_recent && passed_s < kMinSampleInterval_s) {
    hand.grip = sample.grip;
    return;
  }
  hand.extrapolation_s = previous_is_recent ? passed_s : 0.0;
  if (!previous_is_recent) {
    hand.velocity_m_s.setZero();
    hand.spin_rad_s.setZero();
  } else {
    const auto bounded = [](const Eigen::Vector3d& vector, double most) {
      return Eigen::Vector3d(std::min(1.0, most / std::max(vector.norm(), 1e-12)) * vector);
    };
    const Eigen::AngleAxisd turn(sample.grip.orientation * hand.grip.orientation.conjugate());
    const double angle = std::remainder(turn.angle(), 2 * std::numbers::pi);
    const Eigen::Vector3d velocity = (sample.grip.position_m - hand.grip.position_m) / passed_s;
    const Eigen::Vector3d spin = angle / passed_s * turn.axis();
    const double share = 1.0 - std::exp(-passed_s / kHandSmoothing_s);
    hand.velocity_m_s += share * (bounded(velocity, kMaxHandSpeed_m_s) - hand.velocity_m_s);
    hand.spin_rad_s += share * (bounded(spin, kMaxHandSpin_rad_s) - hand.spin_rad_s);
  }
  hand.tracked = true;
  hand.grip = sample.grip;
  hand.sampled_ns = sampled_ns;
}

void HandControls::apply_grab(Scene& scene, uint64_t grab_id, Hand& hand, const HandSample& input) {
  const bool squeezed = input.squeeze > (hand.squeezed ? kSqueezeReleased : kSqueezePressed);
  World& world = scene.world();
  if (squeezed && !hand.squeezed) {  // a hand that is already closed grabs nothing
    if (const auto met = world.nearest(input.grip.position_m, kGrabReach_m)) {
      if (const double mass_kg = world.mass_at_kg(met->object_id, met->rest_point_m, met->piece);
          mass_kg > 0) {
        release_hand(scene, grab_id, hand);
        hand.grabbing = world.grab(grab_id, met->object_id, input.grip, hand_grip(mass_kg)).has_value();
        hand.object_id = met->object_id;
        hand.rest_point_m = met->rest_point_m;
        hand.piece = met->piece;
      }
    }
  }
  hand.squeezed = squeezed;
  if (!squeezed && hand.grabbing) release_hand(scene, grab_id, hand);
  if (hand.grabbing)
    world.move_grab(grab_id, input.grip, hand.velocity_m_s, hand.spin_rad_s, hand.extrapolation_s);
}

void HandControls::release_hand(Scene& scene, uint64_t spring, Hand& hand) {
  if (hand.grabbing) scene.world().release_grab(spring);
  if (hand.holding) scene.world().clear_spring(spring);
  hand.grabbing = hand.holding = false;
}

void HandControls::release(Scene& scene, SessionNumber session) {
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) return;
  for (size_t i = 0; i < found->second.size(); ++i)
    release_hand(scene, spring_id(session, i), found->second[i]);
}

void HandControls::on_session_closed(Scene& scene, SessionNumber session) {
  release(scene, session);
  sessions_.erase(session);
}

void HandControls::release_object(Scene& scene, uint32_t object_id) {
  for (auto& [session, hands] : sessions_) {
    for (size_t i = 0; i < hands.size(); ++i) {
      if (hands[i].object_id == object_id) release_hand(scene, spring_id(session, i), hands[i]);
    }
  }
}

bool HandControls::holding(SessionNumber session) const {
  const auto found = sessions_.find(session);
  return found != sessions_.end() &&
         std::any_of(found->second.begin(), found->second.end(),
                     [](const Hand& hand) { return hand.holding || hand.grabbing; });
}

std::array<HeldPoint, 2> HandControls::held_points(const Scene& scene, SessionNumber session) const {
  std::array<HeldPoint, 2> points;
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) return points;
  for (size_t i = 0; i < points.size(); ++i) {
    const Hand& hand = found->second[i];
    const World& world = scene.world();
    const auto state = hand.grabbing ? world.grab_state(spring_id(session, i)) : std::nullopt;
    const double felt_n_s =
        world.contact_impulse_n_s(hand.object_id, hand.rest_point_m, state ? state->piece : hand.piece);
    if (hand.grabbing) {
      if (state) {
        points[i] = {true, hand.object_id, state->point_m, state->force_n, true, state->torque_n_m, felt_n_s};
      }
      continue;
    }
    if (!hand.holding) continue;
    points[i] = {true,
                 hand.object_id,
                 scene.world().world_point(hand.object_id, hand.rest_point_m, hand.piece),
                 scene.world().spring_force_n(spring_id(session, i)),
                 false,
                 Eigen::Vector3d::Zero(),
                 felt_n_s};
  }
  return points;
}

}  // namespace livegs
