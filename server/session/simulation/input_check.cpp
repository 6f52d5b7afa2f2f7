// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/simulation/input_check.h"

#include <cmath>

namespace livegs {
namespace {

using Floats = google::protobuf::RepeatedField<float>;

Result<Pose> checked_pose(const Floats& position, const Floats& orientation, const std::string& field) {
  if (position.size() != 3) return invalid_argument(field + "_position_m: must have three numbers");
  if (orientation.size() != 4) return invalid_argument(field + "_orientation: must have four numbers");
  Pose pose;
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(position[i]) <= kMaxHandPosition_m)) {  // false for NaN too
      return invalid_argument(field + "_position_m: must be finite and within 1000 m");
    }
    pose.position_m[i] = position[i];
  }
  pose.orientation = Eigen::Quaterniond(orientation[0], orientation[1], orientation[2], orientation[3]);
  if (!(std::abs(pose.orientation.norm() - 1.0) <= 0.01)) {
    return invalid_argument(field + "_orientation: is not a unit quaternion");
  }
  pose.orientation.normalize();
  // Rounded to float as received: recordings store it bit by bit in half the space.
  for (double& component : pose.orientation.coeffs())
    component = static_cast<double>(static_cast<float>(component));
  return pose;
}

Result<HandSample> checked_hand(const v1::HandInput& message, const std::string& field) {
  HandSample hand;
  hand.active = true;
  auto aim = checked_pose(message.aim_position_m(), message.aim_orientation(), field + ".aim");
  if (!aim) return aim.error();
  auto grip = checked_pose(message.grip_position_m(), message.grip_orientation(), field + ".grip");
  if (!grip) return grip.error();
  hand.aim = *aim;
  hand.grip = *grip;
  for (float value : {message.trigger(), message.squeeze()}) {
    if (!(value >= 0.0f && value <= 1.0f))
      return invalid_argument(field + ": trigger and squeeze must be in 0..1");
  }
  hand.trigger = message.trigger();
  hand.squeeze = message.squeeze();
  hand.shoot = message.shoot();
  return hand;
}

}  // namespace

Result<std::vector<InputSample>> check_inputs(const v1::ClientMessage& message) {
  if (message.inputs_size() > kMaxSamplesPerMessage)
    return invalid_argument("inputs: more than 8 in one message; send fewer");
  std::vector<InputSample> samples;
  for (int i = 0; i < message.inputs_size(); ++i) {
    const v1::Input& input = message.inputs(i);
    const std::string field = "inputs[" + std::to_string(i) + "]";
    if (input.sequence() == 0) return invalid_argument(field + ".sequence: must be at least 1");
    if (!samples.empty() && input.sequence() <= samples.back().sequence) {
      return invalid_argument(field + ".sequence: must increase");
    }
    InputSample sample;
    sample.sequence = input.sequence();
    sample.sampled_ns = input.sampled_ns();
    sample.for_tick = input.for_tick();
    if (input.has_left()) {
      auto hand = checked_hand(input.left(), field + ".left");
      if (!hand) return hand.error();
      sample.hands[0] = *hand;
    }
    if (input.has_right()) {
      auto hand = checked_hand(input.right(), field + ".right");
      if (!hand) return hand.error();
      sample.hands[1] = *hand;
    }
    samples.push_back(sample);
  }
  return samples;
}

Result<std::optional<ViewCone>> check_view(const v1::ClientMessage& message) {
  if (!message.has_view()) return std::optional<ViewCone>();
  const v1::View& said = message.view();
  if (said.position_m_size() != 3) return invalid_argument("view.position_m: must have three numbers");
  if (said.forward_size() != 3) return invalid_argument("view.forward: must have three numbers");
  ViewCone view;
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(said.position_m(i)) <= kMaxHandPosition_m))
      return invalid_argument("view.position_m: must be finite and within 1000 m");
    view.position_m[i] = said.position_m(i);
    view.forward[i] = said.forward(i);
  }
  if (!(std::abs(view.forward.norm() - 1.0) <= 0.01))
    return invalid_argument("view.forward: must have length 1");
  view.forward.normalize();
  if (!(said.half_angle_rad() >= 0 && said.half_angle_rad() <= 3.1416f))
    return invalid_argument("view.half_angle_rad: must be in 0..pi");
  view.half_angle_rad = said.half_angle_rad();
  return std::optional(view);
}

}  // namespace livegs
