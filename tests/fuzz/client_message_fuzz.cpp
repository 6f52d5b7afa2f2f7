// SPDX-License-Identifier: Apache-2.0
// A livegs.v1.ClientMessage as the server takes it: what passes its check goes into the simulation and into
// recordings.
#include <cmath>

#include "fuzz/fuzz_target.h"
#include "recording/sample_codec.h"
#include "session/simulation/input_check.h"
#include "stream/session/input_message.h"

namespace livegs::fuzz::client_message_fuzz {
namespace {

bool same(const Pose& a, const Pose& b) {
  // A quaternion that is sent as floats is normalised again by who reads it.
  return a.position_m == b.position_m &&
         (a.orientation.coeffs() - b.orientation.coeffs()).cwiseAbs().maxCoeff() < 2e-7;
}

void check_sample(const InputSample& sample) {
  for (const HandSample& hand : sample.hands) {
    if (!hand.active) continue;
    for (const Pose* pose : {&hand.aim, &hand.grip}) {
      check(pose->position_m.allFinite() && pose->position_m.cwiseAbs().maxCoeff() <= kMaxHandPosition_m,
            "hands are near");
      check(std::abs(pose->orientation.norm() - 1.0) < 1e-6, "hands are turned by rotations");
    }
    for (const float value : {hand.trigger, hand.squeeze})
      check(value >= 0 && value <= 1, "a trigger is between 0 and 1");
  }
}

// What a client would send of it passes too, and means the same.
void check_sent_again(const std::vector<InputSample>& samples) {
  v1::ClientMessage message;
  for (const InputSample& sample : samples) write_input(sample, *message.add_inputs());
  const auto again = check_inputs(message);
  check(again && again->size() == samples.size(), "what passed can be sent");
  for (size_t i = 0; i < samples.size(); ++i) {
    const InputSample &a = samples[i], &b = (*again)[i];
    check(a.sequence == b.sequence && a.sampled_ns == b.sampled_ns && a.for_tick == b.for_tick,
          "samples keep their numbers");
    for (size_t hand = 0; hand < 2; ++hand) {
      check(a.hands[hand].active == b.hands[hand].active, "hands are there or not");
      check(same(a.hands[hand].aim, b.hands[hand].aim) && same(a.hands[hand].grip, b.hands[hand].grip),
            "hands stay");
    }
  }
}

// A recording holds it to the bit.
void check_recorded(const std::vector<InputSample>& samples) {
  SampleBefore written, read;
  ByteWriter out;
  for (const InputSample& sample : samples) write_sample(out, sample, 7, written);
  const Bytes bytes = std::move(out).take();
  ByteReader in(bytes);
  for (const InputSample& sample : samples) {
    const auto again = read_sample(in, 7, read);
    check(again.has_value(), "a sample that was recorded is read");
    check(again->sequence == sample.sequence && again->sampled_ns == sample.sampled_ns,
          "and has its numbers");
    for (size_t hand = 0; hand < 2; ++hand) {
      const HandSample &a = sample.hands[hand], &b = again->hands[hand];
      check(a.active == b.active && a.aim.position_m == b.aim.position_m &&
                a.aim.orientation.coeffs() == b.aim.orientation.coeffs() &&
                a.grip.position_m == b.grip.position_m &&
                a.grip.orientation.coeffs() == b.grip.orientation.coeffs() && a.trigger == b.trigger &&
                a.squeeze == b.squeeze && a.shoot == b.shoot,
            "and its hands to the bit");
    }
  }
  check(in.remaining() == 0, "nothing is left over");
}

}  // namespace

void look_at(std::span<const std::byte> input) {
  v1::ClientMessage message;
  if (!message.ParseFromArray(input.data(), static_cast<int>(input.size()))) return;
  if (const auto view = check_view(message); view && *view) {
    check((*view)->position_m.allFinite() && std::abs((*view)->forward.norm() - 1.0) < 1e-9,
          "a view is a place and a direction");
    check((*view)->half_angle_rad >= 0 && (*view)->half_angle_rad < 3.15, "and a cone");
    v1::ClientMessage again;
    write_view(**view, *again.mutable_view());
    check(check_view(again).has_value(), "which can be sent");
  }
  const auto samples = check_inputs(message);
  if (!samples) return;
  for (const InputSample& sample : *samples) check_sample(sample);
  check_sent_again(*samples);
  check_recorded(*samples);
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> seeds;
  for (int hands = 0; hands < 4; ++hands) {
    v1::ClientMessage message;
    message.set_session_id("0123456789abcdef0123456789abcdef");
    message.set_acknowledged_tick(12);
    message.set_sent_ns(1'000'000'007);
    message.set_key_frame_wanted(hands == 2);
    for (uint64_t i = 1; i <= 3; ++i) {
      InputSample sample;
      sample.sequence = i;
      sample.sampled_ns = static_cast<int64_t>(i) * 11'111'111;
      sample.for_tick = 100 + i;
      for (size_t hand = 0; hand < 2; ++hand) {
        sample.hands[hand].active = (hands >> hand & 1) != 0;
        sample.hands[hand].aim.position_m = {0.25, 1.5, -0.125 * static_cast<double>(i)};
        sample.hands[hand].grip.orientation =
            Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
        sample.hands[hand].trigger = 0.5f;
        sample.hands[hand].shoot = i == 2;
      }
      write_input(sample, *message.add_inputs());
    }
    if (hands == 1) write_view({{1, 2, 3}, {0, 0, -1}, 0.75}, *message.mutable_view());
    const std::string text = message.SerializeAsString();
    const auto bytes = std::as_bytes(std::span(text));
    seeds.emplace_back(bytes.begin(), bytes.end());
  }
  return seeds;
}

[[maybe_unused]] const bool kAdded = add_target({"client_message", look_at, seeds});

}  // namespace livegs::fuzz::client_message_fuzz
