// SPDX-License-Identifier: Apache-2.0
#include "stream/session/input_message.h"

namespace livegs {
namespace {

using Floats = google::protobuf::RepeatedField<float>;

void write_pose(const Pose& pose, Floats& position, Floats& orientation) {
  for (int i = 0; i < 3; ++i) position.Add(static_cast<float>(pose.position_m[i]));
  orientation.Add(static_cast<float>(pose.orientation.w()));
  orientation.Add(static_cast<float>(pose.orientation.x()));
  orientation.Add(static_cast<float>(pose.orientation.y()));
  orientation.Add(static_cast<float>(pose.orientation.z()));
}

void write_hand(const HandSample& hand, v1::HandInput& message) {
  write_pose(hand.aim, *message.mutable_aim_position_m(), *message.mutable_aim_orientation());
  write_pose(hand.grip, *message.mutable_grip_position_m(), *message.mutable_grip_orientation());
  message.set_trigger(hand.trigger);
  message.set_squeeze(hand.squeeze);
  message.set_shoot(hand.shoot);
}

}  // namespace

void write_input(const InputSample& sample, v1::Input& message) {
  message.set_sequence(sample.sequence);
  message.set_sampled_ns(sample.sampled_ns);
  message.set_for_tick(sample.for_tick);
  if (sample.hands[0].active) write_hand(sample.hands[0], *message.mutable_left());
  if (sample.hands[1].active) write_hand(sample.hands[1], *message.mutable_right());
}

void write_view(const ViewCone& view, v1::View& message) {
  for (int i = 0; i < 3; ++i) {
    message.add_position_m(static_cast<float>(view.position_m[i]));
    message.add_forward(static_cast<float>(view.forward[i]));
  }
  message.set_half_angle_rad(static_cast<float>(view.half_angle_rad));
}

}  // namespace livegs
