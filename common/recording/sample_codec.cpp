// SPDX-License-Identifier: Apache-2.0
#include "recording/sample_codec.h"

#include <bit>
#include <cmath>

#include "wire/varint.h"

namespace livegs {
namespace {

constexpr uint8_t kExact = 16, kReservedSampleFlags = 0xE0;

// Calls the functions for each value of the sample, poses first.
template <class Sample, class UsePose, class UseButton>
void each_value(Sample& sample, UsePose use_pose, UseButton use_button) {
  for (auto& hand : sample.hands) {
    for (auto* pose : {&hand.aim, &hand.grip}) {
      for (int k = 0; k < 3; ++k) use_pose(pose->position_m[k]);
      for (int k = 0; k < 4; ++k) use_pose(pose->orientation.coeffs()[k]);
    }
  }
  for (auto& hand : sample.hands) {
    use_button(hand.trigger);
    use_button(hand.squeeze);
  }
}

}  // namespace

void write_sample(ByteWriter& out, const InputSample& sample, uint64_t tick, SampleBefore& before) {
  write_varint(out, sample.sequence - before.sequence);
  write_varint(out, zigzag(static_cast<int64_t>(static_cast<uint64_t>(sample.sampled_ns) -
                                                static_cast<uint64_t>(before.sampled_ns))));
  write_varint(out, zigzag(static_cast<int64_t>(sample.for_tick - tick)));
  std::array<uint32_t, kSampleValues> bits{};
  bool exact = false;
  size_t at = 0;
  each_value(
      sample,
      [&](double value) {
        const auto narrow = static_cast<float>(value);
        exact =
            exact || std::bit_cast<uint64_t>(static_cast<double>(narrow)) != std::bit_cast<uint64_t>(value);
        bits[at++] = std::bit_cast<uint32_t>(narrow);
      },
      [&](float value) { bits[at++] = std::bit_cast<uint32_t>(value); });
  uint8_t flags = exact ? kExact : 0;
  for (size_t i = 0; i < sample.hands.size(); ++i) {
    flags |=
        static_cast<uint8_t>((sample.hands[i].active ? 1 : 0) << i | (sample.hands[i].shoot ? 4 : 0) << i);
  }
  out.write(flags);
  if (exact) {
    each_value(
        sample, [&](double value) { out.write(value); }, [&](float value) { out.write(value); });
    bits = {};
  } else {
    uint32_t differ = 0;
    for (size_t i = 0; i < bits.size(); ++i) differ |= bits[i] != before.bits[i] ? 1u << i : 0u;
    out.write(differ);
    for (size_t i = 0; i < bits.size(); ++i) {
      if (bits[i] != before.bits[i]) write_varint(out, bits[i] ^ before.bits[i]);
    }
  }
  before = {sample.sequence, sample.sampled_ns, bits};
}

std::optional<InputSample> read_sample(ByteReader& in, uint64_t tick, SampleBefore& before) {
  const auto sequence = read_varint(in), sampled = read_varint(in), meant = read_varint(in);
  const uint8_t flags = in.read<uint8_t>();
  if (!sequence || !sampled || !meant || in.failed() || (flags & kReservedSampleFlags) != 0)
    return std::nullopt;
  InputSample sample;
  sample.sequence = before.sequence + *sequence;
  sample.sampled_ns = static_cast<int64_t>(static_cast<uint64_t>(before.sampled_ns) +
                                           static_cast<uint64_t>(unzigzag(*sampled)));
  sample.for_tick = tick + static_cast<uint64_t>(unzigzag(*meant));
  for (size_t i = 0; i < sample.hands.size(); ++i) {
    sample.hands[i].active = (flags >> i & 1) != 0;
    sample.hands[i].shoot = (flags >> i & 4) != 0;
  }
  std::array<uint32_t, kSampleValues> bits{};
  bool finite = true;
  if ((flags & kExact) != 0) {
    each_value(
        sample, [&](double& value) { value = in.read<double>(); },
        [&](float& value) { value = in.read<float>(); });
  } else {
    bits = before.bits;
    const auto differ = in.read<uint32_t>();
    for (size_t i = 0; i < bits.size(); ++i) {
      if ((differ >> i & 1) == 0) continue;
      const auto change = read_varint(in);
      if (!change || *change > UINT32_MAX) return std::nullopt;
      bits[i] ^= static_cast<uint32_t>(*change);
    }
    size_t at = 0;
    each_value(
        sample, [&](double& value) { value = static_cast<double>(std::bit_cast<float>(bits[at++])); },
        [&](float& value) { value = std::bit_cast<float>(bits[at++]); });
  }
  each_value(
      sample, [&](double value) { finite = finite && std::isfinite(value); },
      [&](float value) { finite = finite && std::isfinite(value); });
  if (in.failed() || !finite) return std::nullopt;
  before = {sample.sequence, sample.sampled_ns, bits};
  return sample;
}

}  // namespace livegs
